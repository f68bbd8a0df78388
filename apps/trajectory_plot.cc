#include "trajectory_plot.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <iomanip>
#include <string>
#include <vector>

#include "gluevo/nn/output_file.h"

namespace gluevo::apps {
namespace {

constexpr double kSize = 640.0;  // Of the drawing, pixels.
constexpr double kMargin = 50.0;

}  // namespace

void WriteTrajectoryPlot(const std::filesystem::path& path, const vo::Trajectory& estimate,
                         const vo::Trajectory& groundtruth, const vo::Evaluation& evaluation) {
  std::vector<Eigen::Vector3d> truth_points;
  std::vector<Eigen::Vector3d> estimate_points;
  Eigen::AlignedBox3d truth_box;
  Eigen::AlignedBox3d box;
  for (const vo::StampedPose& pose : groundtruth) {
    truth_points.push_back(pose.world_from_body.translation);
    truth_box.extend(truth_points.back());
  }
  box = truth_box;
  for (const vo::StampedPose& pose : estimate) {
    estimate_points.push_back(evaluation.groundtruth_world_from_estimate_world *
                              pose.world_from_body.translation);
    box.extend(estimate_points.back());
  }
  std::array<int, 3> axes = {0, 1, 2};
  std::stable_sort(axes.begin(), axes.end(),
                   [&](int a, int b) { return truth_box.sizes()[a] > truth_box.sizes()[b]; });
  const int across = std::min(axes[0], axes[1]);
  const int up = std::max(axes[0], axes[1]);
  const double extent = std::max({box.sizes()[across], box.sizes()[up], 1e-6});
  const double scale = (kSize - 2.0 * kMargin) / extent;

  nn::WriteWholeFile(path, [&](std::ostream& out) {
    out << std::fixed << std::setprecision(1);
    out << "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 " << kSize << ' ' << kSize
        << "\" font-family=\"sans-serif\" font-size=\"14\">\n"
        << "<rect width=\"100%\" height=\"100%\" fill=\"white\"/>\n";
    const auto draw = [&](const std::vector<Eigen::Vector3d>& points, const char* color) {
      out << "<polyline fill=\"none\" stroke=\"" << color << "\" stroke-width=\"2\" points=\"";
      for (const Eigen::Vector3d& point : points) {
        out << kMargin + scale * (point[across] - box.min()[across]) << ','
            << kSize - kMargin - scale * (point[up] - box.min()[up]) << ' ';
      }
      out << "\"/>\n";
    };
    draw(truth_points, "#999999");
    draw(estimate_points, "#d6404e");
    const char* const names = "xyz";
    out << std::setprecision(4) << "<text x=\"" << kMargin << "\" y=\"25\">"
        << "<tspan fill=\"#999999\">ground truth</tspan> <tspan fill=\"#d6404e\">estimate</tspan> "
        << "ATE " << evaluation.ate_se3_m << " m (SE3), " << evaluation.ate_sim3_m
        << " m (Sim3)</text>\n"
        << std::setprecision(2) << "<text x=\"" << kMargin << "\" y=\"" << kSize - 15.0 << "\">"
        << names[across] << " across, " << names[up] << " up; the square is " << extent
        << " m wide</text>\n</svg>\n";
  });
}

}  // namespace gluevo::apps
