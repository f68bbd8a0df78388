#pragma once

#include <Eigen/Core>
#include <array>
#include <string>

namespace gluevo::vo {

enum class Distortion {
  kNone,
  kRadialTangential,  ///< Brown-Conrady: k1 k2 p1 p2 k3 (OpenCV's order; EuRoC gives the first 4).
  kEquidistant,       ///< Kannala-Brandt: k1 k2 k3 k4 (OpenCV's fisheye, Kalibr's "equidistant").
};

/// A pinhole camera with distortion. Pixels: x right, y down, the centre of the top-left pixel at
/// (0, 0). Camera frame: x right, y down, z forward.
struct Camera {
  int width = 0;                                  // pixels
  int height = 0;                                 // pixels
  double fx = 0.0, fy = 0.0, cx = 0.0, cy = 0.0;  // pixels
  Distortion distortion = Distortion::kNone;
  std::array<double, 5> coefficients = {};

  /// Throws Error naming `what` for a size or a focal length that is not positive or values that
  /// are not finite.
  void Validate(const std::string& what) const;

  /// Pixel of a point of the camera frame, metres; the point's z must be positive.
  Eigen::Vector2d Project(const Eigen::Vector3d& point_in_cam) const;
  /// Pixel of a point of the normalised plane z = 1. Both models hold only around the centre: far
  /// out, where the polynomial turns, points come back into the image. Undistort never returns
  /// such a point, so Undistort(Distort(p)) tells whether p is within.
  Eigen::Vector2d Distort(const Eigen::Vector2d& normalized) const;
  /// Derivative of Distort by the point of the normalised plane, pixels.
  Eigen::Matrix2d DistortJacobian(const Eigen::Vector2d& normalized) const;
  /// Point of the normalised plane z = 1 seen at a pixel, to 1e-9 of a pixel: Newton's iteration
  /// on the distortion, begun at the pixel itself. The only point it returns is the one on the
  /// branch of the model that begins at the centre. NaN in both coordinates where there is none:
  /// at pixels beyond the range of a radial-tangential model, and at those of an equidistant
  /// camera that look 90 degrees or more to the side (the corners of a TUM-VI image), so check
  /// allFinite().
  Eigen::Vector2d Undistort(const Eigen::Vector2d& pixel) const;
};

}  // namespace gluevo::vo
