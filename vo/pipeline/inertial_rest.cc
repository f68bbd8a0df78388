#include <algorithm>
#include <cmath>

#include "gluevo/vo/core/seconds.h"
#include "gluevo/vo/pipeline/inertial_navigation.h"

// Where readings and views both show that the body stands still, it does.
namespace gluevo::vo {

bool InertialNavigation::IsRestByReadings(int64_t now_ns, const InertialState& state,
                                          const Eigen::Vector3d& gravity_in_world) const {
  const std::optional<ImuRest> rest =
      FindRest(readings_.samples(), now_ns, /*images_are_still=*/true, options_.rest);
  if (!rest) {
    return false;
  }
  const Eigen::Vector3d force =
      state.bias.accelerometer - state.world_from_body.rotation.conjugate() * gravity_in_world;
  return (rest->angular_velocity - state.bias.gyroscope).norm() <
             options_.rest.largest_rate_deviation &&
         (rest->specific_force - force).norm() < options_.rest.largest_force_deviation;
}

bool InertialNavigation::WatchRest(int64_t now_ns, const InertialState& before,
                                   const Eigen::Vector3d& gravity_in_world) {
  is_resting_ = IsRestByReadings(now_ns, before, gravity_in_world);
  if (!is_resting_) {
    still_views_.Clear();
  }
  return is_resting_;
}

std::optional<StillFactor> InertialNavigation::Stillness(const TrackedFrame& frame,
                                                         int64_t before_ns) {
  // What a body that stands does move, from frame to frame, and how fast.
  constexpr StillFactor kStanding = {1e-5, 1e-5, 5e-4};
  if (!still_views_.has_begun()) {
    return std::nullopt;
  }
  const std::optional<StillViews::Still> still = still_views_.Compare(frame);
  if (!still) {
    still_views_.Clear();
    return std::nullopt;
  }
  // A motion so slow that the views do not show it yet.
  const double speed = still->position_sigma_m / still->since_s;
  const double rate = still->rotation_sigma_rad / still->since_s;
  const double duration_s = SecondsBetween(before_ns, frame.timestamp_ns);
  return StillFactor{std::hypot(kStanding.position_sigma_m, speed * duration_s),
                     std::hypot(kStanding.rotation_sigma_rad, rate * duration_s),
                     std::hypot(kStanding.velocity_sigma, speed)};
}

void InertialNavigation::WatchViews(const TrackedFrame& frame, const std::vector<MapPoint>& points,
                                    const Rigid3& left_cam_from_world) {
  still_views_.Begin(frame, points, left_cam_from_world);
}

}  // namespace gluevo::vo
