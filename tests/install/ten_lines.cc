// Odometry in ten lines, as docs/LIBRARY.md shows it.

#include <gluevo/vo/pipeline/odometry.h>
#include <gluevo/vo/pipeline/presets.h>

#include <iostream>

int main(int /*argc*/, char** argv) {
  namespace vo = gluevo::vo;
  const vo::Dataset dataset = vo::OpenDataset(argv[1], {});
  vo::Odometry odometry(dataset.rig, vo::PresetConfig(vo::PresetOf(dataset.format)));
  for (std::size_t i = 0; i < dataset.entries.size(); ++i) {
    const vo::FrameResult result = odometry.Process(dataset.Read(i));
    std::cout << result.timestamp_ns << ' ' << result.world_from_body.translation.transpose()
              << '\n';
  }
}
