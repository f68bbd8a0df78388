#include "gluevo/vo/evaluation/evaluation.h"

#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <limits>
#include <random>
#include <string>

#include "gluevo/nn/error.h"
#include "gluevo/vo/evaluation/segment_evaluation.h"
#include "gluevo/vo/evaluation/time_scale.h"
#include "gluevo/vo/io/trajectory_file.h"

namespace gluevo::vo {
namespace {

constexpr int64_t kSecond = 1'000'000'000;

Trajectory FromPositions(const std::vector<Eigen::Vector3d>& positions) {
  Trajectory trajectory;
  for (const Eigen::Vector3d& position : positions) {
    trajectory.push_back({static_cast<int64_t>(trajectory.size()) * kSecond,
                          {Eigen::Quaterniond::Identity(), position}});
  }
  return trajectory;
}

/// Along x in steps of 1 m and 1 s.
Trajectory StraightWay(int poses) {
  std::vector<Eigen::Vector3d> positions;
  for (int i = 0; i < poses; ++i) {
    positions.emplace_back(i, 0.0, 0.0);
  }
  return FromPositions(positions);
}

Rigid3 SomeTransform() {
  return {Eigen::Quaterniond(0.3, -0.5, 0.7, 0.2).normalized(), {10.0, -20.0, 5.0}};
}

std::vector<Eigen::Vector3d> RandomPoints(int count) {
  std::mt19937 random(3);
  std::normal_distribution<double> coordinate(0.0, 2.0);
  std::vector<Eigen::Vector3d> points;
  for (int i = 0; i < count; ++i) {
    points.emplace_back(coordinate(random), coordinate(random), coordinate(random));
  }
  return points;
}

TEST(AlignUmeyamaTest, FindsTheSimilarityThatMadeThePoints) {
  const Rigid3 truth = SomeTransform();
  const std::vector<Eigen::Vector3d> source = RandomPoints(20);
  std::vector<Eigen::Vector3d> target;
  for (const Eigen::Vector3d& point : source) {
    target.push_back(2.5 * (truth.rotation * point) + truth.translation);
  }
  const Similarity3 found = AlignUmeyama(source, target, /*with_scale=*/true);
  EXPECT_NEAR(found.scale, 2.5, 1e-13);
  EXPECT_LT(found.rigid.rotation.angularDistance(truth.rotation), 1e-13);
  EXPECT_LT((found.rigid.translation - truth.translation).norm(), 1e-12);
  const Similarity3 rigid = AlignUmeyama(source, target, /*with_scale=*/false);
  EXPECT_EQ(rigid.scale, 1.0);
  EXPECT_LT(rigid.rigid.rotation.angularDistance(truth.rotation), 1e-13);
}

TEST(AlignUmeyamaTest, NeverMirrors) {
  // The case of eq. 43: the best orthogonal matrix is a mirror, the best rotation is not.
  const std::vector<Eigen::Vector3d> source = RandomPoints(20);
  std::vector<Eigen::Vector3d> target;
  for (const Eigen::Vector3d& point : source) {
    target.emplace_back(point.x(), point.y(), -point.z());
  }
  const Similarity3 found = AlignUmeyama(source, target, /*with_scale=*/true);
  EXPECT_NEAR(found.rigid.rotation.norm(), 1.0, 1e-14);
  EXPECT_LT(found.scale, 1.0);
  EXPECT_GT(found.scale, 0.0);
}

TEST(AlignUmeyamaTest, RefusesWhatHasNoAnswer) {
  const std::vector<Eigen::Vector3d> points = RandomPoints(4);
  const std::vector<Eigen::Vector3d> two(points.begin(), points.begin() + 2);
  const std::vector<Eigen::Vector3d> three(points.begin(), points.begin() + 3);
  const std::vector<Eigen::Vector3d> same(4, Eigen::Vector3d(1.0, 2.0, 3.0));
  EXPECT_THROW(AlignUmeyama(two, two, true), Error);
  EXPECT_THROW(AlignUmeyama(points, three, true), Error);
  EXPECT_THROW(AlignUmeyama(points, same, false), Error);
  EXPECT_THROW(AlignUmeyama(same, points, true), Error);
}

TEST(EvaluateTest, AWorldOfItsOwnIsNoError) {
  const Trajectory groundtruth = FromPositions(RandomPoints(50));
  Trajectory estimate = groundtruth;
  const Rigid3 other_world = SomeTransform();
  for (StampedPose& pose : estimate) {
    pose.world_from_body = other_world * pose.world_from_body;
  }
  const Evaluation evaluation = Evaluate(estimate, groundtruth, {});
  EXPECT_EQ(evaluation.pairs, 50U);
  EXPECT_LT(evaluation.ate_se3_m, 1e-12);
  EXPECT_LT(evaluation.ate_sim3_m, 1e-12);
  EXPECT_NEAR(evaluation.scale, 1.0, 1e-13);
  EXPECT_LT(evaluation.rpe_translation_percent, 1e-11);
  // The angle of a quaternion whose imaginary part is 1e-16.
  EXPECT_LT(evaluation.rpe_rotation_deg_per_m, 1e-10);
  EXPECT_EQ(evaluation.coverage, 1.0);
  const Rigid3 should_be_identity = evaluation.groundtruth_world_from_estimate_world * other_world;
  EXPECT_LT(should_be_identity.translation.norm(), 1e-11);
}

TEST(EvaluateTest, AbsoluteErrorsOfASaddleAreKnown) {
  // The corners of a square, moved by +e and -e in turn out of its plane: no rotation helps, as z
  // correlates with neither x nor y. So ATE is e after SE(3), and with the variances
  // 2 + e^2 (estimate) and 2 (truth) and the covariance 2, Umeyama's scale is 2 / (2 + e^2) and the
  // squared error 2 - 2^2 / (2 + e^2).
  const double e = 0.25;
  const Trajectory groundtruth = FromPositions({{1, 1, 0}, {1, -1, 0}, {-1, -1, 0}, {-1, 1, 0}});
  const Trajectory estimate = FromPositions({{1, 1, e}, {1, -1, -e}, {-1, -1, e}, {-1, 1, -e}});
  const Evaluation evaluation = Evaluate(estimate, groundtruth, {});
  EXPECT_NEAR(evaluation.ate_se3_m, e, 1e-14);
  EXPECT_NEAR(evaluation.scale, 2.0 / (2.0 + e * e), 1e-14);
  EXPECT_NEAR(evaluation.ate_sim3_m, std::sqrt(2.0 - 4.0 / (2.0 + e * e)), 1e-14);
}

TEST(EvaluateTest, ScaleIsGroundTruthOverEstimate) {
  const Trajectory groundtruth = FromPositions({{2, 0, 0}, {-2, 0, 0}, {0, 2, 0}, {0, -2, 0}});
  Trajectory estimate = groundtruth;
  for (StampedPose& pose : estimate) {
    pose.world_from_body.translation *= 0.5;
  }
  const Evaluation evaluation = Evaluate(estimate, groundtruth, {});
  EXPECT_NEAR(evaluation.scale, 2.0, 1e-14);
  EXPECT_NEAR(evaluation.ate_sim3_m, 0.0, 1e-14);
  EXPECT_NEAR(evaluation.ate_se3_m, 1.0, 1e-14);  // Every point is 1 m off.
}

TEST(EvaluateTest, RelativeErrorsOfAStraightWayAreKnown) {
  // 61 poses a metre apart, estimated 1 % too long and turning by 0.001 rad a metre about the
  // direction of travel. A sub-path of length L ends at the first pose beyond, at L + 1 metres;
  // 60 - L starts have one. Of the lengths 10, 20, ... 80, the path holds 10 to 50.
  Trajectory estimate = StraightWay(61);
  const Trajectory groundtruth = estimate;
  for (std::size_t i = 0; i < estimate.size(); ++i) {
    estimate[i].world_from_body.translation.x() *= 1.01;
    estimate[i].world_from_body.rotation = Eigen::Quaterniond(
        Eigen::AngleAxisd(0.001 * static_cast<double>(i), Eigen::Vector3d::UnitX()));
  }
  double translation = 0.0;
  double rotation = 0.0;
  int starts = 0;
  for (const double length : {10.0, 20.0, 30.0, 40.0, 50.0}) {
    const int starts_of_length = 60 - static_cast<int>(length);
    translation += starts_of_length * 0.01 * (length + 1.0) / length;
    rotation += starts_of_length * 0.001 * (length + 1.0) / length;
    starts += starts_of_length;
  }
  const Evaluation evaluation = Evaluate(estimate, groundtruth, {});
  EXPECT_EQ(evaluation.rpe_lengths_m, (std::vector<double>{10.0, 20.0, 30.0, 40.0, 50.0}));
  EXPECT_NEAR(evaluation.rpe_translation_percent, 100.0 * translation / starts, 1e-11);
  EXPECT_NEAR(evaluation.rpe_rotation_deg_per_m, rotation / starts * 180.0 / M_PI, 1e-11);
}

TEST(EvaluateTest, RelativeErrorsOverFramesAreKnown) {
  // 11 poses a metre apart, estimated with one step of 1.3 m, the fourth, at which it also turns by
  // 0.1 rad about the direction of travel.
  const Trajectory groundtruth = StraightWay(11);
  Trajectory estimate = groundtruth;
  for (std::size_t i = 4; i < estimate.size(); ++i) {
    estimate[i].world_from_body.translation.x() += 0.3;
    estimate[i].world_from_body.rotation =
        Eigen::Quaterniond(Eigen::AngleAxisd(0.1, Eigen::Vector3d::UnitX()));
  }
  const double angle = 0.1 * 180.0 / M_PI;
  // Steps, and those of them that go over the fourth: of 1 frame, of 3 frames (0 to 3, 3 to 6, 6 to
  // 9), and of 3 frames from every frame (from 1, 2 and 3 of 0 to 7).
  struct Case {
    EvaluationOptions options;
    double steps;
    double wrong;
  };
  for (const Case& c : {Case{{.rpe_frames = 1}, 10, 1}, Case{{.rpe_frames = 3}, 3, 1},
                        Case{{.rpe_frames = 3, .rpe_every_frame = true}, 8, 3}}) {
    const Evaluation evaluation = Evaluate(estimate, groundtruth, c.options);
    EXPECT_NEAR(evaluation.rpe_frames_translation_m, 0.3 * std::sqrt(c.wrong / c.steps), 1e-12);
    EXPECT_NEAR(evaluation.rpe_frames_rotation_deg, angle * std::sqrt(c.wrong / c.steps), 1e-10);
  }
  EXPECT_TRUE(
      std::isnan(Evaluate(estimate, groundtruth, {.rpe_frames = 11}).rpe_frames_translation_m));
  EXPECT_THROW(Evaluate(estimate, groundtruth, {.rpe_frames = 0}), Error);
}

TEST(EvaluateSegmentsTest, ComparesPosesOfASegmentOnly) {
  // Three segments of 5, 2 and 4 poses, each in a world of its own; the third stretched by 1.2
  // about its means, where its steps of 1 m are off by 0.2 m.
  const Trajectory groundtruth = StraightWay(11);
  Trajectory estimate = groundtruth;
  std::vector<int> segments;
  for (std::size_t i = 0; i < estimate.size(); ++i) {
    segments.push_back(i < 5 ? 0 : i < 7 ? 2 : 3);  // Numbers may be left out.
    Eigen::Vector3d& position = estimate[i].world_from_body.translation;
    position.x() *= segments.back() == 3 ? 1.2 : 1.0;
    position.y() += 50.0 * segments.back();
  }
  const SegmentedEvaluation result = EvaluateSegments(estimate, segments, groundtruth, {});
  ASSERT_EQ(result.segments.size(), 3U);
  EXPECT_EQ(result.segments[1].number, 2);
  EXPECT_EQ(result.segments[1].pairs, 2U);
  EXPECT_FALSE(result.segments[1].evaluation.has_value()) << "two poses cannot be aligned";
  EXPECT_NEAR(result.segments[0].evaluation->ate_se3_m, 0.0, 1e-12);
  // Offsets from the mean of -1.5, -0.5, 0.5 and 1.5 m, a fifth too long.
  const double last = 0.2 * std::sqrt(1.25);
  EXPECT_NEAR(result.segments[2].evaluation->ate_se3_m, last, 1e-12);
  EXPECT_NEAR(result.segments[2].evaluation->scale, 1.0 / 1.2, 1e-12);
  EXPECT_NEAR(result.ate_within_segments_m, std::sqrt(4.0 * last * last / 9.0), 1e-12);
  EXPECT_EQ(result.pairs_within_segments, 9U);
  EXPECT_EQ(result.motions, 8U);
  EXPECT_EQ(result.correct_motions, 5U);
  EXPECT_EQ(result.breaks, 2U);
}

TEST(EvaluateSegmentsTest, OneSegmentIsTheWhole) {
  const Trajectory groundtruth = FromPositions(RandomPoints(30));
  Trajectory estimate = FromPositions(RandomPoints(40));
  estimate.resize(30);
  estimate[7].world_from_body.translation.x() += 1.0;
  const Evaluation whole = Evaluate(estimate, groundtruth, {});
  const SegmentedEvaluation result =
      EvaluateSegments(estimate, std::vector<int>(30, 4), groundtruth, {});
  EXPECT_DOUBLE_EQ(result.ate_within_segments_m, whole.ate_se3_m);
  EXPECT_EQ(result.segments.front().evaluation->rpe_translation_percent,
            whole.rpe_translation_percent);
  EXPECT_EQ(result.correct_motions, whole.correct_motions);
  EXPECT_EQ(result.breaks, 0U);
}

TEST(EvaluateSegmentsTest, RefusesNumbersThatDoNotFit) {
  const Trajectory way = StraightWay(5);
  EXPECT_THROW(EvaluateSegments(way, {0, 0, 0, 0}, way, {}), Error);
  EXPECT_THROW(EvaluateSegments(way, {0, 0, 1, 0, 1}, way, {}), Error);
}

TEST(EvaluateTest, TakesTheLengthsThatAreAskedFor) {
  const Trajectory groundtruth = StraightWay(60);
  Trajectory estimate = groundtruth;
  for (StampedPose& pose : estimate) {
    pose.world_from_body.translation *= 1.02;
  }
  const Evaluation evaluation =
      Evaluate(estimate, groundtruth, {.rpe_lengths_m = {5.0, 20.0, 100.0}});
  EXPECT_EQ(evaluation.rpe_lengths_m, (std::vector<double>{5.0, 20.0}));
  // A sub-path ends at the first pose beyond its length: 6 and 21 m.
  const double expected = 2.0 * (54.0 * 6.0 / 5.0 + 39.0 * 21.0 / 20.0) / (54.0 + 39.0);
  EXPECT_NEAR(evaluation.rpe_translation_percent, expected, 1e-9);
  for (const std::vector<double>& lengths :
       {std::vector<double>{0.0}, std::vector<double>{5.0, -1.0}, std::vector<double>{1e7}}) {
    EXPECT_THROW((void)Evaluate(estimate, groundtruth, {.rpe_lengths_m = lengths}), Error);
  }
}

TEST(EvaluateTest, OneWrongMotionDoesNotTouchTheMedian) {
  const Trajectory groundtruth = StraightWay(10);
  Trajectory estimate = groundtruth;
  estimate.back().world_from_body.translation.y() += 3.0;
  const Evaluation evaluation = Evaluate(estimate, groundtruth, {});
  EXPECT_NEAR(evaluation.rpe_frames_translation_m, 1.0, 1e-12);
  EXPECT_NEAR(evaluation.rpe_frames_translation_median_m, 0.0, 1e-12);
}

TEST(EvaluateTest, SubPathsFitTheLengthOfTheWay) {
  const auto first_length = [](int poses, double metres_a_step) {
    Trajectory trajectory = StraightWay(poses);
    for (StampedPose& pose : trajectory) {
      pose.world_from_body.translation *= metres_a_step;
    }
    const Evaluation evaluation = Evaluate(trajectory, trajectory, {});
    EXPECT_EQ(std::isnan(evaluation.rpe_translation_percent), evaluation.rpe_lengths_m.empty());
    return evaluation.rpe_lengths_m.empty() ? 0.0 : evaluation.rpe_lengths_m.front();
  };
  EXPECT_EQ(first_length(1001, 1.0), 100.0);
  EXPECT_EQ(first_length(501, 1.0), 100.0);
  EXPECT_EQ(first_length(500, 1.0), 10.0);
  EXPECT_EQ(first_length(500, 0.03125), 1.0);
  EXPECT_EQ(first_length(500, 0.0078125), 0.1);
  EXPECT_EQ(first_length(32, 0.015625), 0.0);  // 0.484 m.
}

TEST(EvaluateTest, PosesBelongToTheNearestInTime) {
  // Every second truth is 4 ms late, the others 11 ms early: too far.
  const Trajectory groundtruth = StraightWay(20);
  Trajectory estimate;
  for (std::size_t i = 0; i < groundtruth.size(); ++i) {
    estimate.push_back(groundtruth[i]);
    estimate.back().timestamp_ns += i % 2 == 0 ? 4'000'000 : -11'000'000;
  }
  EXPECT_EQ(Evaluate(estimate, groundtruth, {}).pairs, 10U);
  EXPECT_EQ(Evaluate(estimate, groundtruth, {.max_time_difference_s = 0.011}).pairs, 20U);
  EXPECT_EQ(Evaluate(estimate, groundtruth, {.max_time_difference_s = 0.010999}).pairs, 10U);
  EXPECT_THROW(Evaluate(estimate, groundtruth, {.max_time_difference_s = 0.001}), Error);
  EXPECT_THROW(Evaluate(estimate, groundtruth, {.max_time_difference_s = -1.0}), Error);
  EXPECT_THROW(Evaluate(estimate, groundtruth, {.max_time_difference_s = std::nan("")}), Error);
}

TEST(EvaluateTest, TheEarlierOfTwoEquallyNearPosesCounts) {
  // Truth at 0, 10, 20 ms ... and estimates in the middle between two, at the place of the earlier.
  Trajectory groundtruth = StraightWay(9);
  Trajectory estimate = StraightWay(8);
  for (StampedPose& pose : groundtruth) {
    pose.timestamp_ns /= 100;
  }
  for (StampedPose& pose : estimate) {
    pose.timestamp_ns = pose.timestamp_ns / 100 + 5'000'000;
  }
  const Evaluation evaluation = Evaluate(estimate, groundtruth, {});
  EXPECT_EQ(evaluation.pairs, 8U);
  EXPECT_LT((evaluation.groundtruth_world_from_estimate_world * Eigen::Vector3d::Zero()).norm(),
            1e-12);
}

TEST(EvaluateTest, FewerThanThreePairsAreAnError) {
  const Trajectory two = StraightWay(2);
  EXPECT_THROW(Evaluate(two, two, {}), Error);
  EXPECT_THROW(Evaluate({}, StraightWay(9), {}), Error);
  EXPECT_THROW(Evaluate(StraightWay(9), {}, {}), Error);
}

TEST(EvaluateTest, StandingStillHasNoScale) {
  const Trajectory still = FromPositions(std::vector<Eigen::Vector3d>(6, {1.0, 2.0, 3.0}));
  // Off by 0.1 m to either side.
  const Trajectory moving = FromPositions(
      {{0.1, 0, 0}, {-0.1, 0, 0}, {0.1, 0, 0}, {-0.1, 0, 0}, {0.1, 0, 0}, {-0.1, 0, 0}});
  for (const auto& [estimate, groundtruth] : {std::pair(still, moving), std::pair(moving, still)}) {
    const Evaluation evaluation = Evaluate(estimate, groundtruth, {});
    EXPECT_NEAR(evaluation.ate_se3_m, 0.1, 1e-14);
    EXPECT_NEAR(evaluation.ate_sim3_m, 0.1, 1e-14);
    EXPECT_TRUE(std::isnan(evaluation.scale));
  }
  const Evaluation both = Evaluate(still, still, {});
  EXPECT_EQ(both.ate_se3_m, 0.0);
  EXPECT_TRUE(std::isnan(both.rpe_translation_percent));
  EXPECT_TRUE(std::isnan(both.rpe_rotation_deg_per_m));
}

TEST(EvaluateTest, CoverageCountsTheTimeBetweenAssociatedPoses) {
  const Trajectory groundtruth = StraightWay(101);
  // From 10 to 30 s and from 50 to 90 s: 60 of 100 s, the gap of 20 s between them does not count.
  Trajectory estimate;
  for (std::size_t i = 0; i < groundtruth.size(); ++i) {
    if ((i >= 10 && i <= 30) || (i >= 50 && i <= 90)) {
      estimate.push_back(groundtruth[i]);
    }
  }
  EXPECT_DOUBLE_EQ(Evaluate(estimate, groundtruth, {}).coverage, 0.6);
  // Gaps of up to thrice the usual step are none.
  estimate.erase(estimate.begin() + 5, estimate.begin() + 7);
  EXPECT_DOUBLE_EQ(Evaluate(estimate, groundtruth, {}).coverage, 0.6);
}

TEST(EvaluateTest, TimesAtTheEndsOfTheClockDoNotOverflow) {
  Trajectory estimate = StraightWay(3);
  estimate.front().timestamp_ns = std::numeric_limits<int64_t>::min();
  estimate.back().timestamp_ns = std::numeric_limits<int64_t>::max();
  EXPECT_EQ(Evaluate(estimate, estimate, {}).pairs, 3U);
  EXPECT_THROW(Evaluate(estimate, StraightWay(9), {}), Error);
}

struct Golden {
  const char* method;
  const char* sequence;
  const char* groundtruth;
  std::size_t pairs;
  double ate_se3_m;
  double ate_sim3_m;
  double scale;
};

// From evo 1.38.1 (pip install evo):
//   evo_ape tum groundtruth/$GROUNDTRUTH.txt estimates/$METHOD/$SEQUENCE.tum -a -v --save_results r
//   unzip -p r stats.json
// the field rmse of stats.json, with -a for SE(3) and -as for Sim(3); pairs and scale from -v.
constexpr Golden kEvo[] = {
    {"ORB_SLAM2", "MH_01", "MH_01_easy", 3265, 0.0373631567202071, 0.03528855544884117,
     1.0028200638661051},
    {"vins", "MH_01", "MH_01_easy", 1786, 0.22182343425616094, 0.2171133147358021,
     1.010730729855256},
    {"vins_lc", "MH_01", "MH_01_easy", 1050, 0.057982275252235475, 0.056293441587597,
     0.9967750440588397},
    {"ORB_SLAM2", "MH_02", "MH_02_easy", 2752, 0.04756500271300058, 0.03760443908747045,
     0.9938369963621133},
    {"vins", "MH_02", "MH_02_easy", 1495, 0.22757931400837436, 0.22739385867735326,
     0.998022942648997},
    {"vins_lc", "MH_02", "MH_02_easy", 898, 0.05938835900894121, 0.05339537162664064,
     0.9945187225618921},
    {"ORB_SLAM2", "MH_03", "MH_03_medium", 2305, 0.7527070236375955, 0.7510538008035377,
     1.0143564337077229},
    {"vins", "MH_03", "MH_03_medium", 1309, 0.24428579609041662, 0.2413076998226704,
     0.9894736300001385},
    {"vins_lc", "MH_03", "MH_03_medium", 966, 0.07054751077286714, 0.06955184447053919,
     0.99683651928436},
    {"ORB_SLAM2", "V1_01", "V1_01_easy", 2822, 0.0529641706569815, 0.05205809142968686,
     1.0052955751091817},
    {"vins", "V1_01", "V1_01_easy", 773, 0.10037270125474877, 0.09884944404904389,
     0.9906530869683868},
    {"vins_lc", "V1_01", "V1_01_easy", 1082, 0.032767734857981026, 0.027940804442498694,
     1.0092847471252229},
};

TEST(EvaluateTest, AgreesWithEvoOnPublishedTrajectories) {
  const std::filesystem::path folder =
      std::filesystem::path(GLUEVO_SHARED_DIR) / "data" / "trajectories";
  if (!std::filesystem::exists(folder)) {
    GTEST_SKIP() << folder << " is not there";
  }
  for (const Golden& golden : kEvo) {
    SCOPED_TRACE(std::string(golden.method) + " " + golden.sequence);
    const Evaluation evaluation = Evaluate(
        ReadTrajectory(folder / "estimates" / golden.method /
                       (std::string(golden.sequence) + ".tum")),
        ReadTrajectory(folder / "groundtruth" / (std::string(golden.groundtruth) + ".txt")), {});
    EXPECT_EQ(evaluation.pairs, golden.pairs);
    EXPECT_NEAR(evaluation.ate_se3_m, golden.ate_se3_m, 1e-6);
    EXPECT_NEAR(evaluation.ate_sim3_m, golden.ate_sim3_m, 1e-6);
    EXPECT_NEAR(evaluation.scale, golden.scale, 1e-6);
  }
}

/// Poses along a circle, `step` nanoseconds apart.
Trajectory Circle(std::size_t count, int64_t start, int64_t step) {
  Trajectory trajectory;
  for (std::size_t i = 0; i < count; ++i) {
    const double angle = 0.1 * static_cast<double>(i);
    trajectory.push_back({start + static_cast<int64_t>(i) * step,
                          {Eigen::Quaterniond::Identity(), {std::cos(angle), std::sin(angle), 0}}});
  }
  return trajectory;
}

TEST(EvaluateTest, FewMatesAreSaidAndAreNoCoverage) {
  // Three of sixty poses, 50 ms apart, are near one of the truth.
  const Trajectory groundtruth = Circle(60, 0, 50'000'000);
  Trajectory estimate = groundtruth;
  for (std::size_t i = 0; i < estimate.size(); ++i) {
    estimate[i].timestamp_ns += i % 29 == 0 ? 0 : 20'000'000;
  }
  const Evaluation few = Evaluate(estimate, groundtruth, {});
  EXPECT_EQ(few.pairs, 3U);
  EXPECT_EQ(few.estimate_poses, 60U);
  EXPECT_EQ(few.coverage, 0.0);
  const std::optional<std::string> warning = AssociationWarning(few, {});
  ASSERT_TRUE(warning);
  EXPECT_NE(warning->find("only 3 of 60 poses"), std::string::npos) << *warning;
  const Evaluation all = Evaluate(groundtruth, groundtruth, {});
  EXPECT_NEAR(all.coverage, 1.0, 1e-12);
  EXPECT_FALSE(AssociationWarning(all, {}));
}

TEST(EvaluateTest, AScaleOfOtherUnitsIsSaid) {
  const Trajectory estimate = Circle(60, 0, 50'000'000);
  const auto warning = [&](double factor) {
    Trajectory groundtruth = estimate;
    for (StampedPose& pose : groundtruth) {
      pose.world_from_body.translation *= factor;
    }
    return ScaleWarning(Evaluate(estimate, groundtruth, {})).value_or("");
  };
  EXPECT_NE(warning(1000.0).find("is the ground truth in millimetres"), std::string::npos);
  EXPECT_NE(warning(0.01).find("is the estimate in centimetres"), std::string::npos);
  EXPECT_NE(warning(30.0).find("are both in metres?"), std::string::npos);
  EXPECT_EQ(warning(1.0), "");
  EXPECT_EQ(warning(0.2), "");
}

TEST(EvaluateTest, ClocksThatAreABitApartAreSaid) {
  const Trajectory groundtruth = Circle(30, 0, 100'000'000);
  Trajectory estimate = groundtruth;
  for (StampedPose& pose : estimate) {
    pose.timestamp_ns += 40'000'000;
  }
  try {
    Evaluate(estimate, groundtruth, {});
    ADD_FAILURE() << "evaluated";
  } catch (const Error& error) {
    EXPECT_NE(std::string(error.what()).find("0.04 s apart (--max-time-difference)"),
              std::string::npos)
        << error.what();
  }
  const Evaluation few = Evaluate(groundtruth, {groundtruth.begin(), groundtruth.begin() + 4}, {});
  EXPECT_NE(AssociationWarning(few, {}).value_or("").find("only 4 of 30 poses of the estimate"),
            std::string::npos);
}

TEST(EvaluateTest, OtherTimesAreNamed) {
  try {
    Evaluate(Circle(60, 0, 50'000'000), Circle(60, 1'000'000'000'000, 50'000'000), {});
    FAIL();
  } catch (const Error& error) {
    const std::string message = error.what();
    EXPECT_NE(message.find("the estimate is from 0.000 to 2.950 s"), std::string::npos) << message;
    EXPECT_NE(message.find("ground truth from 1000.000 to 1002.950 s"), std::string::npos);
  }
}

TEST(TimeScaleTest, IsFoundWhereOneFileCountsInAnotherUnit) {
  const Trajectory seconds = Circle(60, 1'000'000'000, 50'000'000);
  EXPECT_FALSE(FindTimeScale(seconds, seconds, {}));
  // Milliseconds that were read as seconds, and as nanoseconds.
  for (const int power : {3, -6}) {
    Trajectory other = seconds;
    ScaleTimes(power, other);
    const std::optional<TimeScale> scale = FindTimeScale(seconds, other, {});
    ASSERT_TRUE(scale) << power;
    EXPECT_FALSE(scale->of_estimate);
    EXPECT_EQ(scale->power_of_ten, -power);
    EXPECT_TRUE(FindTimeScale(other, seconds, {})->of_estimate);
  }
  // Another time is no other unit.
  EXPECT_FALSE(FindTimeScale(seconds, Circle(60, 999'000'000'000, 50'000'000), {}));
}

TEST(TimeScaleTest, ThrowsWhereTimesBecomeTooLarge) {
  Trajectory late = Circle(3, 1'400'000'000'000'000'000, 1);
  EXPECT_THROW(ScaleTimes(3, late), Error);
}

TEST(EvaluateTest, GivesEachPosesErrorAfterBothAlignments) {
  // A straight way, 1 % too long and with one pose off to the side, in another world.
  Trajectory groundtruth = StraightWay(21);
  Trajectory estimate = groundtruth;
  for (StampedPose& pose : estimate) {
    pose.world_from_body.translation *= 1.01;
  }
  estimate[7].world_from_body.translation.y() += 0.3;
  for (StampedPose& pose : estimate) {
    pose.world_from_body = SomeTransform() * pose.world_from_body;
  }
  groundtruth.erase(groundtruth.begin() + 3);
  const Evaluation evaluation = Evaluate(estimate, groundtruth, {});
  ASSERT_EQ(evaluation.errors.size(), 20U);
  double sum_se3 = 0.0;
  double sum_sim3 = 0.0;
  const PoseError* worst = &evaluation.errors.front();
  for (const PoseError& error : evaluation.errors) {
    sum_se3 += error.se3_m * error.se3_m;
    sum_sim3 += error.sim3_m * error.sim3_m;
    EXPECT_NEAR((error.se3 - error.groundtruth).norm(), error.se3_m, 1e-12);
    EXPECT_NEAR((error.sim3 - error.groundtruth).norm(), error.sim3_m, 1e-12);
    worst = error.sim3_m > worst->sim3_m ? &error : worst;
  }
  EXPECT_NEAR(std::sqrt(sum_se3 / 20.0), evaluation.ate_se3_m, 1e-12);
  EXPECT_NEAR(std::sqrt(sum_sim3 / 20.0), evaluation.ate_sim3_m, 1e-12);
  EXPECT_EQ(worst->timestamp_ns, 7 * kSecond);
  // No alignment touches the motions: one step is 1 cm too long, and to the side and back besides.
  EXPECT_EQ(evaluation.errors[0].motion_m, 0.0);
  EXPECT_NEAR(evaluation.errors[1].motion_m, 0.01, 1e-9);
  EXPECT_NEAR(evaluation.errors[3].motion_m, 0.02, 1e-9) << "the motion over the missing pose";
  EXPECT_NEAR(worst->motion_m, std::hypot(0.01, 0.3), 1e-9);
  EXPECT_NEAR(worst->motion_deg, 0.0, 1e-6);
  const Similarity3& sim3 = evaluation.groundtruth_world_from_estimate_world_sim3;
  EXPECT_EQ(sim3.scale, evaluation.scale);
  EXPECT_LT((sim3.scale * (sim3.rigid.rotation * estimate[5].world_from_body.translation) +
             sim3.rigid.translation - evaluation.errors[4].sim3)
                .norm(),
            1e-12);
}

}  // namespace
}  // namespace gluevo::vo
