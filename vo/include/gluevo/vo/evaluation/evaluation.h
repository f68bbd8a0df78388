#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "gluevo/vo/core/trajectory.h"

namespace gluevo::vo {

struct EvaluationOptions {
  /// Poses at most this far apart in time belong together, seconds.
  double max_time_difference_s = 0.01;
  /// The motion from one associated pose to the next is correct within these.
  double correct_motion_m = 0.1;
  double correct_motion_deg = 2.0;
  /// The relative pose error over frames: from each rpe_frames-th associated pose to the next one,
  /// or, with rpe_every_frame, from every pose to the one so many later.
  int rpe_frames = 1;
  bool rpe_every_frame = false;
  /// Lengths of the sub-paths of the relative pose error, metres; none: KITTI's, divided by 10
  /// until the path holds five of them.
  std::vector<double> rpe_lengths_m;
  /// Throws Error that names the field.
  void Validate() const;
};

/// A similarity transform: target = scale * rotation * source + translation.
struct Similarity3 {
  double scale = 1.0;
  Rigid3 rigid;
};

/// Least-squares alignment of two equally long lists of points (Umeyama 1991, eq. 34 to 43), with
/// or without scale. Throws Error for lists of different lengths, fewer than 3 points, or points
/// (of either list) all in one place.
Similarity3 AlignUmeyama(const std::vector<Eigen::Vector3d>& source,
                         const std::vector<Eigen::Vector3d>& target, bool with_scale);

/// One pose of the estimate that has a partner in the ground truth, and what is wrong with it.
struct PoseError {
  int64_t timestamp_ns = 0;  ///< The estimate's.
  /// Positions in the ground truth's world, metres: the truth, and the estimate after SE(3) and
  /// after Sim(3) alignment of the whole trajectory.
  Eigen::Vector3d groundtruth = Eigen::Vector3d::Zero();
  Eigen::Vector3d se3 = Eigen::Vector3d::Zero();
  Eigen::Vector3d sim3 = Eigen::Vector3d::Zero();
  double se3_m = 0.0;  ///< Distance of the aligned estimate from the truth.
  double sim3_m = 0.0;
  /// Error of the motion since the associated pose before, which no alignment touches: 0 for the
  /// first.
  double motion_m = 0.0;
  double motion_deg = 0.0;
};

/// How an estimate compares with ground truth, over the poses that associate by time: each pose of
/// the shorter trajectory with the nearest in time of the longer one (the earlier of two equally
/// near), as the public tool evo does. Poses must be of the same body frame; the world frames may
/// differ.
struct Evaluation {
  std::size_t pairs = 0;
  std::size_t estimate_poses = 0;  ///< All of the estimate.
  std::size_t groundtruth_poses = 0;
  /// Absolute trajectory error: RMSE of positions after SE(3) and after Sim(3) alignment, metres
  /// (Sturm et al. 2012). Where the estimate or the ground truth does not move at all, only the
  /// means are aligned.
  double ate_se3_m = 0.0;
  double ate_sim3_m = 0.0;
  /// Scale of the Sim(3) alignment, ground truth over estimate; NaN where either does not move.
  double scale = 1.0;
  /// The SE(3) alignment: the estimate's world to the ground truth's.
  Rigid3 groundtruth_world_from_estimate_world;
  /// The Sim(3) alignment, the same way round.
  Similarity3 groundtruth_world_from_estimate_world_sim3;
  std::vector<PoseError> errors;  ///< One an associated pair, in order of time.
  /// Relative pose error over sub-paths (Geiger et al. 2012): mean over all starts and lengths of
  /// the translation error in percent of the length and of the rotation error in degrees a metre.
  /// Every associated pose is a start (KITTI's own tool takes every tenth, too few for a short
  /// run); a sub-path ends at the first pose beyond its length along the ground truth.
  /// The lengths are the options', or KITTI's, 100 to 800 m in steps of 100, divided by 10 until
  /// the path holds at least five of them, at most three times. NaN where the path holds none.
  double rpe_translation_percent = 0.0;
  double rpe_rotation_deg_per_m = 0.0;
  std::vector<double> rpe_lengths_m;  ///< The lengths that have at least one sub-path.
  double path_m = 0.0;                ///< Along the ground truth, from associated pose to pose.
  double shortest_path_m = 0.0;       ///< A path has to be longer to hold a sub-path.
  /// Relative pose error over the options' number of frames (Sturm et al. 2012): RMSE of the
  /// motions' translation, metres, and rotation, degrees, and the median of the translation, which
  /// a few wrong motions do not touch; NaN where there are fewer frames.
  double rpe_frames_translation_m = 0.0;
  double rpe_frames_translation_median_m = 0.0;
  double rpe_frames_rotation_deg = 0.0;
  /// Motions from one associated pose to the next that are correct within the options' bounds, of
  /// pairs - 1: what is left of it where frames are far apart and tracking breaks.
  std::size_t correct_motions = 0;
  /// Share of the ground truth's time that lies between the first and the last associated pose and
  /// within gaps of at most 1 s (or thrice the median step of the shorter trajectory) between
  /// them, 0 to 1.
  double coverage = 0.0;
};

/// Throws Error where fewer than 3 poses associate. Both trajectories must be in order of time.
Evaluation Evaluate(const Trajectory& estimate, const Trajectory& groundtruth,
                    const EvaluationOptions& options);

/// A sentence where fewer than half of the estimate's poses associate, or, where it is the shorter
/// one, of the ground truth's: the options are those of the evaluation.
std::optional<std::string> AssociationWarning(const Evaluation& evaluation,
                                              const EvaluationOptions& options);

/// A sentence where the scale is above 10 or below 0.1: one of both is hardly in metres.
std::optional<std::string> ScaleWarning(const Evaluation& evaluation);

}  // namespace gluevo::vo
