#pragma once

#include <Eigen/Core>
#include <array>
#include <string>
#include <string_view>
#include <vector>

namespace gluevo::vo {

/// How a lens bends the normalised plane z = 1, and its coefficients in their order. New models
/// come last: their numbers are written to files.
enum class Distortion {
  kNone,
  kRadialTangential,  ///< Brown-Conrady: k1 k2 p1 p2 k3 (OpenCV's order; EuRoC gives the first 4).
  kEquidistant,       ///< Kannala-Brandt: k1 k2 k3 k4 (OpenCV's fisheye, Kalibr's "equidistant").
  kRational,          ///< OpenCV's eight: k1 k2 p1 p2 k3 k4 k5 k6 (ROS's rational_polynomial).
  /// Mei and Rives 2007 (Kalibr's "omni", OpenCV's omnidir): xi, then k1 k2 p1 p2 of the
  /// radial-tangential distortion.
  kMei,
  kDoubleSphere,     ///< Usenko et al. 2018: xi alpha.
  kExtendedUnified,  ///< Khomutenko et al. 2016, "EUCM": alpha beta.
  kFieldOfView,      ///< Devernay and Faugeras 2001: w, radians.
};

using DistortionCoefficients = std::array<double, 8>;

/// As in messages and tables: "radial-tangential", "double sphere".
std::string_view NameOf(Distortion distortion);
/// The names of the coefficients that a model has, in their order.
std::vector<std::string_view> CoefficientNames(Distortion distortion);

/// A camera with a lens. Pixels: x right, y down, the centre of the top-left pixel at (0, 0).
/// Camera frame: x right, y down, z forward.
struct Camera {
  int width = 0;   // pixels
  int height = 0;  // pixels
  /// Pixels. Of the models that bend at the centre, too (kMei, kDoubleSphere, kExtendedUnified),
  /// they are the published parameters, and CentralFocal() is what a pinhole camera's would be.
  double fx = 0.0, fy = 0.0, cx = 0.0, cy = 0.0;
  Distortion distortion = Distortion::kNone;
  DistortionCoefficients coefficients = {};

  /// Throws Error naming `what` for a size or a focal length that is not positive, values that are
  /// not finite and coefficients that the model does not have (alpha outside of 0 to 1).
  void Validate(const std::string& what) const;

  /// Pixel of a point of the camera frame, metres; the point's z must be positive.
  Eigen::Vector2d Project(const Eigen::Vector3d& point_in_cam) const;
  /// Pixel of a point of the normalised plane z = 1. The polynomial models hold only around the
  /// centre: far out, where the polynomial turns, points come back into the image. Undistort never
  /// returns such a point, so Undistort(Distort(p)) tells whether p is within.
  Eigen::Vector2d Distort(const Eigen::Vector2d& normalized) const;
  /// Derivative of Distort by the point of the normalised plane, pixels.
  Eigen::Matrix2d DistortJacobian(const Eigen::Vector2d& normalized) const;
  /// Point of the normalised plane z = 1 seen at a pixel, to 1e-9 of a pixel where the model has a
  /// radius of one or so. The only point it returns is the one on the branch of the model that
  /// begins at the centre. NaN in both coordinates where there is none: at pixels beyond the range
  /// of the model, and at those that look 90 degrees or more to the side (the corners of a TUM-VI
  /// image), so check allFinite().
  Eigen::Vector2d Undistort(const Eigen::Vector2d& pixel) const;
  /// Pixels on the image for one unit of the normalised plane at its centre, along x and y.
  Eigen::Vector2d CentralFocal() const;
};

}  // namespace gluevo::vo
