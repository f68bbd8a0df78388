#include <algorithm>
#include <cmath>

#include "gluevo/nn/error.h"
#include "gluevo/nn/option_error.h"
#include "gluevo/vo/estimator/sliding_window.h"
#include "gluevo/vo/geometry/eigen_solvers.h"
#include "gluevo/vo/geometry/projection.h"
#include "gluevo/vo/pipeline/odometry.h"
#include "odometry_frame_pose.h"

// The inertial unit's part: where it leads, and when it may.
namespace gluevo::vo {
namespace {

// So many poses in sequence from images are right, and the readings wrong.
constexpr int kMostContradictions = 3;

}  // namespace

void Odometry::UseImu(const ImuNoise& noise) {
  if (options_.window.solver != "gluevo") {
    throw OptionError("option window.solver (--solver) is " + Quoted(options_.window.solver) +
                      "; expected gluevo where an inertial unit is used");
  }
  navigation_ = std::make_unique<InertialNavigation>(noise, options_.inertial);
}

void Odometry::AddImu(std::span<const ImuSample> samples) {
  if (!navigation_) {
    throw Error("inertial readings for an odometry that uses no inertial unit");
  }
  navigation_->Add(samples);
}

void Odometry::Expect(int64_t timestamp_ns) {
  expected_.reset();
  if (const auto prediction = window_->Predict(timestamp_ns)) {
    expected_ = {prediction->state.world_from_body, prediction->covariance};
  }
  if (const std::optional<ExpectedView> view = ExpectView(timestamp_ns)) {
    frontend_->Expect(*view);
  }
}

std::optional<ExpectedView> Odometry::ExpectView(int64_t timestamp_ns) const {
  if (!navigation_ || window_->empty()) {
    return std::nullopt;
  }
  const Rigid3& body_from_cam = rig_.body_from_cam[0];
  const Rigid3& world_from_last = window_->world_from_body();
  ExpectedView view;
  if (expected_) {
    const Rigid3 cam_from_world = (expected_->world_from_body * body_from_cam).Inverse();
    view.now_from_last =
        cam_from_world.rotation * world_from_last.rotation * body_from_cam.rotation;
    for (const MapPoint& point : window_->MapPoints()) {
      const Eigen::Vector3d in_cam = cam_from_world * point.point_in_world;
      if (IsInFront(in_cam)) {
        view.pixels[point.track_id] = rig_.cameras[0].Project(in_cam);
      }
    }
    return view;
  }
  const std::optional<Eigen::Quaterniond> turn =
      navigation_->Turn(history_.last()->timestamp_ns, timestamp_ns);
  if (!turn) {
    return std::nullopt;
  }
  view.now_from_last =
      body_from_cam.rotation.conjugate() * turn->conjugate() * body_from_cam.rotation;
  return view;
}

Rigid3 Odometry::Predict(int64_t timestamp_ns) const {
  return expected_ ? expected_->world_from_body : history_.Predict(timestamp_ns);
}

std::vector<Rigid3> Odometry::Guesses(int64_t timestamp_ns) const {
  std::vector<Rigid3> guesses = history_.Guesses();
  if (passed_over_ > 0 || expected_) {
    guesses.push_back(Predict(timestamp_ns));
  }
  return guesses;
}

bool Odometry::Contradicts(const PnpResult& pnp) const {
  if (!expected_ || contradictions_ >= kMostContradictions) {
    return false;
  }
  // Beside what both know of themselves, for clocks and mountings that are a little off.
  constexpr double kSigmas = 6.0;
  constexpr double kSlackM = 0.1;
  constexpr double kSlackRad = 0.03;
  const Rigid3 difference = expected_->world_from_body.Inverse() * pnp.world_from_body;
  const auto limit = [&](int block, double own, double slack) {
    return slack +
           kSigmas * std::hypot(own, WorstSigma(expected_->covariance.block<3, 3>(block, block)));
  };
  return difference.translation.norm() > limit(0, pnp.position_sigma_m, kSlackM) ||
         difference.rotation.angularDistance(Eigen::Quaterniond::Identity()) >
             limit(3, pnp.rotation_sigma_rad, kSlackRad);
}

void Odometry::HeedContradictions(bool is_located, const FrameResult& result) {
  if (is_located && contradictions_ >= kMostContradictions) {
    window_->StopInertia();
    navigation_->Restart();
    navigation_->Forget();
    expected_.reset();
  }
  if (is_located) {
    contradictions_ = 0;
  } else if (result.is_refused_by_inertia) {
    ++contradictions_;
  }
}

std::optional<Odometry::FramePose> Odometry::Bridge(const TrackedFrame& frame) const {
  if (!expected_ || WorstSigma(expected_->covariance.topLeftCorner<3, 3>()) >
                        options_.inertial.max_bridge_sigma_m) {
    return std::nullopt;
  }
  FramePose pose{expected_->world_from_body, 0, {}, 0.0};
  // What was matched was matched wrongly.
  pose.verdicts.assign(frame.observations.size(), PnpVerdict::kOutlier);
  return pose;
}

std::optional<StillFactor> Odometry::Stillness(const TrackedFrame& frame) {
  if (!navigation_ || !history_.last() ||
      (window_->has_inertia() && !navigation_->WatchRest(frame.timestamp_ns, window_->state(),
                                                         window_->gravity_in_world()))) {
    return std::nullopt;
  }
  return navigation_->Stillness(frame, history_.last()->timestamp_ns);
}

void Odometry::FollowInertia(bool is_linked, FrameResult& result) {
  if (!navigation_) {
    return;
  }
  if (!is_linked) {
    navigation_->Restart();
  }
  if (window_->has_inertia()) {
    if (window_->inertial_covariance()) {
      const SlidingWindow::InertialMisfit misfit = window_->Misfit();
      navigation_->Watch(misfit.gyroscope, misfit.accelerometer);
      result.inertial = DescribeInertia();
      navigation_->Keep(result.timestamp_ns, result.world_from_body.rotation, *result.inertial);
    }
    if (window_->time_offset_s()) {
      navigation_->FollowTimeOffset(*window_->time_offset_s(), window_->time_offset_sigma_s());
    }
    navigation_->ForgetBefore(window_->oldest_timestamp_ns());
  } else if (const auto start = navigation_->Try({result.timestamp_ns, result.world_from_body})) {
    window_->StartInertia(*start, navigation_->readings());
    window_->Optimize();
  }
  if (navigation_->WantsViews()) {
    navigation_->WatchViews(result.tracked_frame, window_->MapPoints(),
                            (window_->world_from_body() * rig_.body_from_cam[0]).Inverse());
  }
}

InertialEstimate Odometry::DescribeInertia() const {
  const InertialState state = window_->state();
  const SlidingWindow::InertialCovariance& covariance = *window_->inertial_covariance();
  const SlidingWindow::InertialMisfit misfit = window_->Misfit();
  const auto sigma = [&](int block) { return WorstSigma(covariance.block<3, 3>(block, block)); };
  Eigen::Matrix3d of_gravity = Eigen::Matrix3d::Zero();
  of_gravity.topLeftCorner<2, 2>() = covariance.bottomRightCorner<2, 2>();
  return {.velocity_in_world = state.velocity_in_world,
          .gravity_in_world = window_->gravity_in_world(),
          .bias = state.bias,
          .velocity_sigma = sigma(0),
          .gravity_sigma = WorstSigma(of_gravity),
          .gyroscope_bias_sigma = sigma(3),
          .accelerometer_bias_sigma = sigma(6),
          .gyroscope_rms = std::sqrt(misfit.gyroscope),
          .accelerometer_rms = std::sqrt(misfit.accelerometer),
          .time_offset_s = window_->time_offset_s(),
          .time_offset_sigma_s = window_->time_offset_sigma_s()};
}

}  // namespace gluevo::vo
