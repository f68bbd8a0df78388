#include "gluevo/vo/pipeline/odometry.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <memory>
#include <numbers>
#include <numeric>
#include <random>
#include <set>
#include <string>
#include <vector>

#include "gluevo/nn/error.h"
#include "gluevo/vo/geometry/manifold.h"
#include "gluevo/vo/geometry/pose_uncertainty.h"
#include "vo/scene.h"

namespace gluevo::vo {
namespace {

constexpr int64_t kStepNs = 100'000'000;  // 10 Hz

// A round through the room, bobbing and turning; the first pose is not the identity.
Rigid3 FlightPose(double t) {
  const double angle = 0.25 * t;
  return {ExpSo3({0.0, 0.0, angle + 0.3 * std::sin(0.7 * t)}) * ExpSo3({0.1 * std::sin(t), 0, 0}),
          {1.5 * std::cos(angle), 1.5 * std::sin(angle), 0.3 * std::sin(0.5 * t)}};
}

std::vector<Rigid3> Flight(int frames) {
  std::vector<Rigid3> poses;
  poses.reserve(frames);
  for (int i = 0; i < frames; ++i) {
    poses.push_back(FlightPose(0.1 * i));
  }
  return poses;
}

std::vector<TrackedFrame> Observe(const std::vector<Rigid3>& poses,
                                  const testing::SimulationOptions& options) {
  const auto points = testing::RoomPoints(6000, 4.0, 11);
  std::vector<TrackedFrame> frames;
  for (std::size_t i = 0; i < poses.size(); ++i) {
    frames.push_back(testing::Simulate(testing::SimulatedRig(), points, poses[i],
                                       static_cast<int64_t>(i) * kStepNs, options));
  }
  return frames;
}

std::vector<FrameResult> RunOdometry(const std::vector<TrackedFrame>& frames,
                                     const OdometryOptions& options = {}) {
  Odometry odometry(testing::SimulatedRig(), std::make_unique<testing::ScriptedFrontEnd>(frames),
                    options);
  std::vector<FrameResult> results;
  for (const TrackedFrame& frame : frames) {
    StereoFrame images;
    images.timestamp_ns = frame.timestamp_ns;
    results.push_back(odometry.Process(images));
  }
  return results;
}

struct Errors {
  double position_m = 0.0;  // largest
  double turn_rad = 0.0;
};

// Largest error of the motion since frame `first`, over the frames up to `last`.
Errors MotionErrors(const std::vector<FrameResult>& results, const std::vector<Rigid3>& truth,
                    std::size_t first, std::size_t last) {
  Errors errors;
  for (std::size_t i = first; i <= last; ++i) {
    const Rigid3 estimated = results[first].world_from_body.Inverse() * results[i].world_from_body;
    const Rigid3 expected = truth[first].Inverse() * truth[i];
    errors.position_m =
        std::max(errors.position_m, (estimated.translation - expected.translation).norm());
    errors.turn_rad =
        std::max(errors.turn_rad, estimated.rotation.angularDistance(expected.rotation));
  }
  return errors;
}

TEST(Odometry, ExactObservationsGiveTheExactFlight) {
  const auto truth = Flight(60);
  const auto results = RunOdometry(Observe(truth, {.noise_px = 0.0}));
  // The world is the body's frame at the start.
  EXPECT_TRUE(results.front().world_from_body.translation.isZero());
  const Errors errors = MotionErrors(results, truth, 0, 59);
  // The solver stops when the cost changes by less than 1e-6 of itself, a pixel's fraction.
  EXPECT_LT(errors.position_m, 1e-4);
  EXPECT_LT(errors.turn_rad, 1e-4);
  for (const FrameResult& result : results) {
    EXPECT_EQ(result.segment, 0);
  }
}

TEST(Odometry, NoisyFlightDriftsLittle) {
  // 12 s, some 5 m: half a pixel of noise at 0.11 m baseline and 3 to 6 m depth gives, per
  // point, a disparity depth error of 5 %; over 150 points and 11 frames the drift stays below
  // 2 % of the path and 1 degree.
  const auto truth = Flight(120);
  const auto results = RunOdometry(Observe(truth, {.noise_px = 0.5}));
  const Errors errors = MotionErrors(results, truth, 0, 119);
  EXPECT_LT(errors.position_m, 0.1);
  EXPECT_LT(errors.turn_rad, 1.0 * std::numbers::pi / 180.0);
  EXPECT_GT(results.back().inliers, 100);
}

TEST(Odometry, OutliersDoNotShowInThePoses) {
  const auto truth = Flight(60);
  const auto results = RunOdometry(Observe(truth, {.noise_px = 0.5, .outlier_share = 0.3}));
  const Errors errors = MotionErrors(results, truth, 0, 59);
  EXPECT_LT(errors.position_m, 0.1);
  EXPECT_LT(errors.turn_rad, 1.0 * std::numbers::pi / 180.0);
  EXPECT_EQ(results.back().segment, 0);
}

TEST(Odometry, KeepsTracksOfBlurredImages) {
  // What is off by 2.5 pixels in both coordinates is no outlier where everything is.
  const auto frames = Observe(Flight(60), {.noise_px = 2.5});
  const auto inlier_share = [&](const OdometryOptions& options) {
    const auto results = RunOdometry(frames, options);
    double tracked = 0.0;
    double inliers = 0.0;
    for (std::size_t i = 20; i < results.size(); ++i) {
      tracked += results[i].tracked;
      inliers += results[i].inliers;
    }
    return inliers / tracked;
  };
  EXPECT_GT(inlier_share({}), 0.93);
  OdometryOptions fixed;
  fixed.keypoint_noise = {.least_px = 1.5, .largest_px = 1.5};
  EXPECT_LT(inlier_share(fixed), 0.9);
}

// Squared error of each motion since a key frame, in standard deviations; expected: one a degree of
// freedom, six in all.
std::vector<double> SquaredMotionErrors(const std::vector<FrameResult>& results,
                                        const std::vector<Rigid3>& truth) {
  std::vector<double> squares;
  for (std::size_t i = 1; i < results.size(); ++i) {
    const auto from = static_cast<std::size_t>(results[i].motion_from_ns / kStepNs);
    const Eigen::Matrix<double, 6, 1> error =
        ErrorOfPose(results[i].keyframe_from_body, truth[from].Inverse() * truth[i]);
    squares.push_back(error.dot(results[i].motion_covariance.ldlt().solve(error)));
  }
  return squares;
}

TEST(Odometry, KnowsHowGoodItsMotionsAre) {
  const auto truth = Flight(120);
  for (const double noise_px : {0.2, 0.5, 1.0}) {
    const auto results = RunOdometry(Observe(truth, {.noise_px = noise_px}));
    const std::vector<double> squares = SquaredMotionErrors(results, truth);
    const double mean =
        std::accumulate(squares.begin(), squares.end(), 0.0) / static_cast<double>(squares.size());
    EXPECT_GT(mean / 6.0, 0.5) << noise_px << " px";
    EXPECT_LT(mean / 6.0, 2.0) << noise_px << " px";
    // Drift grows.
    const auto sigma = [&](std::size_t frame) {
      return std::sqrt(results[frame].path_covariance.topLeftCorner<3, 3>().trace());
    };
    EXPECT_EQ(sigma(0), 0.0);
    EXPECT_LT(sigma(10), sigma(60));
    EXPECT_LT(sigma(60), sigma(119));
    const Errors errors = MotionErrors(results, truth, 0, 119);
    EXPECT_LT(errors.position_m, 4.0 * sigma(119));
  }
}

TEST(Odometry, KnowsLittleOfWhatItPredicts) {
  const auto truth = Flight(40);
  auto frames = Observe(truth, {.noise_px = 0.5});
  for (std::size_t i = 20; i < 25; ++i) {
    frames[i].observations.clear();
  }
  const auto results = RunOdometry(frames);
  const auto sigma = [&](std::size_t frame) {
    return std::sqrt(results[frame].path_covariance.topLeftCorner<3, 3>().trace());
  };
  for (std::size_t i = 20; i < 25; ++i) {
    EXPECT_TRUE(results[i].is_predicted);
    EXPECT_EQ(results[i].motion_from_ns, results[19].timestamp_ns);
    EXPECT_GT(sigma(i), sigma(i - 1));
    const double error_m = (truth[19].Inverse() * truth[i]).translation.norm();
    EXPECT_LT(error_m, 5.0 * sigma(i));
  }
  EXPECT_LT(sigma(25), sigma(24));
}

TEST(Odometry, StandsStill) {
  const std::vector<Rigid3> truth(60, FlightPose(0.0));
  const auto results = RunOdometry(Observe(truth, {.noise_px = 0.5}));
  const Errors errors = MotionErrors(results, truth, 0, 59);
  EXPECT_LT(errors.position_m, 0.02);
  EXPECT_EQ(results.back().segment, 0);
  int keyframes = 0;
  for (const FrameResult& result : results) {
    keyframes += result.is_keyframe ? 1 : 0;
  }
  // Only the first frames, whose tracks are all young.
  EXPECT_LE(keyframes, 4);
}

TEST(Odometry, MetresBetweenFrames) {
  // Every 12th frame of the flight: 0.45 m and up to 30 degrees from one to the next, at which
  // half of the points leave the image.
  std::vector<Rigid3> truth;
  truth.reserve(12);
  for (int i = 0; i < 12; ++i) {
    truth.push_back(FlightPose(1.2 * i));
  }
  auto frames = Observe(truth, {.noise_px = 0.5, .outlier_share = 0.3, .max_observations = 300});
  for (std::size_t i = 0; i < frames.size(); ++i) {
    frames[i].timestamp_ns = static_cast<int64_t>(i) * 12 * kStepNs;
  }
  const auto results = RunOdometry(frames);
  for (std::size_t i = 1; i < truth.size(); ++i) {
    EXPECT_EQ(results[i].segment, 0) << i;
    const Errors errors = MotionErrors(results, truth, i - 1, i);
    EXPECT_LT(errors.position_m, 0.1) << i;
    EXPECT_LT(errors.turn_rad, 2.0 * std::numbers::pi / 180.0) << i;
  }
}

// The first frame that nothing links to those before starts a segment.
OdometryOptions WithoutPatience() {
  OdometryOptions options;
  options.max_predicted_s = 0.0;
  return options;
}

TEST(Odometry, DeclaresAResetWhenTracksVanish) {
  const auto truth = Flight(60);
  auto frames = Observe(truth, {.noise_px = 0.5});
  for (std::size_t i = 30; i < frames.size(); ++i) {
    for (Observation& observation : frames[i].observations) {
      observation.track_id += 100'000;
    }
  }
  const auto results = RunOdometry(frames, WithoutPatience());
  EXPECT_EQ(results[29].segment, 0);
  EXPECT_EQ(results[30].segment, 1);
  EXPECT_EQ(results[59].segment, 1);
  // No jump: the new segment starts where the old one ended, and both are right in themselves.
  EXPECT_EQ(results[30].world_from_body.translation, results[29].world_from_body.translation);
  EXPECT_LT(MotionErrors(results, truth, 0, 29).position_m, 0.1);
  EXPECT_LT(MotionErrors(results, truth, 30, 59).position_m, 0.1);
}

TEST(Odometry, NeverJumpsSilently) {
  // Wrong matches only (ids shuffled) for one frame: declared. All poses stay finite.
  const auto truth = Flight(60);
  auto frames = Observe(truth, {.noise_px = 0.5});
  for (std::size_t k = 0; k < frames[20].observations.size(); ++k) {
    frames[20].observations[k].track_id =
        frames[19].observations[(k * 37 + 11) % frames[19].observations.size()].track_id;
  }
  const auto results = RunOdometry(frames, WithoutPatience());
  for (std::size_t i = 1; i < results.size(); ++i) {
    ASSERT_TRUE(results[i].world_from_body.translation.allFinite()) << i;
    EXPECT_FALSE(results[i].is_predicted);
    if (results[i].segment == results[i - 1].segment) {
      EXPECT_LT(MotionErrors(results, truth, i - 1, i).position_m, 0.05) << i;
    }
  }
  EXPECT_GT(results[20].segment, results[19].segment);
  // Who waits for what is known finds it in the frame after.
  const auto patient = RunOdometry(frames);
  EXPECT_TRUE(patient[20].is_predicted);
  EXPECT_FALSE(patient[21].is_predicted);
  EXPECT_EQ(patient[59].segment, 0);
  EXPECT_LT(MotionErrors(patient, truth, 0, 59).position_m, 0.1);
}

void MakeBlind(TrackedFrame* frame) { frame->observations.clear(); }

TEST(Odometry, PassesOverFramesThatShowNothing) {
  // A blind frame, three of them, one of values that are not finite, and one in which nothing that
  // the left camera sees is seen before or by the right one.
  const auto truth = Flight(80);
  auto frames = Observe(truth, {.noise_px = 0.5});
  MakeBlind(&frames[20]);
  for (const int i : {30, 31, 32}) {
    MakeBlind(&frames[i]);
  }
  for (Observation& observation : frames[50].observations) {
    observation.left.setConstant(std::nan(""));
  }
  for (Observation& observation : frames[60].observations) {
    observation.track_id += 100'000;
    observation.has_right = false;
  }
  const auto results = RunOdometry(frames);
  const std::set<std::size_t> blind = {20, 30, 31, 32, 50, 60};
  for (std::size_t i = 0; i < results.size(); ++i) {
    EXPECT_EQ(results[i].segment, 0) << i;
    EXPECT_EQ(results[i].is_predicted, blind.contains(i)) << i;
    EXPECT_FALSE(results[i].is_predicted && results[i].is_keyframe) << i;
    // The motion goes on meanwhile, slower and slower.
    EXPECT_LT(MotionErrors(results, truth, 0, i).position_m, 0.15) << i;
  }
}

TEST(Odometry, ALongTimeInTheDarkEndsWithWhatIsSeenAgain) {
  const auto truth = Flight(80);
  auto frames = Observe(truth, {.noise_px = 0.5});
  for (int i = 0; i < 3; ++i) {  // At the start, too.
    MakeBlind(&frames[i]);
  }
  for (int i = 30; i < 50; ++i) {
    MakeBlind(&frames[i]);
  }
  const auto results = RunOdometry(frames);
  EXPECT_EQ(results[2].segment, 0);
  EXPECT_EQ(results[3].segment, 1);
  for (int i = 30; i < 50; ++i) {
    EXPECT_TRUE(results[i].is_predicted) << i;
  }
  EXPECT_FALSE(results[50].is_predicted);
  EXPECT_EQ(results[79].segment, 1);
  EXPECT_LT(MotionErrors(results, truth, 3, 29).position_m, 0.1);
  for (std::size_t i = 50; i < 80; ++i) {
    const Rigid3 moved = results[3].world_from_body.Inverse() * results[i].world_from_body;
    EXPECT_LT(ErrorOfPose(moved, truth[3].Inverse() * truth[i]).head<3>().norm(), 0.15) << i;
  }
  // Where nothing is seen again the first frame that shows something starts a segment.
  for (int i = 50; i < 80; ++i) {
    for (Observation& observation : frames[i].observations) {
      observation.track_id += 100'000;
    }
  }
  const auto lost = RunOdometry(frames, WithoutPatience());
  EXPECT_EQ(lost[49].segment, 1);
  EXPECT_EQ(lost[50].segment, 2);
  EXPECT_EQ(lost[79].segment, 2);
}

TEST(Odometry, WaitsForWhatItKnowsAsLongAsItIsTold) {
  const auto truth = Flight(40);
  auto frames = Observe(truth, {.noise_px = 0.5});
  for (int i = 20; i < 24; ++i) {
    for (Observation& observation : frames[i].observations) {
      observation.track_id += 100'000 * i;
    }
  }
  OdometryOptions options;
  options.max_predicted_s = 0.45;
  const auto waited = RunOdometry(frames, options);
  EXPECT_TRUE(waited[23].is_predicted);
  EXPECT_FALSE(waited[24].is_predicted);
  EXPECT_EQ(waited[39].segment, 0);
  options.max_predicted_s = 0.25;
  const auto impatient = RunOdometry(frames, options);
  EXPECT_TRUE(impatient[21].is_predicted);
  EXPECT_EQ(impatient[22].segment, 1);
}

TEST(Odometry, GoesOnByTheLeftCameraAlone) {
  const auto truth = Flight(60);
  auto frames = Observe(truth, {.noise_px = 0.5});
  for (int i = 20; i < 40; ++i) {
    for (Observation& observation : frames[i].observations) {
      observation.has_right = false;
    }
  }
  const auto results = RunOdometry(frames);
  for (std::size_t i = 0; i < results.size(); ++i) {
    EXPECT_EQ(results[i].is_left_only, i >= 20 && i < 40) << i;
    EXPECT_FALSE(results[i].is_predicted) << i;
    EXPECT_EQ(results[i].segment, 0) << i;
  }
  EXPECT_LT(MotionErrors(results, truth, 0, 59).position_m, 0.15);
}

// A van that passes from left to right, 2 m away, for 5 s, with more points than all else has.
std::vector<TrackedFrame> WithVan(std::vector<TrackedFrame> frames,
                                  const std::vector<Rigid3>& truth, std::size_t first) {
  constexpr int64_t kVanTracks = 1'000'000;
  std::mt19937_64 generator(5);
  std::vector<Eigen::Vector3d> van(300);
  for (Eigen::Vector3d& point : van) {
    point = Eigen::Vector3d(2.5, 0.0, 0.0) + testing::UniformVector(generator, 0.9);
  }
  for (std::size_t i = first; i < frames.size(); ++i) {
    const double y = 4.0 - 0.16 * static_cast<double>(i - first);
    std::vector<Eigen::Vector3d> points;
    points.reserve(van.size());
    for (const Eigen::Vector3d& point : van) {
      points.push_back(truth[i] * Eigen::Vector3d(point + Eigen::Vector3d(0.0, y, 0.0)));
    }
    const TrackedFrame seen =
        testing::Simulate(testing::SimulatedRig(), points, truth[i], frames[i].timestamp_ns,
                          {.noise_px = 0.5, .max_observations = 300}, kVanTracks);
    frames[i].observations.insert(frames[i].observations.end(), seen.observations.begin(),
                                  seen.observations.end());
  }
  return frames;
}

TEST(Odometry, AVanWithMoreThanHalfOfThePointsDoesNotTakeThePoseWithIt) {
  const auto truth = Flight(80);
  const auto frames = WithVan(Observe(truth, {.noise_px = 0.5}), truth, 15);
  const auto results = RunOdometry(frames);
  int most = 0;
  for (std::size_t i = 1; i < results.size(); ++i) {
    EXPECT_EQ(results[i].segment, 0) << i;
    EXPECT_LT(MotionErrors(results, truth, i - 1, i).position_m, 0.05) << i;
    most = std::max(most, results[i].moving);
  }
  EXPECT_LT(MotionErrors(results, truth, 0, 79).position_m, 0.15);
  EXPECT_GT(most, 200);
  // The van is what is kept out, and what it takes to know it is its past.
  OdometryOptions one_point_one_vote;
  one_point_one_vote.votes.new_vote = 1.0;
  one_point_one_vote.votes.strikes = 0;
  const auto taken_along = RunOdometry(frames, one_point_one_vote);
  EXPECT_GT(MotionErrors(taken_along, truth, 0, 79).position_m, 1.0);
}

TEST(Odometry, SaysWhatItSawInFramesThatItLost) {
  const auto truth = Flight(30);
  auto frames = Observe(truth, {.noise_px = 0.5});
  // A thousandth of the time: 45 times the speed of sound.
  for (std::size_t i = 0; i < frames.size(); ++i) {
    frames[i].timestamp_ns = static_cast<int64_t>(i) * kStepNs / 1000;
    for (Observation& observation : frames[i].observations) {
      observation.tracking_confidence = i > 0 ? 1.0F : 0.0F;
    }
  }
  const auto results = RunOdometry(frames, WithoutPatience());
  EXPECT_EQ(results[0].matched, 0);
  EXPECT_EQ(results[0].tracked, 0);
  EXPECT_EQ(results[1].segment, 1);
  EXPECT_GT(results[1].matched, 50);
  EXPECT_GT(results[1].tracked, 50);
  EXPECT_EQ(results[1].inliers, 0);
  EXPECT_GT(results[1].refused_speed_m_per_s, 60.0);
}

TEST(Odometry, TriesTheFrontEndsOtherWays) {
  // A front end whose first answer is useless and whose second is right.
  class SecondThoughts final : public FrontEnd {
   public:
    explicit SecondThoughts(std::vector<TrackedFrame> frames) : frames_(std::move(frames)) {}
    TrackedFrame Track(const StereoFrame&) override {
      retries_ = 0;
      return next_++ == 20 ? TrackedFrame{frames_[20].timestamp_ns, {}, {}} : frames_[next_ - 1];
    }
    std::optional<TrackedFrame> Retry() override {
      return retries_++ == 0 ? std::optional(frames_[next_ - 1]) : std::nullopt;
    }

   private:
    std::vector<TrackedFrame> frames_;
    std::size_t next_ = 0;
    int retries_ = 0;
  };
  const auto truth = Flight(30);
  const auto frames = Observe(truth, {.noise_px = 0.5});
  Odometry odometry(testing::SimulatedRig(), std::make_unique<SecondThoughts>(frames), {});
  for (const TrackedFrame& frame : frames) {
    StereoFrame images;
    images.timestamp_ns = frame.timestamp_ns;
    EXPECT_EQ(odometry.Process(images).segment, 0);
  }
}

TEST(Odometry, RepeatsItselfBitForBit) {
  const auto frames = Observe(Flight(40), {.noise_px = 0.5, .outlier_share = 0.2});
  const auto first = RunOdometry(frames);
  const auto second = RunOdometry(frames);
  for (std::size_t i = 0; i < first.size(); ++i) {
    EXPECT_EQ(first[i].world_from_body.translation, second[i].world_from_body.translation) << i;
    EXPECT_EQ(first[i].world_from_body.rotation.coeffs(),
              second[i].world_from_body.rotation.coeffs())
        << i;
  }
}

TEST(Odometry, RefusesTimeThatStandsStill) {
  auto frames = Observe(Flight(2), {});
  frames[1].timestamp_ns = frames[0].timestamp_ns;
  EXPECT_THROW(RunOdometry(frames), Error);
}

TEST(Odometry, OptionsAreChecked) {
  OdometryOptions options;
  EXPECT_NO_THROW(options.Validate());
  options.window.size = 2;
  EXPECT_THROW(options.Validate(), Error);
  EXPECT_THROW(Odometry(testing::SimulatedRig(), nullptr, options), Error);
  // Before the networks are looked for.
  OdometryConfig config;
  config.frontend.networks.weights = "absent";
  config.odometry.window.size = 2;
  try {
    const Odometry odometry(testing::SimulatedRig(), config);
    FAIL();
  } catch (const Error& error) {
    EXPECT_NE(std::string(error.what()).find("window.size"), std::string::npos) << error.what();
  }
}

}  // namespace
}  // namespace gluevo::vo
