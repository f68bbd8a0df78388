#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "gluevo/vo/core/pose_covariance.h"
#include "gluevo/vo/core/rigid3.h"
#include "gluevo/vo/geometry/stereo_rig.h"

namespace gluevo::vo {

/// A point of the scene as its anchor view knows it: well across the ray, less well along it.
struct AnchoredPoint {
  Eigen::Vector3d center = Eigen::Vector3d::Zero();  ///< Of the anchor's camera; world, metres.
  Eigen::Vector3d ray = Eigen::Vector3d::UnitZ();    ///< World; its z in the anchor camera is 1.
  double inverse_depth = 1.0;                        ///< 1/m, along the ray; positive.
  double inverse_depth_sigma = 0.0;                  ///< 1/m, its standard deviation.

  Eigen::Vector3d InWorld() const { return center + ray / inverse_depth; }
};

/// A known point and where the rig whose pose is asked for sees it, on the normalised planes.
struct PnpObservation {
  AnchoredPoint point;
  Eigen::Vector2d left = Eigen::Vector2d::Zero();
  bool has_right = false;
  Eigen::Vector2d right = Eigen::Vector2d::Zero();
  /// How much it counts in the choice of the pose, above 0: samples of RANSAC are drawn, and
  /// hypotheses scored, in proportion. The refinement of the pose that was chosen knows no votes.
  double vote = 1.0;
};

struct PnpOptions {
  /// Standard deviation of a keypoint, pixels (of kReferenceFocalPx). An observation is an inlier
  /// within the 99 % quantile of the chi-square distribution that this and the point's own
  /// uncertainty imply.
  double noise_px = 1.5;
  /// Probability that a sample of inliers only was drawn before RANSAC stops.
  double confidence = 0.999;
  int min_iterations = 30;
  int max_iterations = 3000;
  /// No pose with fewer inliers than this.
  int min_inliers = 12;
  /// No pose that the inliers leave less certain than this (one standard deviation, in the worst
  /// direction): points on a line, or all far away and the rotation unknown.
  double max_position_sigma_m = 0.3;
  double max_rotation_sigma_rad = 0.015;

  /// Throws Error naming the option.
  void Validate() const;
};

enum class PnpVerdict : std::uint8_t {
  kOutlier,
  kInlierLeft,  ///< The left observation fits, the right one does not (or is absent).
  kInlier,      ///< All that was observed fits.
};

struct PnpResult {
  Rigid3 world_from_body;
  std::vector<PnpVerdict> verdicts;  ///< One an observation.
  int inliers = 0;                   ///< All that are not outliers.
  double vote_share = 0.0;           ///< Votes of the inliers over all votes.
  double position_sigma_m = 0.0;     ///< In the worst direction.
  double rotation_sigma_rad = 0.0;
  PoseCovariance covariance = PoseCovariance::Zero();  ///< Of world_from_body, from the inliers.
  /// Median over all observations, outliers too, of how far the left one is from where the pose
  /// puts it, the points' depths marginalised; pixels of kReferenceFocalPx.
  double median_error_px = 0.0;
};

/// Pose of a stereo rig from points whose depth is uncertain. Hypotheses are P3P solutions of the
/// left view (Gao et al. 2003; here Ke and Roumeliotis 2017 by OpenCV) and the given `guesses`;
/// each is scored over both views with the points' depths marginalised, the best so far improved
/// over its inliers (LO-RANSAC, Chum et al. 2003), the last refined by robust Gauss-Newton.
/// The same input gives the same result. Nothing where no pose passes the options' checks.
std::optional<PnpResult> SolvePnp(const StereoRig& rig,
                                  std::span<const PnpObservation> observations,
                                  std::span<const Rigid3> guesses, const PnpOptions& options);

}  // namespace gluevo::vo
