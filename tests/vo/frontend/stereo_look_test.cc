#include "gluevo/vo/frontend/stereo_look.h"

#include <gtest/gtest.h>

#include "gluevo/nn/error.h"
#include "textured_views.h"

namespace gluevo::vo {
namespace {

constexpr int kWidth = 200;
constexpr int kHeight = 120;

StereoRig Rig() {
  StereoRig rig;
  for (Camera& camera : rig.cameras) {
    camera = {
        .width = kWidth, .height = kHeight, .fx = 150.0, .fy = 150.0, .cx = 100.0, .cy = 60.0};
  }
  rig.body_from_cam[1].translation = {0.1, 0.0, 0.0};
  return rig;
}

cv::Mat At(double x, double y = 0.0) { return testing::PatternAt(x, y, kWidth, kHeight); }

TEST(StereoLookTest, AGoodPairFits) {
  const StereoLook look = LookAt({0, {At(0.0), At(-6.0)}}, Rig(), At(3.0));
  EXPECT_FALSE(look.is_same);
  EXPECT_GT(look.corners[0], 40);
  EXPECT_GT(look.corners[1], 40);
  EXPECT_GT(look.found, 30);
  EXPECT_GT(10 * look.fit, 9 * look.found);
  EXPECT_LT(look.fit_exchanged, look.found / 2);
  EXPECT_LT(look.fit_inverted, look.found / 2);
  EXPECT_GT(look.before, 40);
  EXPECT_GT(look.followed, look.before / 2);
  EXPECT_NEAR(look.brightness[0], 127.0, 10.0);
  EXPECT_GT(look.contrast[1], 20.0);
}

TEST(StereoLookTest, ExchangedImagesAndAnInvertedTransformShow) {
  const StereoLook exchanged = LookAt({0, {At(-6.0), At(0.0)}}, Rig(), {});
  EXPECT_LT(exchanged.fit, exchanged.found / 2);
  EXPECT_GT(10 * exchanged.fit_exchanged, 9 * exchanged.found);
  EXPECT_EQ(exchanged.before, 0);
  // With a turn about the optical axis the two are told apart.
  StereoRig inverted = Rig();
  inverted.body_from_cam[1].rotation =
      Eigen::Quaterniond(Eigen::AngleAxisd(0.02, Eigen::Vector3d::UnitX()));
  inverted.body_from_cam[1] = inverted.body_from_cam[1].Inverse();
  // What the rig before inversion sees of far points is 3 pixels lower in its right image.
  const StereoLook look = LookAt({0, {At(0.0), At(-6.0, 3.0)}}, inverted, {});
  EXPECT_LT(look.fit, look.found / 2);
  EXPECT_GT(10 * look.fit_inverted, 9 * look.found);
}

TEST(StereoLookTest, ImagesWithoutContentHaveNoCorners) {
  const cv::Mat black = cv::Mat::zeros(kHeight, kWidth, CV_8UC1);
  cv::Mat gray_with_noise(kHeight, kWidth, CV_8UC1, cv::Scalar(100));
  gray_with_noise.at<unsigned char>(50, 50) = 101;
  for (const cv::Mat& image : {black, gray_with_noise}) {
    const StereoLook look = LookAt({0, {image, image}}, Rig(), image);
    EXPECT_TRUE(look.is_same);
    EXPECT_EQ(look.corners[0], 0);
    EXPECT_EQ(look.found, 0);
    EXPECT_EQ(look.before, 0);
  }
}

TEST(StereoLookTest, RefusesImagesOfAnotherSize) {
  EXPECT_THROW(LookAt({0, {At(0.0), cv::Mat()}}, Rig(), {}), Error);
}

}  // namespace
}  // namespace gluevo::vo
