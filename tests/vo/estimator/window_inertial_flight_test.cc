// A sliding window with an inertial unit over a whole flight.

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <array>
#include <cmath>

#include "gluevo/vo/core/angle.h"
#include "gluevo/vo/estimator/sliding_window.h"
#include "inertial_scene.h"

namespace gluevo::vo {
namespace {

constexpr int64_t kFrameNs = 100'000'000;
constexpr int64_t kSecondNs = 1'000'000'000;

// The window's world is that of the flight: the first pose is given.
class WindowFlight {
 public:
  explicit WindowFlight(unsigned seed)
      : seed_(seed),
        flight_(20, ImuNoise(), /*is_ideal=*/false, seed),
        readings_(ImuNoise()),
        rig_(testing::SimulatedRig()),
        points_(testing::RoomPoints(600, 6.0, seed)),
        window_(rig_, {}) {
    readings_.Add(flight_.samples);
  }

  // The frame is located where it is, but for some millimetres.
  void Add(int64_t time_ns) {
    const TrackedFrame frame =
        testing::Simulate(rig_, points_, flight_.StateAt(time_ns).world_from_body, time_ns,
                          {.noise_px = 0.5, .seed = seed_});
    Rigid3 pose = flight_.StateAt(time_ns).world_from_body;
    if (!window_.empty()) {
      pose.translation += Eigen::Vector3d(0.004, -0.003, 0.005);
    }
    window_.AddFrame(frame, world_from_flight_ * pose,
                     std::vector<std::optional<PnpVerdict>>(frame.observations.size()));
    window_.Triangulate();
    ASSERT_TRUE(window_.Optimize());
    window_.RemoveOutliers();
    window_.MotionSinceKeyframe();
    window_.Slide();
  }
  void Start(int64_t time_ns, double gyroscope_bias_error = 0.001,
             double gyroscope_bias_sigma = 0.001) {
    InertialStart start;
    start.gravity_in_world = TurnedGravity(flight_.gravity, {1.0 * kDegree, -0.7 * kDegree});
    start.bias = flight_.StateAt(time_ns).bias;
    start.bias.accelerometer += Eigen::Vector3d(0.05, -0.05, 0.03);
    start.bias.gyroscope += gyroscope_bias_error * Eigen::Vector3d(1.0, 1.0, -1.0);
    start.covariance.diagonal() << Eigen::Vector3d::Constant(gyroscope_bias_sigma *
                                                             gyroscope_bias_sigma),
        Eigen::Vector3d::Constant(0.1 * 0.1), Eigen::Vector2d::Constant(kDegree * kDegree);
    window_.StartInertia(start, readings_);
  }
  // Of velocity, biases and gravity's direction, where the newest frame is put onto its estimate:
  // what the path before it drifted is not theirs.
  Eigen::Matrix<double, 11, 1> Errors() const {
    const InertialState estimate = window_.state();
    const InertialState truth = flight_.StateAt(newest_ns_);
    const Eigen::Quaterniond world_from_truth =
        estimate.world_from_body.rotation * truth.world_from_body.rotation.conjugate();
    const Eigen::Vector3d& gravity = window_.gravity_in_world();
    Eigen::Matrix<double, 11, 1> errors;
    errors << world_from_truth * truth.velocity_in_world - estimate.velocity_in_world,
        truth.bias.gyroscope - estimate.bias.gyroscope,
        truth.bias.accelerometer - estimate.bias.accelerometer,
        GravityTangent(gravity).transpose() * (world_from_truth * flight_.gravity) /
            gravity.squaredNorm();
    return errors;
  }
  void Fly(int frames) {
    for (int i = 0; i < frames; ++i) {
      newest_ns_ += kFrameNs;
      Add(newest_ns_);
    }
  }

