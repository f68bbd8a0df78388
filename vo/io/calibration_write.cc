// Rigs as Kalibr and EuRoC write them.

#include <iomanip>
#include <limits>
#include <sstream>

#include "gluevo/nn/error.h"
#include "gluevo/vo/io/calibration.h"

namespace gluevo::vo {
namespace {

/// A camera in Kalibr's words: projection and lens are apart.
struct KalibrWords {
  const char* projection;
  const char* lens;
  std::size_t projection_parameters;  // of the coefficients, before the lens's
  std::size_t lens_coefficients;
};

KalibrWords KalibrWordsOf(const Camera& camera, const char* radial_tangential) {
  switch (camera.distortion) {
    case Distortion::kNone:
      return {"pinhole", "none", 0, 0};
    case Distortion::kRadialTangential:
      return {"pinhole", radial_tangential, 0,
              static_cast<std::size_t>(camera.coefficients[4] != 0.0 ? 5 : 4)};
    case Distortion::kEquidistant:
      return {"pinhole", "equidistant", 0, 4};
    case Distortion::kRational:
      return {"pinhole", radial_tangential, 0, 8};
    case Distortion::kMei:
      return {"omni", "radtan", 1, 4};
    case Distortion::kDoubleSphere:
      return {"ds", "none", 2, 0};
    case Distortion::kExtendedUnified:
      return {"eucm", "none", 2, 0};
    case Distortion::kFieldOfView:
      return {"pinhole", "fov", 0, 1};
  }
  throw Error("a camera with a lens that has no name");
}

void WriteCamera(std::ostream& out, const Camera& camera, const KalibrWords& words,
                 const std::string& indent, const char* coefficients_key) {
  const DistortionCoefficients& k = camera.coefficients;
  out << indent << "camera_model: " << words.projection << '\n' << indent << "intrinsics: [";
  for (std::size_t i = 0; i < words.projection_parameters; ++i) {
    out << k[i] << ", ";
  }
  out << camera.fx << ", " << camera.fy << ", " << camera.cx << ", " << camera.cy << "]\n"
      << indent << "distortion_model: " << words.lens << '\n'
      << indent << coefficients_key << ": [";
  for (std::size_t i = 0; i < words.lens_coefficients; ++i) {
    out << (i > 0 ? ", " : "") << k[words.projection_parameters + i];
  }
  out << "]\n" << indent << "resolution: [" << camera.width << ", " << camera.height << "]\n";
}

void WriteRows(std::ostream& out, const Rigid3& pose, const std::string& indent) {
  const Eigen::Matrix<double, 3, 4> matrix = pose.Matrix();
  for (Eigen::Index row = 0; row < 3; ++row) {
    out << indent << "- [" << matrix(row, 0) << ", " << matrix(row, 1) << ", " << matrix(row, 2)
        << ", " << matrix(row, 3) << "]\n";
  }
  out << indent << "- [0.0, 0.0, 0.0, 1.0]\n";
}

}  // namespace

std::string KalibrText(const StereoRig& rig) {
  std::ostringstream out;
  out << std::setprecision(std::numeric_limits<double>::max_digits10);
  const bool has_imu = rig.body_frame != "left camera";
  for (std::size_t side = 0; side < 2; ++side) {
    const Camera& camera = rig.cameras[side];
    const KalibrWords words = KalibrWordsOf(camera, "radtan");
    constexpr std::size_t kMost = 4;
    if (words.lens_coefficients > kMost) {
      throw Error("Kalibr's radtan has four coefficients, this lens " +
                  std::to_string(words.lens_coefficients) +
                  ": write EuRoC's sensor.yaml, whose reader here takes 4, 5 and 8");
    }
    out << "cam" << side << ":\n";
    WriteCamera(out, camera, words, "  ", "distortion_coeffs");
    if (has_imu) {
      out << "  T_cam_imu:\n";
      WriteRows(out, rig.body_from_cam[side].Inverse(), "  ");
    }
    if (side == 1) {
      out << "  T_cn_cnm1:\n";
      WriteRows(out, rig.right_from_left(), "  ");
    }
    out << "  cam_overlaps: [" << 1 - side << "]\n";
  }
  return out.str();
}

std::string SensorYamlText(const StereoRig& rig, std::size_t side) {
  std::ostringstream out;
  out << std::setprecision(std::numeric_limits<double>::max_digits10);
  const Eigen::Matrix<double, 3, 4> matrix = rig.body_from_cam[side].Matrix();
  out << "sensor_type: camera\ncomment: cam" << side << "\nT_BS:\n  cols: 4\n  rows: 4\n  data: [";
  for (Eigen::Index row = 0; row < 3; ++row) {
    for (Eigen::Index column = 0; column < 4; ++column) {
      out << matrix(row, column) << ", ";
    }
  }
  out << "0.0, 0.0, 0.0, 1.0]\n";
  WriteCamera(out, rig.cameras[side], KalibrWordsOf(rig.cameras[side], "radial-tangential"), "",
              "distortion_coefficients");
  return out.str();
}

bool IsRectified(const StereoRig& rig) {
  const Camera& left = rig.cameras[0];
  const Camera& right = rig.cameras[1];
  const auto is_straight = [](const Camera& camera) {
    const bool all_zero = camera.coefficients == DistortionCoefficients();
    return camera.distortion == Distortion::kNone ||
           ((camera.distortion == Distortion::kRadialTangential ||
             camera.distortion == Distortion::kRational) &&
            all_zero);
  };
  constexpr double kSame = 1e-3;      // pixels
  constexpr double kParallel = 1e-6;  // radians, and of the baseline
  const Rigid3 right_from_left = rig.right_from_left();
  return is_straight(left) && is_straight(right) && std::abs(left.fx - right.fx) < kSame &&
         std::abs(left.fy - right.fy) < kSame && std::abs(left.cy - right.cy) < kSame &&
         right_from_left.rotation.angularDistance(Eigen::Quaterniond::Identity()) < kParallel &&
         right_from_left.translation.tail<2>().norm() < kParallel * rig.baseline();
}

}  // namespace gluevo::vo
