#include "pose_association.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <numbers>
#include <string>

#include "gluevo/nn/error.h"

namespace gluevo::vo {
namespace {

constexpr std::size_t kFewestPairs = 3;

/// The pose nearest in time, the earlier of two equally near; null where none is near enough.
const StampedPose* Nearest(const Trajectory& trajectory, int64_t timestamp_ns, uint64_t farthest) {
  const auto after = std::lower_bound(
      trajectory.begin(), trajectory.end(), timestamp_ns,
      [](const StampedPose& pose, int64_t time) { return pose.timestamp_ns < time; });
  const StampedPose* nearest = nullptr;
  uint64_t smallest = farthest;
  if (after != trajectory.end() && TimeApart(after->timestamp_ns, timestamp_ns) <= smallest) {
    nearest = &*after;
    smallest = TimeApart(after->timestamp_ns, timestamp_ns);
  }
  if (after != trajectory.begin() &&
      TimeApart(std::prev(after)->timestamp_ns, timestamp_ns) <= smallest) {
    nearest = &*std::prev(after);
  }
  return nearest;
}

}  // namespace

uint64_t TimeApart(int64_t a_ns, int64_t b_ns) {
  const uint64_t difference = static_cast<uint64_t>(a_ns) - static_cast<uint64_t>(b_ns);
  return a_ns >= b_ns ? difference : uint64_t{0} - difference;
}

std::vector<PosePair> AssociatePoses(const Trajectory& estimate, const Trajectory& groundtruth,
                                     const EvaluationOptions& options) {
  options.Validate();
  constexpr double kNanosecondsPerSecond = 1e9;
  const auto farthest =
      static_cast<uint64_t>(std::llround(options.max_time_difference_s * kNanosecondsPerSecond));
  const bool estimate_is_longer = estimate.size() > groundtruth.size();
  const Trajectory& shorter = estimate_is_longer ? groundtruth : estimate;
  const Trajectory& longer = estimate_is_longer ? estimate : groundtruth;
  std::vector<PosePair> pairs;
  for (const StampedPose& pose : shorter) {
    if (const StampedPose* nearest = Nearest(longer, pose.timestamp_ns, farthest)) {
      pairs.push_back(estimate_is_longer ? PosePair{nearest, &pose} : PosePair{&pose, nearest});
    }
  }
  if (pairs.size() < kFewestPairs) {
    throw Error("only " + std::to_string(pairs.size()) +
                " poses of the estimate and the ground truth are within " +
                std::to_string(options.max_time_difference_s) +
                " s of each other, expected at least 3: are they of the same sequence and clock?");
  }
  return pairs;
}

Rigid3 MotionError(const PosePair& from, const PosePair& to) {
  const Rigid3 true_motion =
      from.groundtruth->world_from_body.Inverse() * to.groundtruth->world_from_body;
  const Rigid3 estimated_motion =
      from.estimate->world_from_body.Inverse() * to.estimate->world_from_body;
  return true_motion.Inverse() * estimated_motion;
}

double AngleOf(const Rigid3& transform) {
  return transform.rotation.angularDistance(Eigen::Quaterniond::Identity());
}

bool IsCorrectMotion(const PosePair& from, const PosePair& to, const EvaluationOptions& options) {
  const Rigid3 error = MotionError(from, to);
  return error.translation.norm() <= options.correct_motion_m &&
         AngleOf(error) * 180.0 / std::numbers::pi <= options.correct_motion_deg;
}

}  // namespace gluevo::vo
