#pragma once

#include <cstddef>
#include <vector>

#include "gluevo/vo/core/pose_covariance.h"
#include "gluevo/vo/core/rigid3.h"

namespace gluevo::vo {

/// A measured motion between two poses of a graph.
struct PoseGraphEdge {
  std::size_t a = 0;  ///< Indices of the poses.
  std::size_t b = 0;
  Rigid3 a_from_b;
  PoseCovariance covariance = PoseCovariance::Identity();
  /// Whether it may be wrong: its error counts by Cauchy's loss, from some standard deviations on
  /// ever less.
  bool is_robust = false;
};

/// The poses `world_from_body` that fit the edges best in the sense of least squares (6 degrees of
/// freedom; Grisetti et al. 2010), from where they are. `is_fixed`: one a pose; poses that no edge
/// leads to stay. The same input gives the same result. Throws Error for a covariance that is not
/// positive definite, naming the edge.
void OptimizePoseGraph(const std::vector<PoseGraphEdge>& edges, const std::vector<bool>& is_fixed,
                       std::vector<Rigid3>& world_from_body);

}  // namespace gluevo::vo
