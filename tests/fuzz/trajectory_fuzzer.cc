#include <cmath>
#include <cstddef>
#include <cstdint>
#include <string_view>

#include "gluevo/nn/error.h"
#include "gluevo/vo/io/trajectory_file.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, std::size_t size) {
  using namespace gluevo;
  const std::string_view text(reinterpret_cast<const char*>(data), size);
  try {
    const vo::TrajectoryFile file = vo::ParseTrajectory(text, "file");
    // What is read has poses, of finite numbers and in order.
    for (std::size_t i = 0; i < file.poses.size(); ++i) {
      const vo::Rigid3& pose = file.poses[i].world_from_body;
      if (!pose.translation.allFinite() || !(std::abs(pose.rotation.norm() - 1.0) < 1e-6) ||
          (i > 0 && file.poses[i].timestamp_ns <= file.poses[i - 1].timestamp_ns)) {
        __builtin_trap();
      }
    }
  } catch (const Error&) {  // The one answer that a broken file may get.
  }
  return 0;
}
