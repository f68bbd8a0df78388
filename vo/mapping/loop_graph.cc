// The pose graph of a run's key frames.

#include <map>
#include <set>
#include <utility>
#include <vector>

#include "gluevo/vo/mapping/loop_closer.h"
#include "linked_segments.h"
#include "pose_graph_edge.h"

namespace gluevo::vo {
namespace {

// Standard deviations from which on errors of loops and of odometry's motions count less. A loop
// that is trusted has been verified both ways; a motion between frames far apart is the likelier to
// be wrong.
constexpr double kLoopLoss = 8.0;
constexpr double kOdometryLoss = 4.0;

// Of a tilt by an inertial unit and the images, radians, where gravity is known in the end.
constexpr double kTiltSigma = 1e-3;

// What no estimate is better than: a tenth of a millimetre, a hundredth of a milliradian.
PoseCovariance WithFloor(const PoseCovariance& covariance) {
  PoseCovariance floored = covariance;
  floored.diagonal().head<3>().array() += 1e-8;
  floored.diagonal().tail<3>().array() += 1e-10;
  return floored;
}

// What the errors of tilts that stay add to that of a measured motion between them.
PoseCovariance OfTilts(const PoseGraphNode& a, const PoseGraphNode& b, const Rigid3& a_from_b) {
  PoseCovariance covariance = PoseCovariance::Zero();
  if (!a.up_in_world || !b.up_in_world) {
    return covariance;
  }
  internal::EdgeJacobian by_a;
  internal::EdgeJacobian by_b;
  internal::ErrorOfEdge(a_from_b, a.world_from_body, a.world_from_body * a_from_b, &by_a, &by_b);
  for (const auto& [node, by] : {std::pair(&a, &by_a), std::pair(&b, &by_b)}) {
    const Eigen::Vector3d up_in_body =
        node->world_from_body.rotation.conjugate() * *node->up_in_world;
    const Eigen::Matrix3d horizontal =
        Eigen::Matrix3d::Identity() - up_in_body * up_in_body.transpose();
    const Eigen::Matrix<double, 6, 3> by_turn = by->rightCols<3>();
    covariance += kTiltSigma * kTiltSigma * by_turn * horizontal * by_turn.transpose();
  }
  return covariance;
}

std::vector<PoseGraphEdge> Edges(const std::vector<LoopKeyframe>& keyframes,
                                 const std::vector<Loop>& loops,
                                 const std::vector<PoseGraphNode>& nodes) {
  std::vector<PoseGraphEdge> edges;
  for (std::size_t i = 1; i < keyframes.size(); ++i) {
    if (keyframes[i].segment == keyframes[i - 1].segment) {
      const LoopMeasurement odometry = OdometryBetween(keyframes, i - 1, i);
      edges.push_back(
          {i - 1, i, odometry.candidate_from_query, WithFloor(odometry.covariance), kOdometryLoss});
    }
  }
  for (const Loop& loop : loops) {
    const PoseCovariance tilt =
        OfTilts(nodes[loop.candidate], nodes[loop.query], loop.measurement.candidate_from_query);
    edges.push_back({loop.candidate, loop.query, loop.measurement.candidate_from_query,
                     WithFloor(loop.measurement.covariance + tilt), kLoopLoss});
  }
  return edges;
}

// Where a segment's world is, tilted about the segment's first key frame so that up is up.
Rigid3 Levelled(const Rigid3& root_from_segment, const Eigen::Vector3d& up_in_segment,
                const Eigen::Vector3d& up_in_root, const LoopKeyframe& first) {
  const Eigen::Quaterniond tilt =
      Eigen::Quaterniond::FromTwoVectors(root_from_segment.rotation * up_in_segment, up_in_root);
  const Eigen::Quaterniond rotation = tilt * root_from_segment.rotation;
  const Eigen::Vector3d& pivot = first.world_from_body.translation;
  return {rotation, root_from_segment * pivot - rotation * pivot};
}

}  // namespace

PoseGraph LoopCloser::Graph() const {
  std::map<int, internal::LinkedSegment> segments = internal::LinkSegments(keyframes_, loops_);
  std::map<int, Eigen::Vector3d> up_in_world = up_in_world_;
  for (const LoopKeyframe& keyframe : keyframes_) {
    if (IsDoubtful(keyframe.motion_covariance)) {
      up_in_world.erase(keyframe.segment);
    }
  }
  std::vector<PoseGraphNode> nodes;
  nodes.reserve(keyframes_.size());
  std::set<int> begun;
  for (const LoopKeyframe& keyframe : keyframes_) {
    internal::LinkedSegment& segment = segments.at(keyframe.segment);
    const auto up = up_in_world.find(keyframe.segment);
    const auto root_up = up_in_world.find(segment.root);
    const bool is_level = up != up_in_world.end() && root_up != up_in_world.end();
    if (begun.insert(keyframe.segment).second && is_level) {
      segment.root_from_segment =
          Levelled(segment.root_from_segment, up->second, root_up->second, keyframe);
    }
    nodes.push_back({.world_from_body = segment.root_from_segment * keyframe.world_from_body});
    if (is_level) {
      nodes.back().up_in_world = root_up->second;
    }
  }
  std::set<int> anchored;
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    nodes[i].is_fixed = anchored.insert(segments.at(keyframes_[i].segment).root).second;
  }
  return {Edges(keyframes_, loops_, nodes), nodes};
}

}  // namespace gluevo::vo
