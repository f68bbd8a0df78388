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
  EXPECT_EQ(euroc.odometry.window.keyframe_parallax_px, 10.0);
}

TEST(Presets, AreValidForEachMethod) {
  for (const Preset& preset : Presets()) {
    for (const char* const method : {"klt", "superpoint", "superglue"}) {
      const OdometryConfig config = PresetConfig(preset.name, method);
      EXPECT_NO_THROW(config.Validate()) << preset.name << ' ' << method;
      EXPECT_EQ(config.frontend.method, method);
    }
  }
  EXPECT_EQ(PresetConfig("euroc", "superpoint").frontend.superpoint.max_keypoints, 1500);
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
}

TEST(FrontEndConfig, RefusesNamesThatAreNotKnown) {
  EXPECT_THROW((FrontEndConfig{.matcher = "flann"}.Validate()), Error);
  EXPECT_THROW((FrontEndConfig{.refine = "yes"}.Validate()), Error);
  FrontEndConfig config;
  config.networks.precision = "int8";
  EXPECT_THROW(config.Validate(), Error);
}

}  // namespace
}  // namespace gluevo::vo