  unsigned seed_;
  InertialFlight flight_;
  ImuReadings readings_;
  StereoRig rig_;
  std::vector<Eigen::Vector3d> points_;
  SlidingWindow window_;
  Rigid3 world_from_flight_;
  int64_t newest_ns_ = 0;
};

TEST(WindowInertialFlightTest, FindsBiasesAndGravityAndKnowsHowWell) {
  constexpr int kFlights = 6;
  constexpr std::array<int, 4> kBlocks = {0, 3, 6, 9};
  constexpr std::array<int, 4> kSizes = {3, 3, 3, 2};
  std::array<double, 4> squares = {};  // In shares of variances.
  double together = 0.0;
  for (unsigned seed = 1; seed <= kFlights; ++seed) {
    WindowFlight flight(seed);
    flight.Fly(15);
    EXPECT_FALSE(flight.window_.Predict(flight.newest_ns_ + kFrameNs));
    flight.Start(flight.newest_ns_);
    flight.Fly(60);
    EXPECT_LT(flight.window_.Misfit().gyroscope, 3.0);
    EXPECT_LT(flight.window_.Misfit().accelerometer, 3.0);
    const Eigen::Matrix<double, 11, 1> errors = flight.Errors();
    EXPECT_LT(errors.head<3>().norm(), 0.05) << seed;
    EXPECT_LT(errors.segment<3>(3).norm(), 2e-3) << seed;
    EXPECT_LT(errors.segment<3>(6).norm(), 0.05) << seed;
    EXPECT_LT(errors.tail<2>().norm(), 0.2 * kDegree) << seed;
    const SlidingWindow::InertialCovariance covariance = *flight.window_.inertial_covariance();
    together += errors.dot(covariance.ldlt().solve(errors)) / (11.0 * kFlights);
    for (std::size_t i = 0; i < kBlocks.size(); ++i) {
      const Eigen::VectorXd error = errors.segment(kBlocks[i], kSizes[i]);
      const Eigen::MatrixXd block = covariance.block(kBlocks[i], kBlocks[i], kSizes[i], kSizes[i]);
      squares[i] += error.dot(block.ldlt().solve(error)) / (kSizes[i] * kFlights);
    }
  }
  // 1 where each is known as well as the window says, with a deviation of sqrt(2 / 12) at most.
  for (const double of_block : squares) {
    EXPECT_LT(of_block, 2.2);
    EXPECT_GT(of_block, 0.2);
  }
  // Of how they belong together it is surer than it should be (2.5 measured): twice as large as
  // said at most.
  EXPECT_LT(together, 4.0);
}

// Of readings all stay when frames leave; so must what their views say.
TEST(WindowInertialFlightTest, ViewsSetRightABiasThatBeganWrong) {
  constexpr double kSurely = 0.0002;
  constexpr int kFlights = 4;
  double square = 0.0;
  for (unsigned seed = 41; seed < 41 + kFlights; ++seed) {
    WindowFlight flight(seed);
    flight.Fly(15);
    flight.Start(flight.newest_ns_, 0.001, kSurely);
    flight.Fly(120);
    square += flight.Errors().segment<3>(3).squaredNorm() / (3.0 * kFlights);
  }
  // 0.00023 measured; 0.00034 where views of tracks that go on are dropped with their frames.
  EXPECT_LT(std::sqrt(square), 0.00028);
}

TEST(WindowInertialFlightTest, PredictsAsWellAsItSays) {
  constexpr int kFlights = 6;
  double squares = 0.0;
  for (unsigned seed = 11; seed < 11 + kFlights; ++seed) {
    WindowFlight flight(seed);
    flight.Fly(15);
    flight.Start(flight.newest_ns_);
    flight.Fly(60);
    const int64_t later = flight.newest_ns_ + kSecondNs;
    const auto prediction = flight.window_.Predict(later);
    ASSERT_TRUE(prediction);
    const Rigid3 motion =
        flight.window_.state().world_from_body.Inverse() * prediction->state.world_from_body;
    const Rigid3 truth = flight.flight_.StateAt(flight.newest_ns_).world_from_body.Inverse() *
                         flight.flight_.StateAt(later).world_from_body;
    EXPECT_LT((motion.translation - truth.translation).norm(), 0.1) << seed;
    EXPECT_LT(motion.rotation.angularDistance(truth.rotation), 0.2 * kDegree) << seed;
    Eigen::Matrix<double, 6, 1> error;
    error << motion.rotation.conjugate() * (truth.translation - motion.translation),
        LogSo3(motion.rotation.conjugate() * truth.rotation);
    squares += error.dot(prediction->covariance.ldlt().solve(error)) / kFlights;
    // Readings end with the flight.
    EXPECT_FALSE(flight.window_.Predict(30 * kSecondNs));
  }
  EXPECT_LT(squares, 15.0);
  EXPECT_GT(squares, 1.5);
}

// Two seconds without a frame, then a scene that was never seen before.
TEST(WindowInertialFlightTest, BridgesFramesThatAreMissing) {
  WindowFlight flight(21);
  flight.Fly(15);
  flight.Start(flight.newest_ns_);
  flight.Fly(60);
  const Rigid3 before = flight.window_.state().world_from_body;
  const int64_t before_ns = flight.newest_ns_;
  flight.newest_ns_ += 2 * kSecondNs;
  const auto prediction = flight.window_.Predict(flight.newest_ns_);
  ASSERT_TRUE(prediction);
  TrackedFrame frame = testing::Simulate(flight.rig_, flight.points_,
                                         flight.flight_.StateAt(flight.newest_ns_).world_from_body,
                                         flight.newest_ns_, {}, /*first_track_id=*/100000);
  flight.window_.AddFrame(frame, prediction->state.world_from_body,
                          std::vector<std::optional<PnpVerdict>>(frame.observations.size()));
  flight.window_.Triangulate();
  ASSERT_TRUE(flight.window_.Optimize());
  const Rigid3 motion = before.Inverse() * flight.window_.state().world_from_body;
  const Rigid3 truth = flight.flight_.StateAt(before_ns).world_from_body.Inverse() *
                       flight.flight_.StateAt(flight.newest_ns_).world_from_body;
  EXPECT_LT((motion.translation - truth.translation).norm(), 0.15);
  EXPECT_LT(motion.rotation.angularDistance(truth.rotation), 0.3 * kDegree);
}

TEST(WindowInertialFlightTest, SurvivesAGapInTheReadings) {
  WindowFlight flight(31);
  std::vector<ImuSample> samples = flight.flight_.samples;
  std::erase_if(samples, [](const ImuSample& sample) {
    return sample.timestamp_ns > 4 * kSecondNs && sample.timestamp_ns < 5 * kSecondNs;
  });
  flight.readings_ = ImuReadings(ImuNoise());
  flight.readings_.Add(samples);
  flight.Fly(15);
  flight.Start(flight.newest_ns_);
  flight.Fly(30);
  EXPECT_FALSE(flight.window_.Predict(flight.newest_ns_ + kFrameNs));
  flight.Fly(45);
  EXPECT_TRUE(flight.window_.Predict(flight.newest_ns_ + kFrameNs));
  EXPECT_LT(flight.Errors().tail<2>().norm(), 0.3 * kDegree);
  EXPECT_LT(flight.Errors().head<3>().norm(), 0.05);
}

}  // namespace
}  // namespace gluevo::vo
