#include "gluevo/vo/inertial/poses_at_readings.h"

#include <algorithm>

#include "gluevo/vo/geometry/manifold.h"

namespace gluevo::vo {

Trajectory PosesAtReadings(const StampedInertialState& first, const StampedPose& second,
                           const Eigen::Vector3d& gravity_in_world, const ImuReadings& readings) {
  const int64_t begin_ns = first.timestamp_ns;
  const int64_t end_ns = second.timestamp_ns;
  if (end_ns <= begin_ns || !readings.Cover(begin_ns, end_ns)) {
    return {};
  }
  const auto led_to = [&](int64_t time_ns) {
    const Preintegration measured = readings.Between(begin_ns, time_ns, first.state.bias);
    return Predict(first.state, measured, gravity_in_world).world_from_body;
  };
  const Rigid3 at_end = led_to(end_ns);
  const Eigen::Vector3d missing_way = second.world_from_body.translation - at_end.translation;
  const Eigen::Vector3d missing_turn =
      LogSo3(at_end.rotation.conjugate() * second.world_from_body.rotation);
  const std::vector<ImuSample>& samples = readings.samples();
  auto sample =
      std::upper_bound(samples.begin(), samples.end(), begin_ns,
                       [](int64_t time, const ImuSample& one) { return time < one.timestamp_ns; });
  Trajectory poses;
  for (; sample != samples.end() && sample->timestamp_ns <= end_ns; ++sample) {
    const double share = static_cast<double>(sample->timestamp_ns - begin_ns) /
                         static_cast<double>(end_ns - begin_ns);
    const Rigid3 pose = led_to(sample->timestamp_ns);
    poses.push_back({sample->timestamp_ns,
                     {(pose.rotation * ExpSo3(share * missing_turn)).normalized(),
                      pose.translation + share * missing_way}});
  }
  return poses;
}

}  // namespace gluevo::vo
