#include "gluevo/vo/pipeline/odometry.h"

#include <gtest/gtest.h>

#include <memory>
#include <numbers>
#include <set>
#include <string>
#include <vector>

#include "gluevo/nn/error.h"
#include "gluevo/vo/geometry/manifold.h"
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

TEST(Odometry, DeclaresAResetWhenTracksVanish) {
  const auto truth = Flight(60);
  auto frames = Observe(truth, {.noise_px = 0.5});
  for (std::size_t i = 30; i < frames.size(); ++i) {
    for (Observation& observation : frames[i].observations) {
      observation.track_id += 100'000;
    }
  }
  const auto results = RunOdometry(frames);
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
  const auto results = RunOdometry(frames);
  for (std::size_t i = 1; i < results.size(); ++i) {
    ASSERT_TRUE(results[i].world_from_body.translation.allFinite()) << i;
    EXPECT_FALSE(results[i].is_predicted);
    if (results[i].segment == results[i - 1].segment) {
      EXPECT_LT(MotionErrors(results, truth, i - 1, i).position_m, 0.05) << i;
    }
  }
  EXPECT_GT(results[20].segment, results[19].segment);
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

TEST(Odometry, ALongTimeInTheDarkIsABreakAndNotOneAFrame) {
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
  EXPECT_EQ(results[39].segment, 1);
  EXPECT_TRUE(results[39].is_predicted);
  EXPECT_EQ(results[40].segment, 2);  // 1.1 s after the last one that was located.
  EXPECT_EQ(results[49].segment, 2);
  EXPECT_EQ(results[50].segment, 3);
  EXPECT_EQ(results[79].segment, 3);
  EXPECT_LT(MotionErrors(results, truth, 50, 79).position_m, 0.1);
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
  const auto results = RunOdometry(frames);
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
