#include "gluevo/vo/mapping/loop_closer.h"

#include <algorithm>
#include <map>
#include <set>
#include <utility>

#include "gluevo/vo/core/options_check.h"
#include "gluevo/vo/core/seconds.h"
#include "gluevo/vo/mapping/pose_graph.h"
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

void LoopOptions::Validate() const {
  CheckWithin(interval_s, 0.0, 1e9, "loops.interval_s (--loop-interval)");
  CheckWithin(min_age_s, 0.0, 1e9, "loops.min_age_s (--loop-min-age)");
  CheckWithin(min_similarity, -1.0, 1.0, "loops.min_similarity");
  CheckWithin(min_similarity_share, 0.0, 1.0, "loops.min_similarity_share");
  CheckAtLeast(max_candidates, 1, "loops.max_candidates (--loop-candidates)");
  verification.Validate();
  consistency.Validate();
}

LoopCloser::LoopCloser(const StereoRig& rig, PlaceCodebook codebook,
                       std::shared_ptr<Matcher> matcher, const LoopOptions& options)
    : rig_(rig), codebook_(std::move(codebook)), matcher_(std::move(matcher)), options_(options) {
  options_.Validate();
}

void LoopCloser::Load(std::vector<LoopKeyframe> keyframes, std::vector<Loop> loops) {
  keyframes_ = std::move(keyframes);
  loops_ = std::move(loops);
  loaded_ = keyframes_.size();
  places_.reserve(loaded_);
  for (const LoopKeyframe& keyframe : keyframes_) {
    places_.push_back(codebook_.Describe(keyframe.features));
  }
}

void LoopCloser::Add(LoopKeyframe keyframe) {
  places_.push_back(codebook_.Describe(keyframe.features));
  keyframes_.push_back(std::move(keyframe));
  Verify(FindCandidates());
}

void LoopCloser::SetUp(int segment, const Eigen::Vector3d& up_in_world) {
  up_in_world_[segment] = up_in_world;
}

std::vector<LoopCloser::Candidate> LoopCloser::FindCandidates() const {
  const LoopKeyframe& query = keyframes_.back();
  const Eigen::VectorXf& place = places_.back();
  double least = options_.min_similarity;
  if (keyframes_.size() > 1 && keyframes_[keyframes_.size() - 2].segment == query.segment) {
    least = std::max<double>(
        least, options_.min_similarity_share * place.dot(places_[places_.size() - 2]));
  }
  std::vector<Candidate> candidates;
  for (std::size_t i = 0; i + 1 < keyframes_.size(); ++i) {
    const double age_s = SecondsBetween(keyframes_[i].timestamp_ns, query.timestamp_ns);
    if (keyframes_[i].segment == query.segment && age_s < options_.min_age_s) {
      break;
    }
    const double similarity = place.dot(places_[i]);
    if (similarity >= least) {
      candidates.push_back({i, similarity});
    }
  }
  std::stable_sort(candidates.begin(), candidates.end(),
                   [](const auto& x, const auto& y) { return x.similarity > y.similarity; });
  candidates.resize(std::min(candidates.size(), static_cast<std::size_t>(options_.max_candidates)));
  // Where tracking was lost, or nearly so, the last place is the likeliest, whatever it looks like.
  const std::size_t last = keyframes_.size() - 2;
  if (keyframes_.size() > loaded_ + 1 &&
      (keyframes_[last].segment != query.segment || IsDoubtful(query.motion_covariance))) {
    std::erase_if(candidates, [&](const Candidate& other) { return other.keyframe == last; });
    candidates.insert(candidates.begin(), {last, place.dot(places_[last])});
  }
  return candidates;
}

void LoopCloser::Verify(const std::vector<Candidate>& candidates) {
  const LoopKeyframe& query = keyframes_.back();
  for (const Candidate& candidate : candidates) {
    const LoopKeyframe& old = keyframes_[candidate.keyframe];
    const LoopCheck check = VerifyLoop(rig_, query, old, *matcher_, options_.verification);
    attempts_.push_back({.query_ns = query.timestamp_ns,
                         .candidate_ns = old.timestamp_ns,
                         .is_of_loaded_map = candidate.keyframe < loaded_,
                         .similarity = candidate.similarity,
                         .matches = check.matches,
                         .inliers = check.inliers,
                         .reason = check.reason});
    if (check.measurement) {
      Trust({candidate.keyframe, keyframes_.size() - 1, *check.measurement, check.inliers},
            attempts_.size() - 1);
      if (attempts_.back().is_closed) {
        return;
      }
    }
  }
}

void LoopCloser::Trust(const Loop& loop, std::size_t attempt) {
  unsupported_.push_back(loop);
  unsupported_attempts_.push_back(attempt);
  // One that is trusted may be what another one waits for.
  for (std::size_t i = unsupported_.size(); i-- > 0;) {
    const Loop waiting = unsupported_[i];
    std::vector<Loop> others = loops_;
    for (std::size_t k = 0; k < unsupported_.size(); ++k) {
      if (k != i) {
        others.push_back(unsupported_[k]);
      }
    }
    const LoopTrust trust = Judge(waiting, others, keyframes_, options_.consistency);
    LoopAttempt& told = attempts_[unsupported_attempts_[i]];
    told.is_closed = trust == LoopTrust::kTrusted;
    told.reason = trust == LoopTrust::kTrusted       ? ""
                  : trust == LoopTrust::kUnsupported ? "no other loop agrees"
                                                     : "the path cannot be as wrong as that";
    if (trust == LoopTrust::kTrusted) {
      loops_.push_back(waiting);
    }
    if (trust != LoopTrust::kUnsupported) {
      unsupported_.erase(unsupported_.begin() + static_cast<std::ptrdiff_t>(i));
      unsupported_attempts_.erase(unsupported_attempts_.begin() + static_cast<std::ptrdiff_t>(i));
    }
  }
}

std::vector<PoseGraphNode> LoopCloser::Nodes() const {
  std::map<int, internal::LinkedSegment> segments = internal::LinkSegments(keyframes_, loops_);
  std::map<int, Eigen::Vector3d> up_in_world = up_in_world_;
  for (const LoopKeyframe& keyframe : keyframes_) {
    if (IsDoubtful(keyframe.motion_covariance)) {
      up_in_world.erase(keyframe.segment);
    }
  }
  std::vector<PoseGraphNode> nodes;
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
  return nodes;
}

std::vector<Rigid3> LoopCloser::Optimized() const {
  std::vector<PoseGraphNode> nodes = Nodes();
  if (!loops_.empty()) {
    OptimizePoseGraph(Edges(keyframes_, loops_, nodes), nodes);
  }
  std::vector<Rigid3> world_from_body;
  world_from_body.reserve(nodes.size());
  for (const PoseGraphNode& node : nodes) {
    world_from_body.push_back(node.world_from_body);
  }
  return world_from_body;
}

}  // namespace gluevo::vo
