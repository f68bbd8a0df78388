#include <Eigen/Geometry>

#include "gluevo/nn/error.h"
#include "gluevo/vo/simulation/simulation.h"

namespace gluevo::simulation {
namespace {

constexpr int kEurocWidth = 752;
constexpr int kEurocHeight = 480;

/// The upper rows of EuRoC's T_BS (body from camera).
vo::Rigid3 FromRows(const Eigen::Matrix<double, 3, 4>& rows) {
  // The published digits are not orthonormal to the last: the quaternion makes them so.
  return {Eigen::Quaterniond(Eigen::Matrix3d(rows.leftCols<3>())).normalized(), rows.col(3)};
}

vo::Camera Scaled(const vo::Camera& euroc, int width, int height) {
  const double scale = static_cast<double>(width) / kEurocWidth;
  vo::Camera camera = euroc;
  camera.width = width;
  camera.height = height;
  camera.fx *= scale;
  camera.fy *= scale;
  // Pixel centres are whole numbers, so the image's centre is at (size - 1) / 2.
  camera.cx = (euroc.cx - 0.5 * (kEurocWidth - 1)) * scale + 0.5 * (width - 1);
  camera.cy = (euroc.cy - 0.5 * (kEurocHeight - 1)) * scale + 0.5 * (height - 1);
  return camera;
}

}  // namespace

vo::StereoRig SimulationRig(int width, int height) {
  vo::Camera left;
  left.width = kEurocWidth;
  left.height = kEurocHeight;
  left.fx = 458.654;
  left.fy = 457.296;
  left.cx = 367.215;
  left.cy = 248.375;
  left.distortion = vo::Distortion::kRadialTangential;
  left.coefficients = {-0.28340811, 0.07395907, 0.00019359, 1.76187114e-05, 0.0};
  vo::Camera right = left;
  right.fx = 457.587;
  right.fy = 456.134;
  right.cx = 379.999;
  right.cy = 255.238;
  right.coefficients = {-0.28368365, 0.07451284, -0.00010473, -3.55590700e-05, 0.0};

  vo::StereoRig rig;
  rig.body_frame = "imu (body)";
  rig.cameras = {Scaled(left, width, height), Scaled(right, width, height)};
  Eigen::Matrix<double, 3, 4> body_from_left;
  body_from_left << 0.0148655429818, -0.999880929698, 0.00414029679422, -0.0216401454975,
      0.999557249008, 0.0149672133247, 0.025715529948, -0.064676986768,  //
      -0.0257744366974, 0.00375618835797, 0.999660727178, 0.00981073058949;
  Eigen::Matrix<double, 3, 4> body_from_right;
  body_from_right << 0.0125552670891, -0.999755099723, 0.0182237714554, -0.0198435579556,
      0.999598781151, 0.0130119051815, 0.0251588363115, 0.0453689425024,  //
      -0.0253898008918, 0.0179005838253, 0.999517347078, 0.00786212447038;
  rig.body_from_cam = {FromRows(body_from_left), FromRows(body_from_right)};

  for (const vo::Camera& camera : rig.cameras) {
    camera.Validate("the simulated camera");
    for (const double x : {-0.5, width - 0.5}) {
      for (const double y : {-0.5, height - 0.5}) {
        const Eigen::Vector2d pixel(x, y);
        const double error = (camera.Distort(camera.Undistort(pixel)) - pixel).norm();
        if (!(error < 1e-3)) {
          throw Error("images of " + std::to_string(width) + " x " + std::to_string(height) +
                      " pixels reach beyond what the simulated lens can see, expected a height "
                      "of at most about twice the width");
        }
      }
    }
  }
  return rig;
}

vo::StereoRig WithRightTurned(const vo::StereoRig& rig, double angle) {
  vo::StereoRig turned = rig;
  Eigen::Quaterniond& body_from_right = turned.body_from_cam[1].rotation;
  body_from_right =
      body_from_right * Eigen::Quaterniond(Eigen::AngleAxisd(angle, Eigen::Vector3d::UnitY()));
  return turned;
}

}  // namespace gluevo::simulation
