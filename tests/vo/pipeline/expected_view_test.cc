// What odometry tells its front end beforehand, from the readings of an inertial unit.

#include <gtest/gtest.h>

#include <algorithm>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "gluevo/vo/pipeline/odometry.h"
#include "vo/inertial/inertial_flight.h"
#include "vo/scene.h"

namespace gluevo::vo {
namespace {

constexpr int64_t kFrameNs = 100'000'000;
constexpr int kFrames = 100;

int64_t TimeOf(int frame) { return kFrameNs * (frame + 1); }

struct Errors {
  int frames = 0;                 // Of which something was said,
  int frames_with_points = 0;     // and of their points, too.
  double worst_turn = 0.0;        // Radians, from the third frame on.
  std::vector<double> misses_px;  // Of points.
};

// Plays given frames and compares them with what it was told.
class Listener final : public FrontEnd {
 public:
  Listener(std::vector<TrackedFrame> frames, Trajectory truth, Errors& errors)
      : frames_(std::move(frames)), truth_(std::move(truth)), errors_(errors) {}
  void Expect(const ExpectedView& view) override { view_ = view; }
  TrackedFrame Track(const StereoFrame&) override {
    const TrackedFrame& frame = frames_.at(next_);
    if (view_) {
      Compare(frame);
    }
    view_.reset();
    ++next_;
    return frame;
  }

 private:
  void Compare(const TrackedFrame& frame) {
    const StereoRig rig = testing::SimulatedRig();
    const auto camera_at = [&](std::size_t i) {
      return truth_[i].world_from_body.rotation * rig.body_from_cam[0].rotation;
    };
    ++errors_.frames;
    errors_.frames_with_points += view_->pixels.empty() ? 0 : 1;
    const Eigen::Quaterniond turn = camera_at(next_).conjugate() * camera_at(next_ - 1);
    constexpr std::size_t kFirst = 3;
    if (next_ >= kFirst) {
      errors_.worst_turn = std::max(errors_.worst_turn, view_->now_from_last.angularDistance(turn));
    }
    for (const Observation& observation : frame.observations) {
      const auto found = view_->pixels.find(observation.track_id);
      if (found != view_->pixels.end()) {
        errors_.misses_px.push_back(
            (rig.cameras[0].Distort(observation.left) - found->second).norm());
      }
    }
  }

  std::vector<TrackedFrame> frames_;
  Trajectory truth_;
  Errors& errors_;
  std::optional<ExpectedView> view_;
  std::size_t next_ = 0;
};

struct Scene {
  Scene() : flight(kFrames / 10 + 1, ImuNoise(), /*is_ideal=*/false, 3U) {
    const std::vector<Eigen::Vector3d> points = testing::RoomPoints(3000, 6.0, 3U);
    for (int i = 0; i < kFrames; ++i) {
      truth.push_back({TimeOf(i), flight.StateAt(TimeOf(i)).world_from_body});
      frames.push_back(testing::Simulate(testing::SimulatedRig(), points,
                                         truth.back().world_from_body, TimeOf(i),
                                         {.noise_px = 0.5, .seed = 3U}, 0));
    }
  }

  InertialFlight flight;
  Trajectory truth;
  std::vector<TrackedFrame> frames;
};

Errors Fly(const Scene& scene, const std::vector<ImuSample>& samples) {
  Errors errors;
  Odometry odometry(testing::SimulatedRig(),
                    std::make_unique<Listener>(scene.frames, scene.truth, errors),
                    OdometryOptions());
  if (!samples.empty()) {
    odometry.UseImu(ImuNoise());
    odometry.AddImu(samples);
  }
  for (const TrackedFrame& frame : scene.frames) {
    odometry.Process({frame.timestamp_ns, {}});
  }
  return errors;
}

TEST(ExpectedViewTest, SaysHowTheCameraTurnsAtOnceAndWherePointsAreOnceTheUnitStarted) {
  const Scene scene;
  Errors errors = Fly(scene, scene.flight.samples);
  EXPECT_EQ(errors.frames, kFrames - 1);
  EXPECT_GT(errors.frames_with_points, 40);
  EXPECT_LT(errors.frames_with_points, kFrames - 10);
  // 0.02 rad/s of bias in 0.1 s, before it is known, is 2 mrad.
  EXPECT_LT(errors.worst_turn, 0.005);
  ASSERT_GT(errors.misses_px.size(), 1000U);
  std::sort(errors.misses_px.begin(), errors.misses_px.end());
  EXPECT_LT(errors.misses_px[errors.misses_px.size() / 2], 2.0);
}

TEST(ExpectedViewTest, SaysNothingWithoutAUnit) {
  const Scene scene;
  EXPECT_EQ(Fly(scene, {}).frames, 0);
}

TEST(ExpectedViewTest, AUnitThatTheFramesContradictIsNotBelieved) {
  const Scene scene;
  std::vector<ImuSample> turned = scene.flight.samples;
  for (ImuSample& sample : turned) {
    // Degrees in place of radians.
    sample.angular_velocity *= 57.3;
  }
  // The first frames' turns have to show it.
  EXPECT_LT(Fly(scene, turned).frames, 15);
}

}  // namespace
}  // namespace gluevo::vo
