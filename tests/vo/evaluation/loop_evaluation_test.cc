#include "gluevo/vo/evaluation/loop_evaluation.h"

#include <gtest/gtest.h>

#include <cmath>

#include "gluevo/nn/error.h"

namespace gluevo::vo {
namespace {

constexpr int64_t kSecond = 1'000'000'000;

// There and back along a line of 40 m: the second half comes back to the first.
Trajectory ThereAndBack() {
  Trajectory truth;
  for (int i = 0; i <= 80; ++i) {
    truth.push_back(
        {i * kSecond, {Eigen::Quaterniond::Identity(), {40.0 - std::abs(40.0 - i), 0.0, 0.0}}});
  }
  return truth;
}

std::vector<PlaceVisit> VisitsOf(const Trajectory& truth, int second_from = 1000) {
  std::vector<PlaceVisit> visits;
  for (std::size_t i = 0; i < truth.size(); ++i) {
    visits.push_back({truth[i].timestamp_ns, static_cast<int>(i) < second_from ? 0 : 1});
  }
  return visits;
}

BelievedLoop Right(const Trajectory& truth, std::size_t candidate, std::size_t query) {
  const Rigid3 motion = truth[candidate].world_from_body.Inverse() * truth[query].world_from_body;
  return {candidate, query, motion, motion, truth[query].timestamp_ns};
}

TEST(LoopEvaluation, RecallIsOfThePlacesThatAreSeenAgainLater) {
  const Trajectory truth = ThereAndBack();
  // 10.5 s before and after the turn: what is younger than 20 s is no place to come back to.
  std::vector<BelievedLoop> loops;
  for (std::size_t i = 51; i < 71; ++i) {
    loops.push_back(Right(truth, 80 - i, i));
  }
  const LoopEvaluation evaluation = EvaluateLoops(VisitsOf(truth), loops, truth, {});
  // Places within a metre: the one before counts, too, which is older by a second.
  EXPECT_EQ(evaluation.revisits, 31U);
  EXPECT_EQ(evaluation.found, 20U);
  EXPECT_EQ(evaluation.loops, 20U);
  EXPECT_NEAR(*evaluation.recall, 20.0 / 31.0, 1e-12);
  EXPECT_EQ(*evaluation.precision, 1.0);
  EXPECT_TRUE(evaluation.joins.empty());
}

TEST(LoopEvaluation, AWrongLoopIsCountedAndWhetherThePosesFollowIt) {
  const Trajectory truth = ThereAndBack();
  BelievedLoop outvoted = Right(truth, 5, 75);
  outvoted.candidate_from_query.translation.x() += 3.0;
  BelievedLoop followed = outvoted;
  followed.candidate_from_query_kept = followed.candidate_from_query;
  const LoopEvaluation evaluation =
      EvaluateLoops(VisitsOf(truth), {Right(truth, 4, 76), outvoted, followed}, truth, {});
  EXPECT_EQ(evaluation.wrong, 2U);
  EXPECT_EQ(evaluation.wrong_kept, 1U);
  EXPECT_NEAR(*evaluation.precision, 1.0 / 3.0, 1e-12);
  EXPECT_EQ(evaluation.found, 1U);
}

TEST(LoopEvaluation, SegmentsJoinSoLongAfterTheyCouldHave) {
  const Trajectory truth = ThereAndBack();
  BelievedLoop first = Right(truth, 35, 45);
  first.believed_ns = 47 * kSecond;  // When another one agreed.
  const std::vector<PlaceVisit> visits = VisitsOf(truth, /*second_from=*/43);
  const LoopEvaluation evaluation = EvaluateLoops(visits, {first, Right(truth, 32, 48)}, truth, {});
  ASSERT_EQ(evaluation.joins.size(), 1U);
  EXPECT_EQ(evaluation.joins[0].segment, 1);
  EXPECT_EQ(evaluation.joins[0].seen_ns, 43 * kSecond);
  EXPECT_EQ(*evaluation.joins[0].joined_after_seconds, 4.0);
  const LoopEvaluation without = EvaluateLoops(visits, {}, truth, {});
  EXPECT_FALSE(without.joins[0].joined_after_seconds);
  EXPECT_FALSE(without.precision);
}

TEST(LoopEvaluation, VisitsWithoutTruthDoNotCount) {
  const Trajectory truth = ThereAndBack();
  std::vector<PlaceVisit> visits = VisitsOf(truth);
  visits[76].timestamp_ns += kSecond / 2;
  const LoopEvaluation evaluation = EvaluateLoops(visits, {Right(truth, 4, 76)}, truth, {});
  EXPECT_EQ(evaluation.loops, 0U);
  EXPECT_EQ(evaluation.revisits, 30U);
  EXPECT_THROW(EvaluateLoops(visits, {Right(truth, 4, 76), {0, 99, {}, {}, 0}}, truth, {}), Error);
}

}  // namespace
}  // namespace gluevo::vo
