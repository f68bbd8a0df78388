#pragma once

#include <optional>
#include <string>

#include "gluevo/vo/core/pose_covariance.h"
#include "gluevo/vo/core/rigid3.h"
#include "gluevo/vo/frontend/matcher.h"
#include "gluevo/vo/geometry/pnp.h"
#include "gluevo/vo/geometry/stereo_rig.h"
#include "gluevo/vo/mapping/loop_keyframe.h"

namespace gluevo::vo {

struct LoopVerificationOptions {
  float match_threshold = 0.2F;  ///< Confidence of a match, 0 to 1.
  /// Nearest neighbours by descriptor are compared first, of which the next is so much farther away
  /// (Lowe's ratio, 2004): a twentieth of the network's cost.
  float nearest_ratio = 0.9F;
  /// Where they are fewer the two do not show the same, and the network is not asked ...
  int min_nearest = 15;
  /// ... nor where so many of them fit a pose: from nearly the same place they see enough.
  int enough_nearest = 60;
  int min_matches = 30;
  int min_inliers = 25;
  /// Of the matched points that have a depth, 0 to 1.
  double min_inlier_share = 0.3;
  /// Of the sixteen fields of the image (4 x 4) so many must hold an inlier.
  int min_fields = 5;
  /// The pose found from the candidate's points and that found from the query's agree within this
  /// quantile of the chi-square distribution with six degrees of freedom (22.5: 99.9 %).
  double max_disagreement = 22.5;
  /// Keypoints lie on whole pixels here, and places are seen from farther apart than in tracking.
  PnpOptions pnp = {.noise_px = 2.5};

  /// Throws Error naming the option.
  void Validate() const;
};

/// How two key frames that see the same place stand to each other.
struct LoopMeasurement {
  Rigid3 candidate_from_query;  ///< Bodies.
  PoseCovariance covariance = PoseCovariance::Zero();
};

/// What became of a candidate.
struct LoopCheck {
  std::optional<LoopMeasurement> measurement;  ///< Of an accepted one.
  std::string reason;                          ///< Why a rejected one was.
  int matches = 0;
  int inliers = 0;
};

/// As VerifyLoop, but matched by descriptor alone: finds what is seen from nearly the same place.
LoopCheck VerifyLoopByNearest(const StereoRig& rig, const LoopKeyframe& query,
                              const LoopKeyframe& candidate,
                              const LoopVerificationOptions& options);

/// Whether the two see the same place: matched by the network, located by the candidate's points,
/// and the candidate by the query's with the same result.
LoopCheck VerifyLoop(const StereoRig& rig, const LoopKeyframe& query, const LoopKeyframe& candidate,
                     Matcher& matcher, const LoopVerificationOptions& options);

}  // namespace gluevo::vo
