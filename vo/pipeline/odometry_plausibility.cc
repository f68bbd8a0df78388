
#include "gluevo/vo/core/angle.h"
#include "gluevo/vo/core/seconds.h"
#include "gluevo/vo/pipeline/odometry.h"

// Which motions can be a rig's.
namespace gluevo::vo {
namespace {

bool IsFinite(const Rigid3& pose) {
  return pose.translation.allFinite() && pose.rotation.coeffs().allFinite();
}

}  // namespace

double Odometry::SpeedTo(const Rigid3& world_from_body, int64_t timestamp_ns) const {
  const StampedPose& last = *history_.last();
  const double seconds = SecondsBetween(last.timestamp_ns, timestamp_ns);
  return (world_from_body.translation - last.world_from_body.translation).norm() / seconds;
}

bool Odometry::IsPlausible(const Rigid3& world_from_body, int64_t timestamp_ns) const {
  const std::optional<StampedPose>& last = history_.last();
  if (!last) {
    return IsFinite(world_from_body);
  }
  const double seconds = SecondsBetween(last->timestamp_ns, timestamp_ns);
  const Rigid3 motion = last->world_from_body.Inverse() * world_from_body;
  const double turn_deg = motion.rotation.angularDistance(Eigen::Quaterniond::Identity()) / kDegree;
  return IsFinite(world_from_body) &&
         motion.translation.norm() <= options_.max_speed_m_per_s * seconds &&
         turn_deg <= options_.max_turn_deg_per_s * seconds;
}

}  // namespace gluevo::vo
