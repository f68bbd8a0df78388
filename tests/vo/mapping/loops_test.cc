// From two looks at a place to a path that fits them: verification, consistency, closing.

#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <numbers>

#include "gluevo/vo/frontend/network_matcher.h"
#include "gluevo/vo/geometry/manifold.h"
#include "gluevo/vo/geometry/pose_uncertainty.h"
#include "gluevo/vo/mapping/loop_closer.h"
#include "gluevo/vo/mapping/loop_consistency.h"
#include "gluevo/vo/mapping/loop_verification.h"
#include "gluevo/vo/mapping/place_training.h"
#include "vo/mapping/loop_scene.h"

namespace gluevo::vo {
namespace {

constexpr int64_t kStepNs = 1'000'000'000;

const std::vector<Eigen::Vector3d>& Room() {
  static const std::vector<Eigen::Vector3d> points = testing::RoomPoints(1500, 4.0, 3);
  return points;
}

Rigid3 PlaceAt(double angle) {
  return {ExpSo3({0.0, 0.0, angle}), {1.5 * std::cos(angle), 1.5 * std::sin(angle), 0.1}};
}

LoopCheck Verify(const LoopKeyframe& query, const LoopKeyframe& candidate,
                 const LoopVerificationOptions& options = {}) {
  return VerifyLoop(testing::SimulatedRig(), query, candidate, *MakeNearestNeighborMatcher(),
                    options);
}

LoopKeyframe KeyframeAt(double angle) {
  return testing::MakeLoopKeyframe(testing::SimulatedRig(), Room(), PlaceAt(angle), PlaceAt(angle),
                                   0);
}

TEST(LoopVerification, TwoLooksAtAPlaceTellTheMotionBetween) {
  const LoopCheck check = Verify(KeyframeAt(0.3), KeyframeAt(0.1));
  ASSERT_TRUE(check.measurement) << check.reason;
  EXPECT_GE(check.inliers, 30);
  // Keypoints are stored in single precision: 1e-5 pixels.
  EXPECT_LT(
      Minus(check.measurement->candidate_from_query, PlaceAt(0.1).Inverse() * PlaceAt(0.3)).norm(),
      1e-5);
  const double sigma = std::sqrt(check.measurement->covariance.topLeftCorner<3, 3>().trace());
  EXPECT_GT(sigma, 1e-4);
  EXPECT_LT(sigma, 0.1);
}

TEST(LoopVerification, OtherPlacesHaveTooFewMatches) {
  const LoopCheck check = Verify(KeyframeAt(0.0), KeyframeAt(std::numbers::pi));
  EXPECT_FALSE(check.measurement);
  EXPECT_NE(check.reason.find("matches"), std::string::npos) << check.reason;
}

TEST(LoopVerification, MatchesInOneCornerOfTheImageAreRefused) {
  const LoopKeyframe query = testing::MakeLoopKeyframe(
      testing::SimulatedRig(), testing::RoomPoints(8000, 4.0, 3), PlaceAt(0.1), PlaceAt(0.1), 0);
  LoopKeyframe corner = query;
  std::vector<int> kept;
  for (int i = 0; i < query.features.size(); ++i) {
    if (query.features.keypoints(i, 0) < 376.0F && query.features.keypoints(i, 1) < 240.0F) {
      kept.push_back(i);
    }
  }
  corner.features.keypoints = query.features.keypoints(kept, Eigen::all).eval();
  corner.features.descriptors = query.features.descriptors(kept, Eigen::all).eval();
  corner.keypoints.clear();
  for (const int i : kept) {
    corner.keypoints.push_back(query.keypoints[i]);
  }
  LoopVerificationOptions options;
  options.min_matches = 10;
  options.min_inliers = 10;
  const LoopCheck check = Verify(query, corner, options);
  EXPECT_FALSE(check.measurement);
  EXPECT_NE(check.reason.find("of 16 fields"), std::string::npos) << check.reason;
}

TEST(LoopVerification, MatchesThatFitNoMotionAreRefused) {
  LoopKeyframe shuffled = KeyframeAt(0.1);
  // Descriptors and places no longer belong together.
  shuffled.features.descriptors = shuffled.features.descriptors.colwise().reverse().eval();
  EXPECT_FALSE(Verify(KeyframeAt(0.1), shuffled).measurement);
}

// Key frames a second apart, every motion known to a centimetre and a milliradian.
std::vector<LoopKeyframe> Path(int count, const std::vector<int>& segment_starts = {}) {
  std::vector<LoopKeyframe> keyframes;
  int segment = 0;
  for (int i = 0; i < count; ++i) {
    segment += static_cast<int>(std::count(segment_starts.begin(), segment_starts.end(), i));
    LoopKeyframe keyframe{.timestamp_ns = i * kStepNs, .segment = segment};
    keyframe.world_from_body = {ExpSo3({0.0, 0.0, 0.1 * i}), {0.5 * i, 0.1 * i, 0.0}};
    if (i > 0) {
      keyframe.motion = keyframes.back().world_from_body.Inverse() * keyframe.world_from_body;
    }
    keyframe.motion_covariance.diagonal() << 1e-4, 1e-4, 1e-4, 1e-6, 1e-6, 1e-6;
    keyframes.push_back(keyframe);
  }
  return keyframes;
}

// What odometry says, shifted.
Loop LoopBetween(const std::vector<LoopKeyframe>& keyframes, std::size_t candidate,
                 std::size_t query, double shift_m) {
  Loop loop{candidate, query, {}, 0};
  loop.measurement.candidate_from_query =
      keyframes[candidate].world_from_body.Inverse() * keyframes[query].world_from_body;
  loop.measurement.candidate_from_query.translation.x() += shift_m;
  loop.measurement.covariance.diagonal() << 1e-6, 1e-6, 1e-6, 1e-8, 1e-8, 1e-8;
  return loop;
}

TEST(LoopConsistency, ALoopThatOdometryAllowsIsTrusted) {
  const auto keyframes = Path(30);
  EXPECT_EQ(Judge(LoopBetween(keyframes, 0, 29, 0.02), {}, keyframes, {}), LoopTrust::kTrusted);
}

TEST(LoopConsistency, ALoopThatOdometryRulesOutIsImpossibleWhoeverAgrees) {
  const auto keyframes = Path(30);
  const std::vector<Loop> others = {LoopBetween(keyframes, 1, 27, 20.0),
                                    LoopBetween(keyframes, 2, 25, 20.0)};
  EXPECT_EQ(Judge(LoopBetween(keyframes, 0, 29, 20.0), others, keyframes, {}),
            LoopTrust::kImpossible);
}

TEST(LoopConsistency, ALoopInBetweenWaitsForTwoThatAgree) {
  const auto keyframes = Path(30);
  // Twenty standard deviations of the position alone; the turns before it add some.
  const double sigma = std::sqrt(OdometryBetween(keyframes, 0, 29).covariance(0, 0));
  const Loop loop = LoopBetween(keyframes, 0, 29, 20.0 * sigma);
  std::vector<Loop> others;
  EXPECT_EQ(Judge(loop, others, keyframes, {}), LoopTrust::kUnsupported);
  others.push_back(LoopBetween(keyframes, 1, 27, 20.0 * sigma));
  EXPECT_EQ(Judge(loop, others, keyframes, {}), LoopTrust::kUnsupported);
  // One that says something else, and one that shows the same as the first.
  others.push_back(LoopBetween(keyframes, 2, 25, -20.0 * sigma));
  EXPECT_EQ(Judge(loop, others, keyframes, {}), LoopTrust::kUnsupported);
  others.push_back(LoopBetween(keyframes, 3, 24, 20.0 * sigma));
  EXPECT_EQ(Judge(loop, others, keyframes, {}), LoopTrust::kTrusted);
}

TEST(LoopConsistency, SegmentsAreJoinedByThreeThatAgree) {
  auto keyframes = Path(30, {15});
  // Where the second segment's world is nobody knows.
  const Rigid3 elsewhere = {ExpSo3({0.3, 0.1, 2.0}), {7.0, -3.0, 1.0}};
  std::vector<Loop> loops;
  for (const auto& [candidate, query] :
       {std::pair<std::size_t, std::size_t>{3, 20}, {5, 23}, {6, 26}}) {
    loops.push_back(LoopBetween(keyframes, candidate, query, 0.0));
  }
  for (LoopKeyframe& keyframe : keyframes) {
    if (keyframe.segment == 1) {
      keyframe.world_from_body = elsewhere * keyframe.world_from_body;
    }
  }
  EXPECT_EQ(Judge(loops[0], {loops[1]}, keyframes, {}), LoopTrust::kUnsupported);
  EXPECT_EQ(Judge(loops[0], {loops[1], loops[2]}, keyframes, {}), LoopTrust::kTrusted);
  // One that many points fit needs nobody.
  loops[0].inliers = LoopConsistencyOptions().strong_inliers;
  EXPECT_EQ(Judge(loops[0], {}, keyframes, {}), LoopTrust::kTrusted);
}

TEST(LoopConsistency, ADoubtfulMotionRulesNothingOut) {
  auto keyframes = Path(30);
  const std::vector<Loop> loops = {LoopBetween(keyframes, 1, 27, 20.0),
                                   LoopBetween(keyframes, 2, 25, 20.0)};
  Loop loop = LoopBetween(keyframes, 0, 29, 20.0);
  ASSERT_EQ(Judge(loop, loops, keyframes, {}), LoopTrust::kImpossible);
  EXPECT_FALSE(IsDoubtful(keyframes[10].motion_covariance));
  keyframes[10].motion_covariance =
      DoubtfulMotion(keyframes[10].motion_covariance,
                     keyframes[9].world_from_body.Inverse() * keyframes[10].world_from_body);
  EXPECT_TRUE(IsDoubtful(keyframes[10].motion_covariance));
  // It allows nothing either: who bends the path there needs others, or many points.
  EXPECT_EQ(Judge(LoopBetween(keyframes, 0, 29, 0.0), {}, keyframes, {}), LoopTrust::kUnsupported);
  EXPECT_EQ(Judge(loop, {}, keyframes, {}), LoopTrust::kUnsupported);
  loop.inliers = LoopConsistencyOptions().strong_inliers;
  EXPECT_EQ(Judge(loop, {}, keyframes, {}), LoopTrust::kTrusted);
}

TEST(LoopConsistency, WhatADoubtfulMotionLinksAgreesWithNothing) {
  auto keyframes = Path(30);
  const double sigma = std::sqrt(OdometryBetween(keyframes, 0, 29).covariance(0, 0));
  const Loop loop = LoopBetween(keyframes, 0, 29, 20.0 * sigma);
  const std::vector<Loop> others = {LoopBetween(keyframes, 1, 27, 20.0 * sigma),
                                    LoopBetween(keyframes, 3, 24, 20.0 * sigma)};
  ASSERT_EQ(Judge(loop, others, keyframes, {}), LoopTrust::kTrusted);
  keyframes[28].motion_covariance =
      DoubtfulMotion(keyframes[28].motion_covariance, keyframes[28].motion);
  EXPECT_EQ(Judge(loop, others, keyframes, {}), LoopTrust::kUnsupported);
}

TEST(LoopConsistency, OdometryBetweenIsTheChain) {
  const auto keyframes = Path(12);
  const LoopMeasurement motion = OdometryBetween(keyframes, 2, 9);
  EXPECT_LT(Minus(motion.candidate_from_query,
                  keyframes[2].world_from_body.Inverse() * keyframes[9].world_from_body)
                .norm(),
            1e-12);
  // Seven motions of a milliradian.
  EXPECT_NEAR(motion.covariance(5, 5), 7e-6, 1e-12);
  EXPECT_GT(motion.covariance(1, 1), 7e-4);
}

PlaceCodebook RoomCodebook() {
  return TrainPlaceCodebook({testing::Look(testing::SimulatedRig(), Room(), PlaceAt(0.0)).left,
                             testing::Look(testing::SimulatedRig(), Room(), PlaceAt(2.0)).left,
                             testing::Look(testing::SimulatedRig(), Room(), PlaceAt(4.0)).left},
                            "", {.centres = 8});
}

// Two rounds in a room, twelve key frames each, by an odometry whose heading and height drift; from
// `break_at` on it has lost the world.
struct Rounds {
  LoopCloser closer;
  std::vector<Rigid3> truth;
  double WorstError(const std::vector<Rigid3>& poses) const {
    double worst = 0.0;
    for (std::size_t i = 0; i < poses.size(); ++i) {
      worst = std::max(worst, (poses[i].translation - truth[i].translation).norm());
    }
    return worst;
  }
};

constexpr int kNever = -1;

// At `wrong_at` it takes a motion for another one, and doubts it.
Rounds FlyTwoRounds(int break_at, int wrong_at = kNever) {
  constexpr int kRound = 12;
  Rounds rounds{LoopCloser(testing::SimulatedRig(), RoomCodebook(), MakeNearestNeighborMatcher(),
                           {.min_age_s = 6.0}),
                {}};
  const Rigid3 drift = {ExpSo3({0.0, 0.0, 0.004}), {0.0, 0.01, 0.01}};
  Rigid3 by_odometry = PlaceAt(0.0);
  for (int i = 0; i < 2 * kRound; ++i) {
    const double step = 2.0 * std::numbers::pi / kRound;
    rounds.truth.push_back(PlaceAt(step * i));
    if (i > 0) {
      by_odometry = by_odometry * (rounds.truth[i - 1].Inverse() * rounds.truth[i]) * drift;
    }
    if (i == wrong_at) {
      by_odometry = by_odometry * Rigid3{ExpSo3({0.0, 0.3, 0.4}), {1.0, 0.7, 0.0}};
    }
    if (i == break_at) {
      by_odometry = {ExpSo3({0.0, 0.0, 1.0}), {10.0, 0.0, 0.0}};
    }
    LoopKeyframe keyframe = testing::MakeLoopKeyframe(testing::SimulatedRig(), Room(),
                                                      rounds.truth[i], by_odometry, i * kStepNs);
    keyframe.segment = break_at > 0 && i >= break_at ? 1 : 0;
    if (i > 0) {
      keyframe.motion = rounds.closer.keyframes().back().world_from_body.Inverse() * by_odometry;
    }
    keyframe.motion_covariance.diagonal() << 4e-4, 4e-4, 4e-4, 4e-5, 4e-5, 4e-5;
    if (i == wrong_at) {
      keyframe.motion_covariance =
          DoubtfulMotion(keyframe.motion_covariance, rounds.truth[i - 1].Inverse() * by_odometry);
    }
    rounds.closer.Add(std::move(keyframe));
  }
  return rounds;
}

std::vector<Rigid3> ByOdometry(const LoopCloser& closer) {
  std::vector<Rigid3> poses;
  for (const LoopKeyframe& keyframe : closer.keyframes()) {
    poses.push_back(keyframe.world_from_body);
  }
  return poses;
}

TEST(LoopCloser, TheSecondRoundTakesTheDriftAway) {
  const Rounds rounds = FlyTwoRounds(kNever);
  EXPECT_GE(rounds.closer.loops().size(), 8U);
  const double before = rounds.WorstError(ByOdometry(rounds.closer));
  EXPECT_GT(before, 0.15);
  EXPECT_LT(rounds.WorstError(rounds.closer.Optimized()), 0.5 * before);
}

TEST(LoopCloser, ALostPartIsFoundAgain) {
  const Rounds rounds = FlyTwoRounds(14);
  EXPECT_GT(rounds.WorstError(ByOdometry(rounds.closer)), 5.0);
  EXPECT_LT(rounds.WorstError(rounds.closer.Optimized()), 0.2);
}

TEST(LoopCloser, AMotionThatIsWrongIsOutvoted) {
  // In the second round, where each key frame sees one of the first.
  Rounds rounds = FlyTwoRounds(kNever, /*wrong_at=*/18);
  EXPECT_GT(rounds.WorstError(ByOdometry(rounds.closer)), 1.0);
  EXPECT_LT(rounds.WorstError(rounds.closer.Optimized()), 0.1);
}

TEST(LoopCloser, ADoubtfulMotionIsVerifiedByThePlaceBefore) {
  LoopCloser closer(testing::SimulatedRig(), RoomCodebook(), MakeNearestNeighborMatcher(),
                    {.consistency = {.strong_inliers = 25}});
  closer.Add(KeyframeAt(0.0));
  // Too young for a loop, if its motion were not doubtful and wrong.
  const Rigid3 wrong = PlaceAt(0.2) * Rigid3{ExpSo3({0.0, 0.0, 0.5}), {1.0, 0.0, 0.0}};
  LoopKeyframe doubtful =
      testing::MakeLoopKeyframe(testing::SimulatedRig(), Room(), PlaceAt(0.2), wrong, kStepNs);
  doubtful.motion = PlaceAt(0.0).Inverse() * wrong;
  doubtful.motion_covariance =
      DoubtfulMotion(doubtful.motion_covariance, PlaceAt(0.0).Inverse() * wrong);
  closer.Add(std::move(doubtful));
  ASSERT_EQ(closer.loops().size(), 1U);
  EXPECT_LT((closer.Optimized()[1].translation - PlaceAt(0.2).translation).norm(), 0.01);
}

TEST(LoopCloser, IsTheSameEachTime) {
  const std::vector<Rigid3> once = FlyTwoRounds(kNever).closer.Optimized();
  const std::vector<Rigid3> again = FlyTwoRounds(kNever).closer.Optimized();
  for (std::size_t i = 0; i < once.size(); ++i) {
    EXPECT_EQ(once[i].translation, again[i].translation);
    EXPECT_EQ(once[i].rotation.coeffs(), again[i].rotation.coeffs());
  }
}

TEST(LoopCloser, WithoutLoopsPosesAreOdometrys) {
  LoopCloser closer(testing::SimulatedRig(), RoomCodebook(), MakeNearestNeighborMatcher(), {});
  for (int i = 0; i < 5; ++i) {
    closer.Add(testing::MakeLoopKeyframe(testing::SimulatedRig(), Room(), PlaceAt(0.1 * i),
                                         PlaceAt(0.1 * i), i * kStepNs));
  }
  EXPECT_TRUE(closer.attempts().empty());  // All too young.
  const std::vector<Rigid3> poses = closer.Optimized();
  for (int i = 0; i < 5; ++i) {
    EXPECT_EQ(poses[i].translation, PlaceAt(0.1 * i).translation);
  }
}

}  // namespace
}  // namespace gluevo::vo
