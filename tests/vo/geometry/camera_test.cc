#include "gluevo/vo/geometry/stereo_rig.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>
#include <opencv2/calib3d.hpp>
#include <random>
#include <string>
#include <vector>

#include "gluevo/nn/error.h"

namespace gluevo::vo {
namespace {

// cam0 of EuRoC V1_01, from its sensor.yaml.
Camera EurocCamera() {
  return {.width = 752,
          .height = 480,
          .fx = 458.654,
          .fy = 457.296,
          .cx = 367.215,
          .cy = 248.375,
          .distortion = Distortion::kRadialTangential,
          .coefficients = {-0.28340811, 0.07395907, 0.00019359, 1.76187114e-05, 0.0}};
}

// All five coefficients, and a stronger distortion, of the size of KITTI's unrectified cameras.
Camera WideCamera() {
  return {.width = 1392,
          .height = 512,
          .fx = 984.0,
          .fy = 980.5,
          .cx = 690.0,
          .cy = 233.2,
          .distortion = Distortion::kRadialTangential,
          .coefficients = {-0.3728, 0.2037, 0.0022, 0.0014, -0.0723}};
}

// Of the size of TUM-VI's cameras at 512 x 512.
Camera FisheyeCamera() {
  return {.width = 512,
          .height = 512,
          .fx = 190.978,
          .fy = 190.973,
          .cx = 254.932,
          .cy = 256.897,
          .distortion = Distortion::kEquidistant,
          .coefficients = {0.00348, 0.000715, -0.002053, 0.000203, 0.0}};
}

std::vector<cv::Point3d> RandomPoints(double spread) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> lateral(-spread, spread);
  std::uniform_real_distribution<double> depth(0.5, 20.0);
  std::vector<cv::Point3d> points = {{0.0, 0.0, 1.0}, {1e-12, 0.0, 1.0}};
  for (int i = 0; i < 200; ++i) {
    const double z = depth(random);
    points.emplace_back(lateral(random) * z, lateral(random) * z, z);
  }
  return points;
}

cv::Mat Matrix(const Camera& camera) {
  return (cv::Mat_<double>(3, 3) << camera.fx, 0, camera.cx, 0, camera.fy, camera.cy, 0, 0, 1);
}

void ExpectProjectsTo(const Camera& camera, const std::vector<cv::Point3d>& points,
                      const std::vector<cv::Point2d>& pixels) {
  ASSERT_EQ(points.size(), pixels.size());
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Eigen::Vector2d pixel = camera.Project({points[i].x, points[i].y, points[i].z});
    // Both work in doubles on values up to 1000 pixels.
    EXPECT_NEAR(pixel.x(), pixels[i].x, 1e-9);
    EXPECT_NEAR(pixel.y(), pixels[i].y, 1e-9);
  }
}

TEST(CameraTest, RadialTangentialIsOpenCvs) {
  for (const Camera& camera : {EurocCamera(), WideCamera()}) {
    const std::vector<cv::Point3d> points = RandomPoints(0.8);
    std::vector<cv::Point2d> pixels;
    cv::projectPoints(points, cv::Mat::zeros(3, 1, CV_64F), cv::Mat::zeros(3, 1, CV_64F),
                      Matrix(camera), camera.coefficients, pixels);
    ExpectProjectsTo(camera, points, pixels);
  }
}

TEST(CameraTest, EquidistantIsOpenCvsFisheye) {
  const Camera camera = FisheyeCamera();
  const std::vector<cv::Point3d> points = RandomPoints(3.0);
  std::vector<cv::Point2d> pixels;
  const auto& k = camera.coefficients;
  cv::fisheye::projectPoints(points, pixels, cv::Mat::zeros(3, 1, CV_64F),
                             cv::Mat::zeros(3, 1, CV_64F), Matrix(camera),
                             cv::Vec4d(k[0], k[1], k[2], k[3]));
  ExpectProjectsTo(camera, points, pixels);
}

