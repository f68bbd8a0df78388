#include "gluevo/vo/mapping/loop_consistency.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "gluevo/vo/core/options_check.h"
#include "gluevo/vo/core/seconds.h"
#include "gluevo/vo/geometry/pose_uncertainty.h"
#include "loop_measurement.h"

namespace gluevo::vo {

using internal::Chained;
using internal::Inverted;

namespace {

// So many of its own standard deviations odometry may be off as if it were one: they know of noise,
// not of a calibration or a bias, and errors that last add up. Between key frames of rendered
// flights squared errors are four times what they say, over twenty seconds twenty times.
constexpr double kOdometryDoubt = 3.0;

LoopMeasurement AnyOrder(const std::vector<LoopKeyframe>& keyframes, std::size_t a, std::size_t b) {
  return a <= b ? OdometryBetween(keyframes, a, b) : Inverted(OdometryBetween(keyframes, b, a));
}

// Squared standard deviations between two measurements of one motion; the first one's errors count
// `inflation` times.
double SquaredError(const LoopMeasurement& x, const LoopMeasurement& y, double inflation = 1.0) {
  const Eigen::Matrix<double, 6, 1> error =
      ErrorOfPose(x.candidate_from_query, y.candidate_from_query);
  const PoseCovariance both = inflation * inflation * x.covariance + y.covariance;
  return error.dot(both.ldlt().solve(error));
}

bool IsApart(const Loop& x, const Loop& y, const std::vector<LoopKeyframe>& keyframes,
             double min_apart_s) {
  const auto seconds = [&](std::size_t a, std::size_t b) {
    return std::abs(SecondsBetween(keyframes[b].timestamp_ns, keyframes[a].timestamp_ns));
  };
  return seconds(x.query, y.query) >= min_apart_s;
}

// Whether odometry has a say of the motion between them, in either order.
bool IsFollowed(const std::vector<LoopKeyframe>& keyframes, std::size_t a, std::size_t b) {
  const auto [first, last] = std::minmax(a, b);
  if (keyframes[first].segment != keyframes[last].segment) {
    return false;
  }
  for (std::size_t i = first + 1; i <= last; ++i) {
    if (IsDoubtful(keyframes[i].motion_covariance)) {
      return false;
    }
  }
  return true;
}

// What is linked by a doubtful motion agrees with anything, and so with nothing.
bool Agree(const Loop& x, const Loop& y, const std::vector<LoopKeyframe>& keyframes,
           double max_error) {
  if (!IsFollowed(keyframes, x.candidate, y.candidate) ||
      !IsFollowed(keyframes, x.query, y.query)) {
    return false;
  }
  const LoopMeasurement around =
      Chained(Chained(AnyOrder(keyframes, x.candidate, y.candidate), y.measurement),
              AnyOrder(keyframes, y.query, x.query));
  return SquaredError(around, x.measurement, kOdometryDoubt) <= max_error;
}

bool LinksTheSameSegments(const Loop& x, const Loop& y,
                          const std::vector<LoopKeyframe>& keyframes) {
  return keyframes[x.candidate].segment == keyframes[y.candidate].segment &&
         keyframes[x.query].segment == keyframes[y.query].segment;
}

}  // namespace

void LoopConsistencyOptions::Validate() const {
  CheckPositive(max_error, "loops.max_error");
  CheckPositive(max_bend, "loops.max_bend");
  CheckAtLeast(supporters, 0, "loops.supporters");
  CheckAtLeast(strong_inliers, 1, "loops.strong_inliers");
  CheckWithin(min_apart_s, 0.0, 1e9, "loops.min_apart_s");
}

LoopMeasurement OdometryBetween(const std::vector<LoopKeyframe>& keyframes, std::size_t a,
                                std::size_t b) {
  LoopMeasurement motion;
  for (std::size_t i = a + 1; i <= b; ++i) {
    motion = Chained(motion, {keyframes[i].motion, keyframes[i].motion_covariance});
  }
  return motion;
}

LoopTrust Judge(const Loop& loop, const std::vector<Loop>& others,
                const std::vector<LoopKeyframe>& keyframes, const LoopConsistencyOptions& options) {
  if (IsFollowed(keyframes, loop.candidate, loop.query)) {
    const LoopMeasurement odometry = OdometryBetween(keyframes, loop.candidate, loop.query);
    if (SquaredError(odometry, loop.measurement, kOdometryDoubt) <= options.max_error) {
      return LoopTrust::kTrusted;
    }
    if (SquaredError(odometry, loop.measurement, std::max(kOdometryDoubt, options.max_bend)) >
        options.max_error) {
      return LoopTrust::kImpossible;
    }
  } else if (loop.inliers >= options.strong_inliers) {
    // What a doubt or a loss cuts off may be a single frame, which has no others to agree with.
    return LoopTrust::kTrusted;
  }
  int supporters = 0;
  for (const Loop& other : others) {
    if (LinksTheSameSegments(loop, other, keyframes) &&
        IsApart(loop, other, keyframes, options.min_apart_s) &&
        Agree(loop, other, keyframes, options.max_error)) {
      ++supporters;
    }
  }
  return supporters >= options.supporters ? LoopTrust::kTrusted : LoopTrust::kUnsupported;
}

}  // namespace gluevo::vo
