// Odometry over a data set: a pose for each stereo pair, printed as TUM lines.
//   odometry DATASET [PRESET]

#include <cstdio>

#include "gluevo/nn/error.h"
#include "gluevo/vo/pipeline/odometry.h"
#include "gluevo/vo/pipeline/presets.h"

int main(int argc, char** argv) try {
  if (argc < 2) {
    std::fprintf(stderr, "usage: %s DATASET [PRESET]\n", argv[0]);
    return 2;
  }
  const gluevo::vo::Dataset dataset = gluevo::vo::OpenDataset(argv[1], {});
  const std::string preset = argc > 2 ? argv[2] : gluevo::vo::PresetOf(dataset.format);
  gluevo::vo::Odometry odometry(dataset.rig, gluevo::vo::PresetConfig(preset));
  for (std::size_t i = 0; i < dataset.entries.size(); ++i) {
    const gluevo::vo::FrameResult result = odometry.Process(dataset.Read(i));
    const Eigen::Vector3d& p = result.world_from_body.translation;
    const Eigen::Vector4d& q = result.world_from_body.rotation.coeffs();  // x y z w
    std::printf("%.9f %.9g %.9g %.9g %.9g %.9g %.9g %.9g\n",
                1e-9 * static_cast<double>(result.timestamp_ns), p.x(), p.y(), p.z(), q[0], q[1],
                q[2], q[3]);
  }
  return 0;
} catch (const gluevo::Error& error) {
  std::fprintf(stderr, "error: %s\n", error.what());
  return 1;
}
