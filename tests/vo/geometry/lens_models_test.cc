// Every lens model over several cameras as people have them.

#include <gtest/gtest.h>

#include <cmath>
#include <opencv2/calib3d.hpp>
#include <string>
#include <vector>

#include "gluevo/nn/error.h"
#include "gluevo/vo/geometry/camera.h"

namespace gluevo::vo {
namespace {

struct Case {
  std::string name;
  Camera camera;
  bool whole_image;  ///< Every pixel sees a point in front of the camera.
};

std::vector<Case> Cases() {
  using enum Distortion;
  return {
      {"pinhole", {1241, 376, 718.9, 718.9, 607.2, 185.2, kNone, {}}, true},
      {"EuRoC",
       {752,
        480,
        458.654,
        457.296,
        367.215,
        248.375,
        kRadialTangential,
        {-0.28340811, 0.07395907, 0.00019359, 1.76187114e-05}},
       true},
      {"KITTI unrectified",
       {1392,
        512,
        984.0,
        980.5,
        690.0,
        233.2,
        kRadialTangential,
        {-0.3728, 0.2037, 0.0022, 0.0014, -0.0723}},
       true},
      {"webcam",
       {640, 480, 620.0, 621.0, 315.0, 245.0, kRadialTangential, {0.1, -0.2, 1e-3}},
       true},
      {"TUM-VI",
       {512,
        512,
        190.978,
        190.973,
        254.932,
        256.897,
        kEquidistant,
        {0.00348, 0.000715, -0.002053, 0.000203}},
       false},
      {"T265",
       {848, 800, 284.5, 285.8, 421.9, 397.3, kEquidistant, {-0.0051, 0.0409, -0.0387, 0.0063}},
       false},
      {"narrow fisheye",
       {1280, 720, 600.0, 600.0, 640.0, 360.0, kEquidistant, {-0.03, 0.01, -0.004, 0.0005}},
       true},
      {"OAK-D",
       {1280,
        800,
        799.2,
        799.4,
        640.4,
        404.3,
        kRational,
        {-2.87, 9.18, -7e-5, 3e-4, 4.9, -2.95, 9.4, 4.4}},
       true},
      {"Azure Kinect",
       {2048,
        1536,
        981.6,
        981.4,
        1023.6,
        778.4,
        kRational,
        {0.4929, -2.7175, 7.6e-4, -2.3e-4, 1.4775, 0.3714, -2.5341, 1.4057}},
       true},
      {"six terms",
       {752,
        480,
        458.654,
        457.296,
        367.215,
        248.375,
        kRational,
        {-0.23340811, 0.0597886645, 0.00019359, 1.76e-05, 0.0036979535, 0.05, 0.0, 0.0}},
       true},
      {"omni", {752, 480, 735.4, 733.1, 367.2, 248.4, kMei, {0.9, -0.06, 0.05, 1e-4, -2e-4}}, true},
      {"VINS-Mono's MEI",
       {752, 480, 863.4, 863.0, 373.0, 256.9, kMei, {1.1, -0.0456, 0.0493, 1.5e-3, -1.0e-3}},
       true},
      {"sphere alone", {1024, 1024, 500.0, 500.0, 512.0, 512.0, kMei, {1.2}}, false},
      {"double sphere",
       {752, 480, 349.7, 348.9, 365.9, 249.3, kDoubleSphere, {-0.2409573, 0.5657582}},
       true},
      {"double sphere of TUM-VI",
       {512, 512, 158.28, 158.28, 254.96, 256.89, kDoubleSphere, {-0.17213, 0.5931}},
       false},
      {"double sphere of a normal lens",
       {1280, 720, 700.0, 701.0, 640.0, 360.0, kDoubleSphere, {0.05, 0.45}},
       true},
      {"EUCM", {752, 480, 460.77, 459.48, 366.29, 249.37, kExtendedUnified, {0.603, 1.098}}, true},
      {"EUCM of TUM-VI",
       {512, 512, 191.15, 191.14, 254.96, 256.89, kExtendedUnified, {0.6298, 1.0458}},
       false},
      {"EUCM below a half",
       {1280, 720, 700.0, 701.0, 640.0, 360.0, kExtendedUnified, {0.3, 0.9}},
       true},
      {"field of view", {640, 480, 329.0, 331.0, 312.0, 251.0, kFieldOfView, {0.92}}, true},
      {"field of view of a wide lens",
       {1280, 1024, 348.0, 348.5, 640.5, 502.0, kFieldOfView, {0.9306}},
       false},
      {"hardly any field of view",
       {640, 480, 500.0, 500.0, 320.0, 240.0, kFieldOfView, {0.01}},
       true},
  };
}

TEST(LensModelsTest, UndistortInvertsDistortOverTheWholeImage) {
  for (const auto& [name, camera, whole_image] : Cases()) {
    SCOPED_TRACE(name);
    camera.Validate(name);
    double worst = 0.0;
    double worst_back = 0.0;
    int pixels = 0;
    int without = 0;
    for (int y = 0; y < camera.height; y += 3) {
      for (int x = 0; x < camera.width; x += 3) {
        ++pixels;
        const Eigen::Vector2d pixel(x, y);
        const Eigen::Vector2d point = camera.Undistort(pixel);
        if (!point.allFinite()) {
          ++without;
          continue;
        }
        worst = std::max(worst, (camera.Distort(point) - pixel).norm());
        // The other way round where rounding of the pixel isn't spread too far over the plane.
        if (point.norm() < 5.0) {
          worst_back =
              std::max(worst_back, (camera.Undistort(camera.Distort(point)) - point).norm());
        }
      }
    }
    EXPECT_LT(worst, 1e-6);
    EXPECT_LT(worst_back, 1e-8);
    EXPECT_EQ(without == 0, whole_image) << without << " of " << pixels;
    EXPECT_LT(without, pixels / 2);
  }
}

TEST(LensModelsTest, JacobiansAreTheNumericOnes) {
  for (const auto& [name, camera, whole_image] : Cases()) {
    SCOPED_TRACE(name);
    for (int y = 0; y < camera.height; y += camera.height / 9) {
      for (int x = 0; x < camera.width; x += camera.width / 9) {
        const Eigen::Vector2d point = camera.Undistort(Eigen::Vector2d(x, y));
        if (!point.allFinite() || point.norm() > 20.0) {
          continue;
        }
        // The fourth-order difference: its error is step^4, and that of rounding 1e-13 / step.
        const double step = 1e-3;
        Eigen::Matrix2d numeric;
        for (int i = 0; i < 2; ++i) {
          const Eigen::Vector2d d = step * Eigen::Vector2d::Unit(i);
          numeric.col(i) = (8.0 * (camera.Distort(point + d) - camera.Distort(point - d)) -
                            (camera.Distort(point + 2.0 * d) - camera.Distort(point - 2.0 * d))) /
                           (12.0 * step);
        }
        const Eigen::Matrix2d jacobian = camera.DistortJacobian(point);
        EXPECT_LT((jacobian - numeric).cwiseAbs().maxCoeff() / camera.fx, 1e-6)
            << point.transpose();
      }
    }
    EXPECT_TRUE(
        camera.DistortJacobian({0.0, 0.0}).isApprox(camera.DistortJacobian({1e-11, -1e-11}), 1e-8));
  }
}

TEST(LensModelsTest, RationalIsOpenCvs) {
  for (const auto& [name, camera, whole_image] : Cases()) {
    if (camera.distortion != Distortion::kRational) {
      continue;
    }
    const std::vector<cv::Point3d> points = {{0.0, 0.0, 1.0}, {0.3, -0.2, 1.0}, {-0.5, 0.4, 1.1}};
    std::vector<cv::Point2d> pixels;
    const cv::Mat matrix =
        (cv::Mat_<double>(3, 3) << camera.fx, 0, camera.cx, 0, camera.fy, camera.cy, 0, 0, 1);
    cv::projectPoints(points, cv::Mat::zeros(3, 1, CV_64F), cv::Mat::zeros(3, 1, CV_64F), matrix,
                      camera.coefficients, pixels);
    for (std::size_t i = 0; i < points.size(); ++i) {
      const Eigen::Vector2d pixel = camera.Project({points[i].x, points[i].y, points[i].z});
      EXPECT_NEAR(pixel.x(), pixels[i].x, 1e-9);
      EXPECT_NEAR(pixel.y(), pixels[i].y, 1e-9);
    }
  }
}

// Of models that include another one.
TEST(LensModelsTest, SpecialCasesAgree) {
  const Camera pinhole = {640, 480, 500.0, 510.0, 320.0, 240.0, Distortion::kNone, {}};
  const auto with = [&](Distortion distortion, const DistortionCoefficients& coefficients) {
    Camera camera = pinhole;
    camera.distortion = distortion;
    camera.coefficients = coefficients;
    return camera;
  };
  const Eigen::Vector2d p(0.4, -0.3);
  // A sphere of xi and the extended model of beta 1 are two ways to write one camera.
  const double xi = 0.8;
  Camera mei = with(Distortion::kMei, {xi});
  mei.fx *= 1.0 + xi;
  mei.fy *= 1.0 + xi;
  EXPECT_TRUE(mei.Distort(p).isApprox(
      with(Distortion::kExtendedUnified, {xi / (1.0 + xi), 1.0}).Distort(p)));
  EXPECT_TRUE(with(Distortion::kMei, {0.0}).Distort(p).isApprox(pinhole.Distort(p)));
  EXPECT_TRUE(
      with(Distortion::kExtendedUnified, {0.0, 1.0}).Distort(p).isApprox(pinhole.Distort(p)));
  EXPECT_TRUE(with(Distortion::kDoubleSphere, {0.0, 0.0}).Distort(p).isApprox(pinhole.Distort(p)));
  EXPECT_TRUE(with(Distortion::kDoubleSphere, {0.0, 0.6})
                  .Distort(p)
                  .isApprox(with(Distortion::kExtendedUnified, {0.6, 1.0}).Distort(p)));
  EXPECT_TRUE(with(Distortion::kFieldOfView, {1e-5}).Distort(p).isApprox(pinhole.Distort(p), 1e-9));
  const DistortionCoefficients k = {-0.3, 0.1, 1e-3, 2e-3, 0.01};
  EXPECT_TRUE(with(Distortion::kRational, k)
                  .Distort(p)
                  .isApprox(with(Distortion::kRadialTangential, k).Distort(p)));
  EXPECT_TRUE(mei.CentralFocal().isApprox(pinhole.CentralFocal()));
}

TEST(LensModelsTest, CoefficientsThatNoLensHasAreRefused) {
  const std::vector<std::pair<Distortion, DistortionCoefficients>> bad = {
      {Distortion::kMei, {-0.1}},
      {Distortion::kDoubleSphere, {-1.2, 0.5}},
      {Distortion::kDoubleSphere, {0.1, 1.5}},
      {Distortion::kExtendedUnified, {0.5, 0.0}},
      {Distortion::kExtendedUnified, {-0.5, 1.0}},
      {Distortion::kFieldOfView, {0.0}},
      {Distortion::kFieldOfView, {4.0}}};
  for (const auto& [distortion, coefficients] : bad) {
    const Camera camera = {640, 480, 500.0, 500.0, 320.0, 240.0, distortion, coefficients};
    EXPECT_THROW(camera.Validate("camera"), Error) << NameOf(distortion);
  }
}

TEST(LensModelsTest, NamesAreThere) {
  EXPECT_EQ(NameOf(Distortion::kDoubleSphere), "double sphere");
  EXPECT_EQ(CoefficientNames(Distortion::kMei),
            (std::vector<std::string_view>{"xi", "k1", "k2", "p1", "p2"}));
  EXPECT_TRUE(CoefficientNames(Distortion::kNone).empty());
}

}  // namespace
}  // namespace gluevo::vo
