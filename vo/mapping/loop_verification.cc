#include "gluevo/vo/mapping/loop_verification.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <utility>
#include <vector>

#include "gluevo/nn/nearest_neighbor.h"
#include "gluevo/vo/core/options_check.h"
#include "gluevo/vo/geometry/pose_uncertainty.h"
#include "keyframe_views.h"
#include "two_view_refinement.h"

namespace gluevo::vo {
namespace {

// A keypoint of a key frame and the one of another that shows the same.
struct Pair {
  int known = 0;
  int seen = 0;
};

struct Located {
  Rigid3 known_from_seen;
  PoseCovariance covariance;
  int inliers = 0;
  std::vector<Pair> fitting;  // The inliers.
};

// Where the key frame `seen` is, by the points of `known`.
std::optional<Located> Locate(const StereoRig& rig, const LoopKeyframe& known,
                              const LoopKeyframe& seen, const std::vector<Pair>& pairs,
                              const LoopVerificationOptions& options, std::string& reason) {
  const double baseline = rig.baseline();
  std::vector<PnpObservation> observations;
  std::vector<Pair> used;
  for (const Pair& pair : pairs) {
    const StereoKeypoint& point = known.keypoints[pair.known];
    const StereoKeypoint& view = seen.keypoints[pair.seen];
    if (point.inverse_depth <= 0.0 || !view.left.allFinite()) {
      continue;
    }
    observations.push_back(
        {.point = internal::PointOf(point, rig.body_from_cam[0], options.pnp.noise_px, baseline),
         .left = view.left,
         .has_right = view.has_right,
         .right = view.right});
    used.push_back(pair);
  }
  const std::optional<PnpResult> pose = SolvePnp(rig, observations, {}, options.pnp);
  if (!pose) {
    reason = "no pose fits";
    return std::nullopt;
  }
  if (pose->inliers < options.min_inliers || pose->vote_share < options.min_inlier_share) {
    reason = std::to_string(pose->inliers) + " of " + std::to_string(observations.size()) +
             " points fit";
    return std::nullopt;
  }
  Located located{pose->world_from_body, pose->covariance, pose->inliers, {}};
  for (std::size_t i = 0; i < used.size(); ++i) {
    if (pose->verdicts[i] != PnpVerdict::kOutlier) {
      located.fitting.push_back(used[i]);
    }
  }
  return located;
}

// Squared, in standard deviations of both.
double Disagreement(const Located& forth, const Located& back) {
  const Eigen::Matrix<double, 6, 1> error =
      ErrorOfPose(forth.known_from_seen, back.known_from_seen.Inverse());
  const Eigen::Matrix<double, 6, 6> through = ErrorThrough(back.known_from_seen.Inverse());
  const PoseCovariance both = forth.covariance + through * back.covariance * through.transpose();
  return error.dot(both.ldlt().solve(error));
}

// By all cameras' views of the inliers.
LoopMeasurement Refined(const StereoRig& rig, const LoopKeyframe& query,
                        const LoopKeyframe& candidate, const Located& located,
                        const LoopVerificationOptions& options) {
  std::vector<internal::TwoViewPoint> points;
  points.reserve(located.fitting.size());
  for (const Pair& pair : located.fitting) {
    points.push_back({candidate.keypoints[pair.known], query.keypoints[pair.seen]});
  }
  return internal::RefineMotion(rig, points, located.known_from_seen, options.pnp.noise_px)
      .value_or(LoopMeasurement{located.known_from_seen, located.covariance});
}

// Whether the two see the same, by matches from the candidate's keypoints to the query's.
LoopCheck CheckMatches(const StereoRig& rig, const LoopKeyframe& query,
                       const LoopKeyframe& candidate, const nn::Matches& matches,
                       const LoopVerificationOptions& options) {
  LoopCheck check;
  std::vector<Pair> forth;
  std::vector<Pair> back;
  for (std::size_t i = 0; i < matches.matches0.size(); ++i) {
    if (matches.matches0[i] >= 0) {
      forth.push_back({static_cast<int>(i), matches.matches0[i]});
      back.push_back({matches.matches0[i], static_cast<int>(i)});
    }
  }
  check.matches = static_cast<int>(forth.size());
  if (check.matches < options.min_matches) {
    check.reason = std::to_string(check.matches) + " matches";
    return check;
  }
  const auto by_candidate = Locate(rig, candidate, query, forth, options, check.reason);
  if (!by_candidate) {
    return check;
  }
  check.inliers = by_candidate->inliers;
  std::vector<int> seen;
  seen.reserve(by_candidate->fitting.size());
  for (const Pair& pair : by_candidate->fitting) {
    seen.push_back(pair.seen);
  }
  if (const int fields = internal::CountFields(query.features, seen); fields < options.min_fields) {
    check.reason = "all points in " + std::to_string(fields) + " of 16 fields of the image";
    return check;
  }
  const auto by_query = Locate(rig, query, candidate, back, options, check.reason);
  if (!by_query) {
    check.reason += " the other way round";
    return check;
  }
  if (Disagreement(*by_candidate, *by_query) > options.max_disagreement) {
    check.reason = "the two ways disagree";
    return check;
  }
  check.measurement = Refined(rig, query, candidate, *by_candidate, options);
  return check;
}

}  // namespace

void LoopVerificationOptions::Validate() const {
  CheckWithin(match_threshold, 0.0, 1.0, "loops.match_threshold");
  CheckWithin(nearest_ratio, 1e-3, 1.0, "loops.nearest_ratio");
  CheckAtLeast(min_nearest, 0, "loops.min_nearest");
  CheckAtLeast(enough_nearest, 4, "loops.enough_nearest");
  CheckAtLeast(min_matches, 4, "loops.min_matches");
  CheckAtLeast(min_inliers, 4, "loops.min_inliers");
  CheckWithin(min_inlier_share, 0.0, 1.0, "loops.min_inlier_share");
  CheckAtLeast(min_fields, 1, "loops.min_fields");
  CheckPositive(max_disagreement, "loops.max_disagreement");
  pnp.Validate();
}

LoopCheck VerifyLoopByNearest(const StereoRig& rig, const LoopKeyframe& query,
                              const LoopKeyframe& candidate,
                              const LoopVerificationOptions& options) {
  LoopVerificationOptions strict = options;
  strict.min_matches = std::max(options.min_matches, options.enough_nearest);
  strict.min_inliers = std::max(options.min_inliers, options.enough_nearest);
  const nn::NearestNeighborOptions nearest = {.max_ratio = options.nearest_ratio};
  return CheckMatches(rig, query, candidate,
                      nn::MatchNearestNeighbors(candidate.features, query.features, nearest),
                      strict);
}

LoopCheck VerifyLoop(const StereoRig& rig, const LoopKeyframe& query, const LoopKeyframe& candidate,
                     Matcher& matcher, const LoopVerificationOptions& options) {
  return CheckMatches(rig, query, candidate,
                      matcher.Match(candidate.features, query.features, options.match_threshold),
                      options);
}

}  // namespace gluevo::vo
