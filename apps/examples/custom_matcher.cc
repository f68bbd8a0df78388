// A matcher of one's own in place of SuperGlue: mutual nearest descriptors that are also near each
// other in the image. Prints how many of the data set's frames it kept linked.
//   custom_matcher DATASET

#include <cstdio>
#include <memory>
#include <utility>

#include "gluevo/nn/error.h"
#include "gluevo/vo/frontend/learned_frontend.h"
#include "gluevo/vo/frontend/network_matcher.h"
#include "gluevo/vo/pipeline/odometry.h"
#include "gluevo/vo/pipeline/presets.h"

namespace {

namespace nn = gluevo::nn;
namespace vo = gluevo::vo;

class NearbyMatcher final : public vo::Matcher {
 public:
  nn::Matches Match(const nn::Features& features0, const nn::Features& features1,
                    float threshold) override {
    constexpr float kLargestMotionPx = 120.0F;
    nn::Matches matches = nearest_->Match(features0, features1, threshold);
    for (std::size_t i = 0; i < matches.matches0.size(); ++i) {
      const int j = matches.matches0[i];
      if (j >= 0 &&
          (features0.keypoints.row(static_cast<Eigen::Index>(i)) - features1.keypoints.row(j))
                  .norm() > kLargestMotionPx) {
        matches.matches0[i] = -1;
        matches.scores0[i] = 0.0F;
      }
    }
    return matches;
  }

 private:
  std::unique_ptr<vo::Matcher> nearest_ = vo::MakeNearestNeighborMatcher();
};

}  // namespace

int main(int argc, char** argv) try {
  if (argc != 2) {
    std::fprintf(stderr, "usage: %s DATASET\n", argv[0]);
    return 2;
  }
  const vo::Dataset dataset = vo::OpenDataset(argv[1], {});
  const vo::OdometryConfig config = vo::PresetConfig(vo::PresetOf(dataset.format));
  nn::ThreadPool pool(config.threads);
  const vo::Networks networks = vo::LoadNetworks({}, "superpoint", "nn");
  auto frontend = std::make_unique<vo::LearnedFrontEnd>(
      dataset.rig, vo::MakeExtractor(networks, config.frontend.keypoints, pool),
      std::make_unique<NearbyMatcher>(), /*fallback=*/nullptr, config.frontend.learned);
  vo::Odometry odometry(dataset.rig, std::move(frontend), config.odometry);
  vo::FrameResult result;
  for (std::size_t i = 0; i < dataset.entries.size(); ++i) {
    result = odometry.Process(dataset.Read(i));
  }
  std::printf("frames: %zu, segments: %d\n", dataset.entries.size(), result.segment + 1);
  return 0;
} catch (const gluevo::Error& error) {
  std::fprintf(stderr, "error: %s\n", error.what());
  return 1;
}
