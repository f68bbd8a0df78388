#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "gluevo/vo/core/trajectory.h"
#include "gluevo/vo/evaluation/evaluation.h"

namespace gluevo::vo {

/// How good an estimate is whose poses are linked within segments only.
struct SegmentedEvaluation {
  struct Segment {
    int number = 0;         ///< As in segment_of_pose.
    std::size_t pairs = 0;  ///< Associated poses.
    /// The segment on its own, aligned on its own (its coverage is 1); absent where fewer than 3
    /// poses associate.
    std::optional<Evaluation> evaluation;
  };
  std::vector<Segment>
      segments;  ///< In order of time; those without associated poses are left out.
  /// RMSE of the positions of all poses of segments with an evaluation, each segment aligned on its
  /// own (SE(3)), metres; NaN where there is none.
  double ate_within_segments_m = 0.0;
  std::size_t pairs_within_segments = 0;  ///< The poses behind it.
  /// Motions from one associated pose to the next within a segment, and of these the right ones
  /// (see Evaluation): a wrong one is an error that the estimate did not declare.
  std::size_t motions = 0;
  std::size_t correct_motions = 0;
  /// Motions from a segment to the next: what the estimate declared not to know.
  std::size_t breaks = 0;
};

/// `segment_of_pose` has one number for each pose of the estimate, none of them less than the one
/// before. Throws Error as Evaluate does, and where the numbers are not so.
SegmentedEvaluation EvaluateSegments(const Trajectory& estimate,
                                     const std::vector<int>& segment_of_pose,
                                     const Trajectory& groundtruth,
                                     const EvaluationOptions& options);

}  // namespace gluevo::vo
