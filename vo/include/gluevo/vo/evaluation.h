#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "gluevo/vo/trajectory.h"

namespace gluevo::vo {

struct EvaluationOptions {
  /// Poses closer in time than this belong together.
  double max_time_difference_s = 0.01;
  void Validate() const;
};

/// A similarity transform: target = scale * rotation * source + translation.
struct Similarity3 {
  double scale = 1.0;
  Rigid3 rigid;
};

/// Least-squares alignment of two equally long lists of points (Umeyama 1991, eq. 34 to 43), with
/// or without scale. Throws Error for fewer than 3 points or points all in one place.
Similarity3 AlignUmeyama(const std::vector<Eigen::Vector3d>& source,
                         const std::vector<Eigen::Vector3d>& target, bool with_scale);

/// How an estimate compares with ground truth, over the poses that associate by time.
struct Evaluation {
  std::size_t pairs = 0;
  /// Absolute trajectory error: RMSE of positions after SE(3) and after Sim(3) alignment, metres
  /// (Sturm et al. 2012).
  double ate_se3_m = 0.0;
  double ate_sim3_m = 0.0;
  /// Scale of the Sim(3) alignment, ground truth over estimate.
  double scale = 1.0;
  /// Relative pose error over sub-paths (Geiger et al. 2012): mean over all starts and lengths of
  /// the translation error in percent of the length and of the rotation error in degrees a metre.
  /// The lengths are KITTI's, 100 to 800 m in steps of 100, divided by 10 until the path holds
  /// at least five of them. NaN where the ground truth hardly moves.
  double rpe_translation_percent = 0.0;
  double rpe_rotation_deg_per_m = 0.0;
  std::vector<double> rpe_lengths_m;
  /// Share of the ground truth's time that lies between the first and the last associated pose and
  /// within gaps of at most 1 s (or thrice the median step) between them, 0 to 1.
  double coverage = 0.0;
};

/// Throws Error where fewer than 3 poses associate.
Evaluation Evaluate(const Trajectory& estimate, const Trajectory& groundtruth,
                    const EvaluationOptions& options);

}  // namespace gluevo::vo