TEST(CameraTest, WithoutDistortionIsAPinhole) {
  Camera camera = EurocCamera();
  camera.distortion = Distortion::kNone;  // The coefficients do not count.
  EXPECT_TRUE(camera.Project({1.0, -2.0, 4.0})
                  .isApprox(Eigen::Vector2d(458.654 / 4.0 + 367.215, -457.296 / 2.0 + 248.375)));
  EXPECT_TRUE(camera.Undistort(camera.Distort({0.3, -0.2})).isApprox(Eigen::Vector2d(0.3, -0.2)));
}

TEST(CameraTest, JacobianIsTheNumericDerivative) {
  for (const Camera& camera : {EurocCamera(), WideCamera(), FisheyeCamera()}) {
    for (const Eigen::Vector2d& point : {Eigen::Vector2d(0.0, 0.0), Eigen::Vector2d(0.4, -0.3),
                                         Eigen::Vector2d(-0.7, 0.1), Eigen::Vector2d(0.0, 0.6)}) {
      // Central differences: the error of the method is step^2 and that of rounding 1e-16 / step,
      // both times some 1000 pixels.
      constexpr double kStep = 1e-5;
      Eigen::Matrix2d numeric;
      for (int i = 0; i < 2; ++i) {
        const Eigen::Vector2d step = kStep * Eigen::Vector2d::Unit(i);
        numeric.col(i) = (camera.Distort(point + step) - camera.Distort(point - step)) / 2 / kStep;
      }
      EXPECT_LT((camera.DistortJacobian(point) - numeric).cwiseAbs().maxCoeff(), 1e-5);
    }
  }
}

TEST(CameraTest, UndistortInvertsOverTheWholeRadialTangentialImage) {
  for (const Camera& camera : {EurocCamera(), WideCamera()}) {
    double worst = 0.0;
    for (int y = -1; y <= camera.height; ++y) {
      for (int x = -1; x <= camera.width; ++x) {
        const Eigen::Vector2d pixel(x, y);
        const Eigen::Vector2d point = camera.Undistort(pixel);
        ASSERT_TRUE(point.allFinite()) << pixel.transpose();
        worst = std::max(worst, (camera.Distort(point) - pixel).norm());
      }
    }
    EXPECT_LT(worst, 1e-9);
  }
}

TEST(CameraTest, UndistortInvertsTheFisheyeImageUpToNinetyDegrees) {
  const Camera camera = FisheyeCamera();
  // The model at 90 degrees, written out.
  const double t = std::numbers::pi / 2.0;
  const auto& k = camera.coefficients;
  const double end = t + k[0] * std::pow(t, 3) + k[1] * std::pow(t, 5) + k[2] * std::pow(t, 7) +
                     k[3] * std::pow(t, 9);
  double worst = 0.0;
  int beyond = 0;
  for (int y = 0; y < camera.height; ++y) {
    for (int x = 0; x < camera.width; ++x) {
      const Eigen::Vector2d pixel(x, y);
      const Eigen::Vector2d point = camera.Undistort(pixel);
      const double distance = std::hypot((x - camera.cx) / camera.fx, (y - camera.cy) / camera.fy);
      ASSERT_EQ(point.allFinite(), distance < end) << pixel.transpose();
      if (distance < end) {
        worst = std::max(worst, (camera.Distort(point) - pixel).norm());
      } else {
        ++beyond;
      }
    }
  }
  EXPECT_LT(worst, 1e-9);
  EXPECT_GT(beyond, 0);
}

TEST(CameraTest, UndistortFindsTheCentralBranchOrNothing) {
  // r (1 - r^2 / 2) has its maximum 0.5443 at r = 0.8165 and comes back from there.
  const double turn = std::sqrt(2.0 / 3.0);
  const double maximum = turn * (1.0 - turn * turn / 2.0);
  const Camera camera = {.width = 1000,
                         .height = 1000,
                         .fx = 500.0,
                         .fy = 500.0,
                         .cx = 500.0,
                         .cy = 500.0,
                         .distortion = Distortion::kRadialTangential,
                         .coefficients = {-0.5, 0.0, 0.0, 0.0, 0.0}};
  for (const double share : {0.5, 0.9, 0.99, 0.9999, 0.999999}) {
    for (int degrees = 0; degrees < 360; degrees += 30) {
      const double angle = degrees * std::numbers::pi / 180.0;
      const Eigen::Vector2d direction(std::cos(angle), std::sin(angle));
      const Eigen::Vector2d pixel =
          Eigen::Vector2d(500.0, 500.0) + 500.0 * share * maximum * direction;
      const Eigen::Vector2d point = camera.Undistort(pixel);
      ASSERT_TRUE(point.allFinite()) << share;
      EXPECT_LT(point.norm(), turn);
      EXPECT_LT((camera.Distort(point) - pixel).norm(), 1e-9);
    }
  }
  for (const double share : {1.0001, 1.1, 1.5, 10.0}) {
    const Eigen::Vector2d pixel(500.0 + 500.0 * share * maximum, 500.0);
    EXPECT_TRUE(camera.Undistort(pixel).array().isNaN().all()) << share;
  }
  // Beyond the turn a point comes back into the image; what is seen there is another point.
  EXPECT_LT(camera.Undistort(camera.Distort({1.2, 0.0})).norm(), turn);
}

