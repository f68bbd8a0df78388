#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "gluevo/vo/frontend/matcher.h"
#include "gluevo/vo/geometry/stereo_rig.h"
#include "gluevo/vo/mapping/loop_consistency.h"
#include "gluevo/vo/mapping/loop_keyframe.h"
#include "gluevo/vo/mapping/loop_verification.h"
#include "gluevo/vo/mapping/place_codebook.h"
#include "gluevo/vo/mapping/place_index.h"
#include "gluevo/vo/mapping/pose_graph.h"

namespace gluevo::vo {

struct LoopOptions {
  /// A key frame is kept at most this often, seconds.
  double interval_s = 0.5;
  /// Key frames of the same segment that are younger than this are no places to come back to:
  /// odometry knows better, seconds.
  double min_age_s = 10.0;
  /// A candidate is at least so like the query, as the cosine of their place descriptors, and ...
  double min_similarity = 0.1;
  /// ... at least this share of what the query's neighbour in time is.
  double min_similarity_share = 0.4;
  /// So many, the most similar first, are compared by nearest neighbours, until one is believed.
  int max_compared = 10;
  /// Of the others so many are verified by the network, those with most neighbours first; where
  /// tracking was lost, the key frame before that, too.
  int max_candidates = 3;
  LoopVerificationOptions verification;
  LoopConsistencyOptions consistency;

  /// Throws Error naming the option.
  void Validate() const;
};

/// A pair of key frames that was taken for the same place, and what became of it.
struct LoopAttempt {
  int64_t query_ns = 0;
  int64_t candidate_ns = 0;
  bool is_of_loaded_map = false;  ///< The candidate.
  double similarity = 0.0;
  int matches = 0;
  int inliers = 0;
  bool is_closed = false;
  /// Time of the key frame that was added when it was believed: the query's, or a later one's that
  /// agreed.
  int64_t closed_ns = 0;
  std::string reason;  ///< Why it is not.
};

/// Finds the places that a run comes back to, and the poses that fit them. Everything by counts and
/// nothing by time: the same key frames give the same loops.
class LoopCloser {
 public:
  /// Throws Error for options out of their range.
  LoopCloser(const StereoRig& rig, PlaceCodebook codebook, std::shared_ptr<Matcher> matcher,
             const LoopOptions& options);

  /// Starts with what earlier runs have kept, before any Add: the key frames that are added have
  /// other segments. Throws as Add does.
  void Load(std::vector<LoopKeyframe> keyframes, std::vector<Loop> loops);

  /// The next key frame, in order of time. Throws Error for features that the codebook does not
  /// know.
  void Add(LoopKeyframe keyframe);

  /// What odometry has in the meantime for the motion to a key frame since the one before it in the
  /// same segment.
  void Revise(std::size_t keyframe, const Rigid3& motion) { keyframes_[keyframe].motion = motion; }

  /// Where a segment's world has its up, once an inertial unit tells: a unit vector. What is said
  /// last counts, for all of the segment.
  void SetUp(int segment, const Eigen::Vector3d& up_in_world);

  const StereoRig& rig() const { return rig_; }
  const std::vector<LoopKeyframe>& keyframes() const { return keyframes_; }
  /// Those that the codebook proposed, in the order in which they were tried.
  const std::vector<LoopAttempt>& attempts() const { return attempts_; }
  /// Loops that are believed.
  const std::vector<Loop>& loops() const { return loops_; }

  /// One node a key frame, where odometry and the loops between segments have it: the world is that
  /// of the oldest segment that loops link with the key frame's, whose first pose is fixed. Where
  /// up is known there and in the key frame's own segment, and none of that one's motions is
  /// doubtful, its tilt stays.
  PoseGraph Graph() const;
  /// Of each key frame the pose that fits odometry and loops: world_from_body of the graph, solved.
  std::vector<Rigid3> Optimized() const;

 private:
  /// How many key frames, the oldest, the newest one may come back to.
  std::size_t CountOldEnough() const;
  std::vector<PlaceIndex::Similar> FindCandidates() const;
  /// The key frame before the newest one where tracking was lost, or nearly so, between the two:
  /// that is then the likeliest place, whatever it looks like.
  std::optional<std::size_t> LastBeforeLoss() const;
  void Verify(const std::vector<PlaceIndex::Similar>& candidates);
  /// Keeps what became of it. Returns whether it is believed.
  bool Note(const PlaceIndex::Similar& candidate, const LoopCheck& check);
  void Trust(const Loop& loop, std::size_t attempt);

  StereoRig rig_;
  PlaceCodebook codebook_;
  std::shared_ptr<Matcher> matcher_;
  LoopOptions options_;
  std::vector<LoopKeyframe> keyframes_;
  std::size_t loaded_ = 0;                      // Of them.
  PlaceIndex places_;                           // One a key frame.
  std::map<int, Eigen::Vector3d> up_in_world_;  // Of segments.
  std::vector<LoopAttempt> attempts_;
  std::vector<Loop> loops_;
  // Verified, but not trusted (yet), and their attempts.
  std::vector<Loop> unsupported_;
  std::vector<std::size_t> unsupported_attempts_;
};

}  // namespace gluevo::vo
