#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <optional>
#include <vector>

#include "gluevo/vo/core/pose_covariance.h"
#include "gluevo/vo/core/rigid3.h"

namespace gluevo::vo {

/// A pose that edges move.
struct PoseGraphNode {
  Rigid3 world_from_body;
  bool is_fixed = false;
  /// Where gravity is known, the unit vector against it: the pose keeps its tilt and turns about
  /// this axis only, so that four of its degrees of freedom are left (Qin et al. 2018, VI).
  std::optional<Eigen::Vector3d> up_in_world = std::nullopt;
};

/// A measured motion between two poses of a graph.
struct PoseGraphEdge {
  std::size_t a = 0;  ///< Indices of the poses.
  std::size_t b = 0;
  Rigid3 a_from_b;
  PoseCovariance covariance = PoseCovariance::Identity();
  /// Standard deviations from which on its error counts ever less, since it may be wrong
  /// (Cauchy's loss); 0: it is never wrong.
  double loss_scale = 0.0;
};

struct PoseGraph {
  std::vector<PoseGraphEdge> edges;
  std::vector<PoseGraphNode> nodes;
};

std::vector<Rigid3> PosesOf(const PoseGraph& graph);

/// Moves the poses to where they fit the edges best in the sense of least squares (Grisetti et al.
/// 2010), from where they are. Edges that may be wrong count in full first and by their loss step
/// by step (graduated non-convexity: Yang et al. 2020), so that many that agree outvote one that
/// does not, wherever the poses start. Poses that no edge leads to stay. The same input gives the
/// same result. Throws Error for a covariance that is not positive definite, naming the edge.
void OptimizePoseGraph(const std::vector<PoseGraphEdge>& edges, std::vector<PoseGraphNode>& nodes);

}  // namespace gluevo::vo
