#include "gluevo/vo/pipeline/inertial_navigation.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "gluevo/vo/core/angle.h"
#include "gluevo/vo/core/options_check.h"
#include "gluevo/vo/core/seconds.h"
#include "gluevo/vo/inertial/gyroscope_check.h"

namespace gluevo::vo {

void InertialOptions::Validate() const {
  start.Validate();
  rest.Validate();
  CheckPositive(max_bridge_sigma_m, "inertial.max_bridge_sigma_m");
  CheckWithin(bridge_after_s, 0.0, 1e6, "inertial.bridge_after_s");
  CheckWithin(time_offset_sigma_s, 1e-6, 0.1, "inertial.time_offset_sigma_s");
}

InertialNavigation::InertialNavigation(const ImuNoise& noise, const InertialOptions& options)
    : noise_(noise), options_(options), readings_(noise) {
  options_.Validate();
  if (options_.estimate_time_offset) {
    options_.start.time_offset_sigma_s = options_.time_offset_sigma_s;
  }
}

void InertialNavigation::FollowTimeOffset(double time_offset_s, double sigma_s) {
  // The window takes smaller changes into account by itself.
  constexpr double kSmall = 1e-4;
  options_.start.time_offset_sigma_s = std::max(kSmall, sigma_s);
  if (std::abs(time_offset_s - readings_.time_offset_s()) > kSmall) {
    readings_.set_time_offset_s(time_offset_s);
  }
}

void InertialNavigation::ForgetBefore(int64_t time_ns) {
  // The time offset may move by so much.
  constexpr int64_t kMarginNs = 200'000'000;
  readings_.ForgetBefore(options_.estimate_time_offset ? time_ns - kMarginNs : time_ns);
}

bool InertialNavigation::Sensor::Watch(double of_frame) {
  // A sensor as good as it should be stays well below: most rows are met by what is estimated.
  constexpr double kShare = 0.05;
  constexpr double kTooLarge = 1.5;
  constexpr double kMostFactor = 100.0;
  mean_square += kShare * (of_frame - mean_square);
  if (mean_square < kTooLarge || factor >= kMostFactor) {
    return false;
  }
  factor = std::min(kMostFactor, factor * std::sqrt(mean_square));
  mean_square = 1.0;
  return true;
}

void InertialNavigation::Watch(double gyroscope_mean_square, double accelerometer_mean_square) {
  const bool is_noisier = gyroscope_.Watch(gyroscope_mean_square);
  if (accelerometer_.Watch(accelerometer_mean_square) || is_noisier) {
    SetNoise();
  }
}

void InertialNavigation::SetNoise() {
  ImuNoise noise = noise_;
  noise.gyroscope_density *= gyroscope_.factor;
  noise.accelerometer_density *= accelerometer_.factor;
  readings_.set_noise(noise);
}

void InertialNavigation::WatchClock(const StampedPose& world_from_body, bool has_inertia) {
  if (!options_.estimate_time_offset) {
    clock_.SetHasInertia(has_inertia);
    clock_.Add(world_from_body, readings_);
  }
}

void InertialNavigation::Restart() {
  clock_.Break();
  still_views_.Clear();
  is_resting_ = true;
  frames_.clear();
  why_waiting_ = "no frames";
}

std::optional<InertialStart> InertialNavigation::Try(const StampedPose& world_from_body) {
  constexpr double kLongestS = 10.0;
  constexpr std::size_t kFewest = 12;
  frames_.push_back(world_from_body);
  LearnTurn();
  const int64_t now_ns = world_from_body.timestamp_ns;
  while (frames_.size() > kFewest &&
         SecondsBetween(frames_.front().timestamp_ns, now_ns) > kLongestS) {
    frames_.erase(frames_.begin());
  }
  ForgetBefore(kept_ ? std::min(kept_->timestamp_ns, frames_.front().timestamp_ns)
                     : frames_.front().timestamp_ns);
  std::optional<InertialStart> start = TryKept();
  bool is_at_rest = false;
  if (!start) {
    start = TryAtRest();
    is_at_rest = start.has_value();
  }
  constexpr double kEveryS = 0.5;
  if (!start && SecondsBetween(tried_ns_, now_ns) >= kEveryS) {
    tried_ns_ = now_ns;
    start = TryInMotion();
  }
  if (start) {
    if (!begin_) {
      begin_ = {now_ns, is_at_rest, start->gravity_sigma};
    }
    why_waiting_.clear();
    frames_.clear();
  }
  return start;
}

bool InertialNavigation::ImagesAreStill() const {
  constexpr double kMoved = 0.01;  // Metres.
  constexpr double kTurned = 0.3 * kDegree;
  const StampedPose& now = frames_.back();
  for (auto frame = frames_.rbegin(); frame != frames_.rend(); ++frame) {
    const Rigid3 motion = now.world_from_body.Inverse() * frame->world_from_body;
    if (motion.translation.norm() > kMoved ||
        motion.rotation.angularDistance(Eigen::Quaterniond::Identity()) > kTurned) {
      return false;
    }
    if (SecondsBetween(frame->timestamp_ns, now.timestamp_ns) >= options_.rest.duration_s) {
      return true;
    }
  }
  return false;
}

std::optional<InertialStart> InertialNavigation::TryAtRest() {
  const StampedPose& now = frames_.back();
  const std::optional<ImuRest> rest =
      FindRest(readings_.samples(), now.timestamp_ns, ImagesAreStill(), options_.rest);
  if (!rest) {
    return std::nullopt;
  }
  InertialStart start = StartAtRest(*rest, now.world_from_body, options_.start);
  if (!start.refused.empty()) {
    why_waiting_ = start.refused;
    return std::nullopt;
  }
  // Rest tells nothing of it.
  start.time_offset_sigma_s = options_.start.time_offset_sigma_s;
  return start;
}

Trajectory InertialNavigation::Chosen() const {
  constexpr std::size_t kMost = 30;
  const std::size_t step = (frames_.size() + kMost - 1) / kMost;
  Trajectory chosen;
  chosen.reserve(kMost);
  for (std::size_t i = (frames_.size() - 1) % step; i < frames_.size(); i += step) {
    chosen.push_back(frames_[i]);
  }
  return chosen;
}

std::optional<InertialStart> InertialNavigation::TryInMotion() {
  const Trajectory frames = Chosen();
  constexpr double kGoodRms = 1.5;
  constexpr double kMostFactor = 30.0;
  constexpr double kStep = 3.0;
  for (double factor = accelerometer_.factor;; factor *= kStep) {
    ImuNoise noise = readings_.noise();
    noise.accelerometer_density = factor * noise_.accelerometer_density;
    InertialStart start = StartInMotion(frames, readings_.samples(), noise, options_.start);
    if (start.motion_rms > kGoodRms && factor < kMostFactor) {
      continue;
    }
    if (start.refused.empty()) {
      accelerometer_.factor = factor;
      SetNoise();
      if (options_.estimate_time_offset) {
        readings_.set_time_offset_s(readings_.time_offset_s() + start.time_offset_s);
      }
      return start;
    }
    const GyroscopeCheck check = CheckGyroscope(frames, readings_.samples());
    why_waiting_ = check.fault.empty() ? start.refused : check.fault;
    return std::nullopt;
  }
}

}  // namespace gluevo::vo
