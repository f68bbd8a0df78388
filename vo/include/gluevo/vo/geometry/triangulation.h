#pragma once

#include <Eigen/Core>
#include <optional>
#include <span>

#include "gluevo/vo/core/rigid3.h"

namespace gluevo::vo {

struct TriangulationOptions {
  /// Depth in every view, metres.
  double min_depth_m = 0.1;
  double max_depth_m = 1000.0;
  /// The widest angle between two rays to the point must be at least this, pixels (of
  /// kReferenceFocalPx). Below it the depth is noise: at one pixel, 0.12 degrees, disparity and its
  /// error are equal.
  double min_parallax_px = 1.0;
  /// Reprojection error in every view, pixels (of kReferenceFocalPx).
  double max_error_px = 3.0;

  /// Throws Error naming the option.
  void Validate() const;
};

/// One view of a point.
struct PosedObservation {
  Rigid3 cam_from_world;
  Eigen::Vector2d normalized = Eigen::Vector2d::Zero();  // on the plane z = 1
};

/// The point (world, metres) that the views see: linear least squares (DLT; Hartley and Zisserman,
/// section 12.2), then Gauss-Newton on the reprojection error. Nothing where there are fewer than
/// two views or a check of the options fails.
std::optional<Eigen::Vector3d> Triangulate(std::span<const PosedObservation> views,
                                           const TriangulationOptions& options);

}  // namespace gluevo::vo
