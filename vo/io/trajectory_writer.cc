#include <cstdint>
#include <cstdio>
#include <iomanip>
#include <sstream>

#include "gluevo/nn/output_file.h"
#include "gluevo/vo/io/trajectory_file.h"

namespace gluevo::vo {
namespace {

std::string FormatSeconds(int64_t nanoseconds) {
  constexpr int64_t kSecond = 1'000'000'000;
  const bool negative = nanoseconds < 0;
  const uint64_t magnitude = negative ? uint64_t{0} - static_cast<uint64_t>(nanoseconds)
                                      : static_cast<uint64_t>(nanoseconds);
  char text[32];
  std::snprintf(text, sizeof(text), "%s%llu.%09llu", negative ? "-" : "",
                static_cast<unsigned long long>(magnitude / kSecond),
                static_cast<unsigned long long>(magnitude % kSecond));
  return text;
}

}  // namespace

void WriteTrajectory(const std::filesystem::path& path, const Trajectory& trajectory,
                     TrajectoryFormat format, const std::string& header) {
  nn::WriteWholeFile(path, [&](std::ostream& out) {
    // Enough digits that reading gives the same double.
    out << std::setprecision(17);
    if (format != TrajectoryFormat::kKitti) {
      std::istringstream header_lines(header);
      for (std::string line; std::getline(header_lines, line);) {
        out << "# " << line << '\n';
      }
      out << (format == TrajectoryFormat::kTum ? "# t[s] x y z qx qy qz qw\n"
                                               : "# t[ns],x,y,z,qw,qx,qy,qz\n");
    }
    for (const StampedPose& pose : trajectory) {
      const Eigen::Vector3d& t = pose.world_from_body.translation;
      const Eigen::Quaterniond& q = pose.world_from_body.rotation;
      switch (format) {
        case TrajectoryFormat::kTum:
          out << FormatSeconds(pose.timestamp_ns) << ' ' << t.x() << ' ' << t.y() << ' ' << t.z()
              << ' ' << q.x() << ' ' << q.y() << ' ' << q.z() << ' ' << q.w() << '\n';
          break;
        case TrajectoryFormat::kEuroc:
          out << pose.timestamp_ns << ',' << t.x() << ',' << t.y() << ',' << t.z() << ',' << q.w()
              << ',' << q.x() << ',' << q.y() << ',' << q.z() << '\n';
          break;
        case TrajectoryFormat::kKitti: {
          const Eigen::Matrix<double, 3, 4> matrix = pose.world_from_body.Matrix();
          for (int i = 0; i < 12; ++i) {
            out << (i > 0 ? " " : "") << matrix(i / 4, i % 4);
          }
          out << '\n';
          break;
        }
      }
    }
  });
}

}  // namespace gluevo::vo