TEST(CameraTest, UndistortOfAFisheyeThatTurnsFindsNothingBeyond) {
  Camera camera = FisheyeCamera();
  camera.coefficients = {-0.2, 0.0, 0.0, 0.0, 0.0};  // t (1 - t^2 / 5), maximum at t = 1.291.
  const double turn = std::sqrt(5.0 / 3.0);
  const double maximum = turn * (1.0 - turn * turn / 5.0);
  for (const double share : {0.1, 0.9, 0.999999}) {
    const Eigen::Vector2d pixel(camera.cx + camera.fx * share * maximum, camera.cy);
    const Eigen::Vector2d point = camera.Undistort(pixel);
    EXPECT_LT(std::atan(point.norm()), turn);
    EXPECT_LT((camera.Distort(point) - pixel).norm(), 1e-9);
  }
  EXPECT_FALSE(camera.Undistort({camera.cx + camera.fx * 1.0001 * maximum, camera.cy}).allFinite());
}

TEST(CameraTest, UndistortOfNoPixelIsNoPoint) {
  for (const Camera& camera : {EurocCamera(), FisheyeCamera()}) {
    for (const double value : {std::nan(""), std::numeric_limits<double>::infinity()}) {
      EXPECT_FALSE(camera.Undistort({value, 1.0}).allFinite());
    }
  }
}

std::string ErrorOf(const Camera& camera) {
  try {
    camera.Validate("left");
  } catch (const Error& error) {
    return error.what();
  }
  return "";
}

TEST(CameraTest, ValidateNamesWhatIsWrong) {
  EXPECT_EQ(ErrorOf(EurocCamera()), "");
  Camera camera = EurocCamera();
  camera.height = 0;
  EXPECT_EQ(ErrorOf(camera), "left: the image size 752x0 is not positive");
  camera = EurocCamera();
  camera.fy = -1.0;
  EXPECT_EQ(ErrorOf(camera), "left: the focal lengths 458.654000 and -1.000000 are not positive");
  camera = EurocCamera();
  camera.cx = std::nan("");
  EXPECT_EQ(ErrorOf(camera), "left: the principal point is not finite");
  camera = EurocCamera();
  camera.coefficients[4] = std::numeric_limits<double>::infinity();
  EXPECT_EQ(ErrorOf(camera), "left: the distortion coefficients are not finite");
}

TEST(StereoRigTest, NeedsABaseline) {
  StereoRig rig{.cameras = {EurocCamera(), EurocCamera()}, .body_from_cam = {}, .body_frame = ""};
  EXPECT_THROW(rig.Validate("rig"), Error);
  rig.body_from_cam[1].translation.x() = 0.11;
  EXPECT_NO_THROW(rig.Validate("rig"));
  EXPECT_DOUBLE_EQ(rig.baseline(), 0.11);
  // A point 1 m before the left camera is 0.11 m to the left of the right one's axis.
  EXPECT_TRUE((rig.right_from_left() * Eigen::Vector3d(0.0, 0.0, 1.0))
                  .isApprox(Eigen::Vector3d(-0.11, 0.0, 1.0)));
  rig.body_from_cam[0].translation.y() = std::nan("");
  EXPECT_THROW(rig.Validate("rig"), Error);
}

}  // namespace
}  // namespace gluevo::vo
