#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "gluevo/vo/core/trajectory.h"
#include "gluevo/vo/evaluation/evaluation.h"

namespace gluevo::vo {

/// An estimated pose and the true one of the same time.
struct PosePair {
  const StampedPose* estimate;
  const StampedPose* groundtruth;
};

/// |a - b|, which an int64_t may not hold.
uint64_t TimeApart(int64_t a_ns, int64_t b_ns);

/// Median time from a pose to the next, seconds; 0 for fewer than two poses.
double MedianStep(const Trajectory& trajectory);

/// Pairs as `Evaluation` says, however few. Throws Error for options out of their range.
std::vector<PosePair> NearPoses(const Trajectory& estimate, const Trajectory& groundtruth,
                                const EvaluationOptions& options);

/// Pairs as `Evaluation` says, in order of time; they point into the trajectories. Throws Error for
/// options out of their range and where fewer than 3 poses associate.
std::vector<PosePair> AssociatePoses(const Trajectory& estimate, const Trajectory& groundtruth,
                                     const EvaluationOptions& options);

/// Error of the estimated motion from one pose to another, in the body's frame at the latter.
Rigid3 MotionError(const PosePair& from, const PosePair& to);

/// Angle of a rotation, radians, 0 to pi.
double AngleOf(const Rigid3& transform);

/// Whether the motion from one pose to another is correct within the options' bounds.
bool IsCorrectMotion(const PosePair& from, const PosePair& to, const EvaluationOptions& options);

}  // namespace gluevo::vo
