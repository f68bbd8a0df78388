#include "pose_association.h"

#include <algorithm>
#include <cmath>
#include <iomanip>
#include <iterator>
#include <limits>
#include <sstream>
#include <string>

#include "gluevo/nn/error.h"
#include "gluevo/vo/core/angle.h"
#include "gluevo/vo/core/steps.h"
#include "gluevo/vo/core/text.h"

namespace gluevo::vo {
namespace {

constexpr std::size_t kFewestPairs = 3;
constexpr double kSecondsPerNanosecond = 1e-9;

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

/// "1.5 to 7.25 s", to the millisecond.
std::string TimesOf(const Trajectory& trajectory) {
  if (trajectory.empty()) {
    return "no time";
  }
  std::ostringstream text;
  text << std::fixed << std::setprecision(3)
       << static_cast<double>(trajectory.front().timestamp_ns) * kSecondsPerNanosecond << " to "
       << static_cast<double>(trajectory.back().timestamp_ns) * kSecondsPerNanosecond << " s";
  return text.str();
}

}  // namespace

uint64_t TimeApart(int64_t a_ns, int64_t b_ns) {
  const uint64_t difference = static_cast<uint64_t>(a_ns) - static_cast<uint64_t>(b_ns);
  return a_ns >= b_ns ? difference : uint64_t{0} - difference;
}

double MedianStep(const Trajectory& trajectory) {
  std::vector<uint64_t>
      stamps;  // From the least that there is: steps may be too large for int64_t.
  stamps.reserve(trajectory.size());
  for (const StampedPose& pose : trajectory) {
    stamps.push_back(TimeApart(pose.timestamp_ns, std::numeric_limits<int64_t>::min()));
  }
  return static_cast<double>(MedianStep(std::move(stamps))) * kSecondsPerNanosecond;
}

std::vector<PosePair> NearPoses(const Trajectory& estimate, const Trajectory& groundtruth,
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
  return pairs;
}

namespace {

constexpr double kNearSeconds = 1.0;

/// The least time between a pose of one and a pose of the other, seconds.
double NearestApart(const Trajectory& estimate, const Trajectory& groundtruth) {
  uint64_t apart = std::numeric_limits<uint64_t>::max();
  for (const StampedPose& pose : estimate) {
    if (const StampedPose* nearest = Nearest(groundtruth, pose.timestamp_ns, apart)) {
      apart = std::min(apart, TimeApart(nearest->timestamp_ns, pose.timestamp_ns));
    }
  }
  return static_cast<double>(apart) * kSecondsPerNanosecond;
}

}  // namespace

std::vector<PosePair> AssociatePoses(const Trajectory& estimate, const Trajectory& groundtruth,
                                     const EvaluationOptions& options) {
  std::vector<PosePair> pairs = NearPoses(estimate, groundtruth, options);
  if (pairs.size() < kFewestPairs) {
    std::ostringstream text;
    text << "only " << Counted(pairs.size(), "pose") << " of the estimate and the ground truth "
         << (pairs.size() == 1 ? "is" : "are") << " within " << options.max_time_difference_s
         << " s of each other, expected at least " << kFewestPairs << ": the estimate is from "
         << TimesOf(estimate) << ", the ground truth from " << TimesOf(groundtruth);
    const double apart = NearestApart(estimate, groundtruth);
    if (apart > options.max_time_difference_s && apart < kNearSeconds) {
      text << "; the nearest are " << apart << " s apart (--max-time-difference)";
    } else {
      text << ": are they of the same sequence and clock?";
    }
    throw Error(text.str());
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
         AngleOf(error) / kDegree <= options.correct_motion_deg;
}

}  // namespace gluevo::vo
