#include "covariance_file.h"

#include <iomanip>
#include <ostream>
#include <string_view>

#include "gluevo/nn/output_file.h"

namespace gluevo::apps {
namespace {

constexpr const char* kAxes[] = {"x", "y", "z", "rx", "ry", "rz"};

void WriteNames(std::ostream& out, std::string_view of) {
  for (int row = 0; row < 6; ++row) {
    for (int column = row; column < 6; ++column) {
      out << ',' << of << '_' << kAxes[row] << '_' << kAxes[column];
    }
  }
}

void WriteUpperTriangle(std::ostream& out, const vo::PoseCovariance& covariance) {
  for (int row = 0; row < 6; ++row) {
    for (int column = row; column < 6; ++column) {
      out << ',' << covariance(row, column);
    }
  }
}

}  // namespace

void WriteCovariances(const std::filesystem::path& path, const std::vector<vo::FrameResult>& frames,
                      const std::string& body_frame) {
  nn::WriteWholeFile(path, [&](std::ostream& out) {
    constexpr int kDigits = 9;
    out << std::setprecision(kDigits) << "# covariances of poses of the " << body_frame
        << ": path, in the frame of the segment's first pose; motion, in its frame at from_ns. "
           "Errors in its own axes: x y z in metres, rx ry rz in radians; upper triangles\n"
        << "#timestamp_ns,segment,predicted";
    WriteNames(out, "path");
    out << ",from_ns";
    WriteNames(out, "motion");
    out << '\n';
    for (const vo::FrameResult& frame : frames) {
      out << frame.timestamp_ns << ',' << frame.segment << ',' << (frame.is_predicted ? 1 : 0);
      WriteUpperTriangle(out, frame.path_covariance);
      out << ',' << frame.motion_from_ns;
      WriteUpperTriangle(out, frame.motion_covariance);
      out << '\n';
    }
  });
}

}  // namespace gluevo::apps
