#pragma once

#include <optional>

#include "gluevo/vo/core/trajectory.h"
#include "gluevo/vo/evaluation/evaluation.h"

namespace gluevo::vo {

/// By how much the times of one of two trajectories are to be multiplied.
struct TimeScale {
  bool of_estimate = true;  ///< Else of the ground truth.
  int power_of_ten = 0;     ///< 3, 6, 9, -3, -6 or -9.
};

/// The scale that makes poses associate where the two files were read in different units of time:
/// nothing where half of the shorter trajectory's poses associate as they are, or with no scale
/// do. Of scales that do equally, the one whose median step is nearest to 0.05 s.
std::optional<TimeScale> FindTimeScale(const Trajectory& estimate, const Trajectory& groundtruth,
                                       const EvaluationOptions& options);

/// Times multiplied by a power of ten, rounded down. Throws Error where they do not fit 64 bits.
void ScaleTimes(int power_of_ten, Trajectory& trajectory);

}  // namespace gluevo::vo
