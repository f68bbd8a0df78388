#pragma once

#include <string>

#include "gluevo/vo/geometry/triangulation.h"

namespace gluevo::vo {

struct SlidingWindowOptions {
  /// Frames in the window, the newest included.
  int size = 11;
  /// Standard deviation of a keypoint, pixels (of kReferenceFocalPx): half a pixel, as optical flow
  /// and refined matches have it. VINS-Fusion takes 1.5 px; with that the robust loss takes errors
  /// of a pixel for noise, and drift is larger. (PnP, which judges matches that may be worse, has
  /// its own.)
  double noise_px = 0.5;
  /// Huber threshold of the reprojection residuals, in standard deviations.
  double huber = 1.0;
  /// Limit of the solver. By count and never by time, so that results repeat.
  int max_iterations = 8;
  /// An iteration that lowers the cost by less than this share of it is the last.
  double least_decrease = 1e-3;
  /// What solves: "gluevo", or "ceres" for comparison, which is several times slower.
  std::string solver = "gluevo";
  /// Landmarks with a larger mean reprojection error (both cameras, pixels of kReferenceFocalPx)
  /// are dropped.
  double max_mean_error_px = 3.0;
  /// A frame is a key frame when its tracks have moved this much, on average, since the last key
  /// frame, the rig's turn left out (pixels of kReferenceFocalPx) ...
  double keyframe_parallax_px = 7.0;
  /// ... or of the tracks that it follows the last key frame sees less than this share: a rig that
  /// turns on the spot sees something else without any parallax ...
  double min_keyframe_overlap = 0.7;
  /// ... or fewer tracks than this were followed ...
  int min_tracked = 20;
  /// ... or fewer than this were followed that have at least `long_track` observations ...
  int min_long_tracked = 40;
  int long_track = 4;
  /// ... or there are more new tracks than this times those that were followed.
  double max_new_share = 0.5;
  /// How well the calibration knows how the right camera sees (StereoCorrection): standard
  /// deviation on each axis, milliradians. Within it that is refined with each bundle adjustment; 0
  /// keeps it fixed. A third of a pixel, as KITTI's is off, makes distances wrong by a percent.
  double right_turn_sigma_mrad = 0.5;
  /// Whether a dropped key frame leaves what it knew of the others' poses as a prior.
  bool marginalize = true;
  TriangulationOptions triangulation;

  /// Throws Error naming the option.
  void Validate() const;
};

}  // namespace gluevo::vo
