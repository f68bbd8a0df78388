// Method 2 with the open weights on real images. The bounds are those that the project promises for
// these data; they are not what this build happens to reach.

#include <gtest/gtest.h>

#include <filesystem>
#include <memory>
#include <string>

#include "gluevo/vo/evaluation/evaluation.h"
#include "gluevo/vo/frontend/learned_frontend.h"
#include "gluevo/vo/frontend/network_matcher.h"
#include "gluevo/vo/io/dataset.h"
#include "gluevo/vo/pipeline/odometry.h"

namespace gluevo::vo {
namespace {

struct RunResult {
  Evaluation evaluation;
  std::size_t frames = 0;
  int breaks = 0;
};

RunResult RunMethod2(const std::filesystem::path& path, const DatasetOptions& options = {}) {
  const Dataset dataset = OpenDataset(path, options);
  nn::ThreadPool pool;
  const auto superpoint = std::make_shared<nn::SuperPoint>(nn::OpenSuperPointWeights());
  const auto superglue = std::make_shared<nn::SuperGlue>(nn::OpenSuperGlueWeights());
  Odometry odometry(
      dataset.rig,
      std::make_unique<LearnedFrontEnd>(
          dataset.rig, MakeSuperPointExtractor(superpoint, {.max_keypoints = 500}, pool),
          MakeSuperGlueMatcher(superglue, 100, pool), MakeNearestNeighborMatcher(),
          LearnedFrontEndOptions{}),
      {});
  RunResult result;
  Trajectory trajectory;
  for (std::size_t i = 0; i < dataset.entries.size(); ++i) {
    const FrameResult frame = odometry.Process(dataset.Read(i));
    trajectory.push_back({frame.timestamp_ns, frame.world_from_body});
    result.breaks = frame.segment;
  }
  result.frames = trajectory.size();
  result.evaluation = Evaluate(trajectory, *dataset.groundtruth, {});
  return result;
}

class EndToEndTest : public testing::Test {
 protected:
  void SetUp() override {
    if (!std::filesystem::exists(Data())) {
      GTEST_SKIP() << "no real data at " << Data();
    }
  }
  static std::filesystem::path Data() { return std::filesystem::path(GLUEVO_SHARED_DIR) / "data"; }
};

TEST_F(EndToEndTest, DrivingOnKitti06) {
  const RunResult result = RunMethod2(Data() / "kitti" / "sequences" / "06");
  EXPECT_EQ(result.frames, 51U);
  EXPECT_EQ(result.breaks, 0);
  EXPECT_LT(result.evaluation.ate_se3_m, 0.12);
  EXPECT_LT(result.evaluation.rpe_translation_percent, 1.2);
}

TEST_F(EndToEndTest, FarApartKeyFramesOfEurocV101) {
  const RunResult result = RunMethod2(Data() / "euroc_V1_01_keyframes");
  EXPECT_EQ(result.frames, 100U);
  EXPECT_GE(result.evaluation.correct_motions, 90U);
  // What is not right must be said to be a break. Two motions may miss the bounds by a little.
  EXPECT_GE(static_cast<int>(result.evaluation.correct_motions) + result.breaks, 97);
}

TEST_F(EndToEndTest, StandingStillOnEurocV101) {
  const RunResult result = RunMethod2(Data() / "euroc_V1_01_start");
  EXPECT_EQ(result.frames, 24U);
  EXPECT_EQ(result.breaks, 0);
  EXPECT_LT(result.evaluation.ate_se3_m, 0.02);
}

}  // namespace
}  // namespace gluevo::vo
