#include "gluevo/vo/pipeline/presets.h"

#include <gtest/gtest.h>

#include "gluevo/nn/error.h"

namespace gluevo::vo {
namespace {

TEST(Presets, FollowTheKindOfData) {
  EXPECT_EQ(PresetOf(DatasetFormat::kEuroc), "euroc");
  EXPECT_EQ(PresetOf(DatasetFormat::kPlain), "euroc");
  EXPECT_EQ(PresetOf(DatasetFormat::kKittiOdometry), "driving");
  EXPECT_EQ(PresetOf(DatasetFormat::kKittiRaw), "driving");
}

TEST(Presets, DrivingIsVinsFusionsForKitti) {
  const OdometryConfig driving = PresetConfig("driving");
  EXPECT_EQ(driving.frontend.klt.max_corners, 200);
  EXPECT_EQ(driving.odometry.window.keyframe_parallax_px, 15.0);
  const OdometryConfig euroc = PresetConfig("euroc");
  EXPECT_EQ(euroc.frontend.klt.max_corners, 150);
  EXPECT_EQ(euroc.odometry.window.keyframe_parallax_px, 7.0);
}

TEST(Presets, AreValidForEachMethod) {
  for (const Preset& preset : Presets()) {
    for (const char* const method : {"klt", "superpoint", "superglue"}) {
      const OdometryConfig config = PresetConfig(preset.name, method);
      EXPECT_NO_THROW(config.Validate()) << preset.name << ' ' << method;
      EXPECT_EQ(config.frontend.method, method);
    }
  }
  EXPECT_EQ(PresetConfig("euroc", "superpoint").frontend.keypoints.max_keypoints, 1500);
}

// Published thresholds; ALIKED's keypoints lie between pixels as they are.
TEST(Presets, FollowFeaturesAndMatcher) {
  const FrontEndConfig superpoint = PresetConfig("euroc").frontend;
  EXPECT_EQ(superpoint.features, "superpoint");
  EXPECT_EQ(superpoint.matcher, "superglue");
  EXPECT_EQ(superpoint.keypoints.keypoint_threshold, 0.005F);
  EXPECT_EQ(superpoint.learned.tracking_threshold, 0.2F);
  EXPECT_EQ(superpoint.refine, "lk");
  EXPECT_EQ(superpoint.stereo_matching, "band");
  const FrontEndConfig aliked = PresetConfig("driving", "superglue", "aliked").frontend;
  EXPECT_EQ(aliked.features, "aliked");
  EXPECT_EQ(aliked.matcher, "lightglue");
  EXPECT_EQ(aliked.keypoints.keypoint_threshold, 0.2F);
  EXPECT_EQ(aliked.keypoints.max_keypoints, 500);
  EXPECT_EQ(aliked.learned.tracking_threshold, 0.1F);
  EXPECT_EQ(aliked.learned.stereo_threshold, 0.1F);
  EXPECT_EQ(aliked.refine, "none");
  EXPECT_EQ(aliked.stereo_matching, "network");
  EXPECT_EQ(PresetConfig("euroc", "superglue", "aliked", "nn").frontend.matcher, "nn");
  // Method 1 matches tracks, which lie anywhere.
  const FrontEndConfig tracks = PresetConfig("euroc", "superpoint", "aliked").frontend;
  EXPECT_EQ(tracks.keypoints.keypoint_threshold, 0.02F);
  EXPECT_EQ(tracks.keypoints.max_keypoints, 1500);
  EXPECT_EQ(tracks.refine, "lk");
  EXPECT_EQ(MatcherOf(tracks), "");
  EXPECT_EQ(MatcherOf(aliked), "lightglue");
}

TEST(Presets, RefuseNamesThatAreNotKnown) {
  try {
    PresetConfig("boats");
    FAIL();
  } catch (const Error& error) {
    EXPECT_NE(std::string(error.what()).find("\"boats\""), std::string::npos) << error.what();
    EXPECT_NE(std::string(error.what()).find("euroc, driving"), std::string::npos) << error.what();
  }
  EXPECT_THROW(PresetConfig("euroc", "orb"), Error);
  EXPECT_THROW(PresetConfig("euroc", "superglue", "orb"), Error);
}

TEST(FrontEndConfig, RefusesNamesThatAreNotKnown) {
  EXPECT_THROW((FrontEndConfig{.matcher = "flann"}.Validate()), Error);
  EXPECT_THROW((FrontEndConfig{.refine = "yes"}.Validate()), Error);
  EXPECT_THROW((FrontEndConfig{.features = "aliked", .matcher = "superglue"}.Validate()), Error);
  EXPECT_THROW((FrontEndConfig{.features = "aliked", .refine = "subpixel"}.Validate()), Error);
  EXPECT_NO_THROW((FrontEndConfig{.features = "aliked"}.Validate()));
  // Corners and optical flow have neither.
  EXPECT_NO_THROW(
      (FrontEndConfig{.method = "klt", .features = "aliked", .matcher = "superglue"}.Validate()));
  FrontEndConfig config;
  config.networks.precision = "int8";
  EXPECT_THROW(config.Validate(), Error);
}

}  // namespace
}  // namespace gluevo::vo
