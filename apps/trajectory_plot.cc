#include "trajectory_plot.h"

#include <iomanip>
#include <vector>

#include "gluevo/nn/output_file.h"

namespace gluevo::apps {
namespace {

constexpr double kSize = 640.0;  // Of the drawing, pixels.
constexpr double kMargin = 50.0;

}  // namespace

void WriteTrajectoryPlot(const std::filesystem::path& path, const TrajectoryLines& lines,
                         const std::string& caption) {
  const PlanView view = ChooseView(lines);
  const double scale = (kSize - 2.0 * kMargin) / view.Extent();
  nn::WriteWholeFile(path, [&](std::ostream& out) {
    out << std::fixed << std::setprecision(1);
    out << "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 " << kSize << ' ' << kSize
        << "\" font-family=\"sans-serif\" font-size=\"14\">\n"
        << "<rect width=\"100%\" height=\"100%\" fill=\"white\"/>\n";
    const auto draw = [&](const std::vector<Eigen::Vector3d>& points, const char* color) {
      out << "<polyline fill=\"none\" stroke=\"" << color << "\" stroke-width=\"2\" points=\"";
      for (const Eigen::Vector3d& point : points) {
        out << kMargin + scale * (point[view.across] - view.box.min()[view.across]) << ','
            << kSize - kMargin - scale * (point[view.up] - view.box.min()[view.up]) << ' ';
      }
      out << "\"/>\n";
    };
    draw(lines.groundtruth, "#999999");
    for (const std::vector<Eigen::Vector3d>& line : lines.estimate) {
      draw(line, "#d6404e");
    }
    const char* const names = "xyz";
    out << "<text x=\"" << kMargin << "\" y=\"25\">"
        << "<tspan fill=\"#999999\">ground truth</tspan> <tspan fill=\"#d6404e\">estimate</tspan> "
        << caption << "</text>\n"
        << std::setprecision(2) << "<text x=\"" << kMargin << "\" y=\"" << kSize - 15.0 << "\">"
        << names[view.across] << " across, " << names[view.up] << " up; the square is "
        << view.Extent() << " m wide</text>\n</svg>\n";
  });
}

}  // namespace gluevo::apps
