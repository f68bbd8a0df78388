// About which candidates the network is asked.

#include <gtest/gtest.h>

#include <memory>
#include <numbers>

#include "gluevo/vo/frontend/network_matcher.h"
#include "gluevo/vo/mapping/loop_closer.h"
#include "gluevo/vo/mapping/place_training.h"
#include "vo/mapping/loop_scene.h"
#include "vo/mapping/recorder_scene.h"

namespace gluevo::vo {
namespace {

// Nearest neighbours for a network; counts how often it is asked.
class CountingMatcher final : public Matcher {
 public:
  nn::Matches Match(const nn::Features& features0, const nn::Features& features1,
                    float threshold) override {
    ++asked;
    return nearest_->Match(features0, features1, threshold);
  }
  int asked = 0;

 private:
  std::unique_ptr<Matcher> nearest_ = MakeNearestNeighborMatcher();
};

constexpr int kStepsAround = 31;  // PlaceAt's half round.

// Key frames 20 seconds apart at the steps' places, by an odometry that is right.
LoopCloser Visit(const std::vector<int>& steps, const std::shared_ptr<Matcher>& matcher,
                 const LoopVerificationOptions& verification) {
  const std::vector<Eigen::Vector3d> room = testing::RoomPoints(6000, 4.0, 3);
  const StereoRig rig = testing::SimulatedRig();
  LoopCloser closer(
      rig,
      TrainPlaceCodebook({testing::Look(rig, room, testing::PlaceAt(0)).left,
                          testing::Look(rig, room, testing::PlaceAt(kStepsAround)).left},
                         "", {.centres = 8}),
      matcher, {.min_similarity = -1.0, .min_similarity_share = 0.0, .verification = verification});
  int64_t now_ns = 0;
  for (const int step : steps) {
    const Rigid3 place = testing::PlaceAt(step);
    LoopKeyframe keyframe = testing::MakeLoopKeyframe(rig, room, place, place, now_ns);
    if (!closer.keyframes().empty()) {
      keyframe.motion = closer.keyframes().back().world_from_body.Inverse() * place;
    }
    keyframe.motion_covariance.diagonal().setConstant(1e-4);
    closer.Add(std::move(keyframe));
    now_ns += 20'000'000'000;
  }
  return closer;
}

TEST(LoopCandidates, TheNetworkIsNotAskedWhereNearestNeighboursSeeEnough) {
  const auto matcher = std::make_shared<CountingMatcher>();
  const LoopCloser closer = Visit({0, 0}, matcher, {});
  ASSERT_EQ(closer.loops().size(), 1U);
  EXPECT_GE(closer.loops()[0].inliers, LoopVerificationOptions().enough_nearest);
  EXPECT_EQ(matcher->asked, 0);
}

TEST(LoopCandidates, TheNetworkIsAskedWhereTheySeeSomething) {
  const auto matcher = std::make_shared<CountingMatcher>();
  const LoopCloser closer = Visit({0, 1}, matcher, {.enough_nearest = 10'000});
  EXPECT_EQ(closer.loops().size(), 1U);
  EXPECT_EQ(matcher->asked, 1);
}

TEST(LoopCandidates, TheNetworkIsNotAskedWhereTooLittleLooksAlike) {
  const auto matcher = std::make_shared<CountingMatcher>();
  const LoopCloser closer =
      Visit({0, 3}, matcher, {.min_nearest = 10'000, .enough_nearest = 10'000});
  EXPECT_TRUE(closer.loops().empty());
  EXPECT_EQ(matcher->asked, 0);
  // It is told why.
  ASSERT_EQ(closer.attempts().size(), 1U);
  EXPECT_NE(closer.attempts()[0].reason.find("matches"), std::string::npos);
}

TEST(LoopCandidates, ThatLookMostAlikeGoFirst) {
  // Both are asked about in vain; the one that is nearer to the last place looks more like it.
  const auto matcher = std::make_shared<CountingMatcher>();
  const LoopCloser closer =
      Visit({4, 1, 0}, matcher, {.min_nearest = 1, .enough_nearest = 10'000, .min_fields = 17});
  ASSERT_GE(closer.attempts().size(), 3U);
  const auto last = closer.attempts().end() - 2;
  EXPECT_EQ(last[0].candidate_ns, 20'000'000'000);
  EXPECT_EQ(last[1].candidate_ns, 0);
  EXPECT_GT(last[0].matches, last[1].matches);
}

}  // namespace
}  // namespace gluevo::vo
