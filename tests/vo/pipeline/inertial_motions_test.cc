// Motions that tell an inertial unit little: it must wait, or do no harm.

#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <string>
#include <vector>

#include "gluevo/vo/core/angle.h"
#include "gluevo/vo/pipeline/odometry.h"
#include "vo/inertial/simulated_motion.h"
#include "vo/scene.h"

namespace gluevo::vo {
namespace {

constexpr int64_t kFrameNs = 100'000'000;

/// A path, flown with and without its readings.
class Flight {
 public:
  Flight(const std::string& path, int seconds, unsigned seed)
      : Flight(simulation::MakeSimulationPath(path), seconds, seed) {}
  Flight(const simulation::SimulationPath& path, int seconds, unsigned seed)
      : motion_(path, seconds, seed) {
    const std::vector<Eigen::Vector3d> points = testing::RoomPoints(3000, 6.0, seed);
    // The last readings are behind the last frame.
    for (int64_t time_ns = kFrameNs; time_ns < seconds * 1'000'000'000LL; time_ns += kFrameNs) {
      frames_.push_back(testing::Simulate(testing::SimulatedRig(), points, Truth(time_ns), time_ns,
                                          {.noise_px = 0.5, .seed = seed}));
    }
    with_ = std::make_unique<Odometry>(MakeOdometry());
    with_->UseImu(ImuNoise());
    with_->AddImu(motion_.samples);
    Fly(*with_, with_results_);
    Odometry without = MakeOdometry();
    Fly(without, without_results_);
  }

  const InertialNavigation& inertial() const { return *with_->inertial(); }
  const std::vector<FrameResult>& with() const { return with_results_; }
  const std::vector<FrameResult>& without() const { return without_results_; }
  /// Root mean square error of a second's motion, metres.
  double Error(const std::vector<FrameResult>& results) const {
    constexpr std::size_t kSecond = 10;
    double sum = 0.0;
    for (std::size_t i = kSecond; i < results.size(); ++i) {
      const Rigid3 found =
          results[i - kSecond].world_from_body.Inverse() * results[i].world_from_body;
      const Rigid3 truth =
          Truth(results[i - kSecond].timestamp_ns).Inverse() * Truth(results[i].timestamp_ns);
      sum += (found.translation - truth.translation).squaredNorm();
    }
    return std::sqrt(sum / static_cast<double>(results.size() - kSecond));
  }
  /// Radians between gravity as found and as it is, in the body of the last frame: what the path
  /// drifted before is not gravity's.
  double GravityError() const {
    const FrameResult& last = with_results_.back();
    const Eigen::Vector3d found =
        last.world_from_body.rotation.conjugate() * last.inertial->gravity_in_world;
    const Eigen::Vector3d truth =
        Truth(last.timestamp_ns).rotation.conjugate() * -Eigen::Vector3d::UnitZ();
    return AngleBetween(found, truth);
  }

 private:
  Rigid3 Truth(int64_t time_ns) const { return motion_.path(1e-9 * static_cast<double>(time_ns)); }
  Odometry MakeOdometry() const {
    return {testing::SimulatedRig(), std::make_unique<testing::ScriptedFrontEnd>(frames_),
            OdometryOptions()};
  }
  void Fly(Odometry& odometry, std::vector<FrameResult>& results) const {
    for (const TrackedFrame& frame : frames_) {
      results.push_back(odometry.Process({frame.timestamp_ns, {}}));
    }
  }

  SimulatedMotion motion_;
  std::vector<TrackedFrame> frames_;
  std::unique_ptr<Odometry> with_;
  std::vector<FrameResult> with_results_;
  std::vector<FrameResult> without_results_;
};

// At constant velocity, with nothing that turns, a tilt looks like a bias of the accelerometer.
TEST(InertialMotionsTest, AtConstantVelocityStereoAloneGoesOnToTheLastBit) {
  const Flight flight("straight", /*seconds=*/8, 1);
  EXPECT_FALSE(flight.inertial().begin());
  EXPECT_NE(flight.inertial().why_waiting().find("the body has to turn"), std::string::npos)
      << flight.inertial().why_waiting();
  for (std::size_t i = 0; i < flight.with().size(); ++i) {
    EXPECT_EQ(flight.with()[i].world_from_body.translation,
              flight.without()[i].world_from_body.translation);
    EXPECT_EQ(flight.with()[i].world_from_body.rotation.coeffs(),
              flight.without()[i].world_from_body.rotation.coeffs());
  }
}

// By the mean of some flights: in each alone chance decides which of the two is ahead, at rest by a
// factor of two.
TEST(InertialMotionsTest, PureRotationMotionInAPlaneAndRestGain) {
  struct Case {
    std::string path;
    unsigned flights;
    double bound;
  };
  for (const auto& [path, flights, bound] :
       {Case{"rest", 30, 0.9}, Case{"spin", 6, 0.9}, Case{"planar", 6, 0.9}}) {
    double with = 0.0;
    double without = 0.0;
    for (unsigned seed = 1; seed <= flights; ++seed) {
      const Flight flight(path, /*seconds=*/8, seed);
      ASSERT_TRUE(flight.inertial().begin()) << path;
      EXPECT_EQ(flight.inertial().begin()->is_at_rest, path == "rest");
      const InertialEstimate& last = *flight.with().back().inertial;
      // At rest alone the accelerometer's bias limits it.
      EXPECT_LT(flight.GravityError(), 4.0 * last.gravity_sigma) << path << seed;
      EXPECT_LT(last.gravity_sigma, (path == "rest" ? 3.0 : 0.3) * kDegree) << path;
      with += flight.Error(flight.with());
      without += flight.Error(flight.without());
    }
    EXPECT_LT(with, bound * without) << path;
  }
}

// Slower than readings show. What looks like rest until views show that it is not must not hold
// the rig where it was.
TEST(InertialMotionsTest, CreepingIsNotTakenForRest) {
  const simulation::SimulationPath rest = simulation::MakeSimulationPath("rest");
  for (const double speed : {0.002, 0.02}) {
    const auto creeping = [&](double time_s) {
      Rigid3 pose = rest(time_s);
      pose.translation.y() += speed * time_s;
      return pose;
    };
    double with = 0.0;
    double without = 0.0;
    for (unsigned seed = 1; seed <= 10; ++seed) {
      const Flight flight(creeping, /*seconds=*/8, seed);
      ASSERT_TRUE(flight.inertial().begin());
      with += flight.Error(flight.with());
      without += flight.Error(flight.without());
    }
    EXPECT_LT(with, 1.1 * without) << speed;
  }
}

}  // namespace
}  // namespace gluevo::vo
