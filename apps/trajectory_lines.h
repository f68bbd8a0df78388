#pragma once

#include <Eigen/Geometry>
#include <vector>

#include "gluevo/vo/core/trajectory.h"
#include "gluevo/vo/evaluation/segment_evaluation.h"

namespace gluevo::apps {

/// An estimate over ground truth, ready to be drawn: positions in the ground truth's world, metres.
struct TrajectoryLines {
  std::vector<Eigen::Vector3d> groundtruth;
  std::vector<std::vector<Eigen::Vector3d>> estimate;  ///< One line a segment.
};

/// The whole estimate as one line, aligned by SE(3).
TrajectoryLines AlignWhole(const vo::Trajectory& estimate, const vo::Trajectory& groundtruth,
                           const vo::Evaluation& evaluation);

/// Each segment aligned on its own; those that are too short for it are left out.
TrajectoryLines AlignSegments(const vo::Trajectory& estimate,
                              const std::vector<int>& segment_of_pose,
                              const vo::Trajectory& groundtruth,
                              const vo::SegmentedEvaluation& evaluation);

/// How the world lies on paper: along the two axes in which the ground truth (or, where there is
/// none, the estimate) extends most.
struct PlanView {
  int across = 0;  ///< Axis, 0 to 2.
  int up = 1;
  Eigen::AlignedBox3d box;  ///< Around all lines.

  /// Largest side of what is drawn, metres, above 0.
  double Extent() const;
};

PlanView ChooseView(const TrajectoryLines& lines);

}  // namespace gluevo::apps
