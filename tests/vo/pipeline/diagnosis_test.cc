#include "gluevo/vo/pipeline/diagnosis.h"

#include <gtest/gtest.h>

#include <string>

namespace gluevo::vo {
namespace {

// Good images, of which every frame was lost none the less.
StereoLook GoodLook() {
  return {.brightness = {120.0, 121.0},
          .contrast = {40.0, 41.0},
          .corners = {200, 200},
          .found = 150,
          .fit = 140,
          .fit_exchanged = 20,
          .fit_inverted = 20,
          .before = 200,
          .followed = 150};
}

RunEvidence Lost(const StereoLook& look) {
  return {.baseline_m = 0.11,
          .frames = 10,
          .located = 0,
          .looks = {look, look, look},
          .steps_s = {0.1, 0.1, 0.1},
          .matched = 50.0,
          .stereo = 50.0};
}

// One sentence with each of the words, and nothing else.
void ExpectCause(const RunEvidence& evidence, const std::vector<std::string>& words) {
  const std::vector<std::string> causes = Causes(evidence);
  ASSERT_EQ(causes.size(), 1U) << words.front();
  EXPECT_EQ(causes.front().find('\n'), std::string::npos);
  for (const std::string& word : words) {
    EXPECT_NE(causes.front().find(word), std::string::npos) << word << " in: " << causes.front();
  }
}

TEST(DiagnosisTest, GoodRunsHaveNoCauses) {
  RunEvidence evidence = Lost(GoodLook());
  evidence.frames = 100;
  evidence.located = 95;  // One lost in a while.
  evidence.looks.front().corners = {0, 0};
  EXPECT_TRUE(Causes(evidence).empty());
  EXPECT_TRUE(Causes({}).empty());
}

TEST(DiagnosisTest, ImagesWithoutContent) {
  StereoLook look;
  look.is_same = true;
  ExpectCause(Lost(look), {"dark", "0 keypoints", "brightness 0 of 255"});
  look.brightness = {250.0, 250.0};
  ExpectCause(Lost(look), {"white"});
  look.brightness = {128.0, 128.0};
  ExpectCause(Lost(look), {"no texture"});
  StereoLook covered = GoodLook();
  covered.corners[1] = 0;
  covered.brightness[1] = 2.0;
  ExpectCause(Lost(covered), {"the right images are dark"});
}

TEST(DiagnosisTest, OneCamerasImagesTwice) {
  StereoLook look = GoodLook();
  look.is_same = true;
  look.fit = 200;
  ExpectCause(Lost(look), {"the same"});
}

TEST(DiagnosisTest, CamerasExchangedOrTransformInverted) {
  StereoLook look = GoodLook();
  look.fit = 5;
  look.fit_exchanged = 140;
  look.fit_inverted = 130;
  ExpectCause(Lost(look), {"of 450 matches", "15 fit", "420 would if left and right were exchanged",
                           "swapped", "transform"});
  look.fit_exchanged = 10;
  ExpectCause(Lost(look), {"390 would if the transform between the cameras were inverted"});
}

TEST(DiagnosisTest, ACalibrationOfAnotherRig) {
  StereoLook look = GoodLook();
  look.fit = 30;
  look.fit_exchanged = 35;
  ExpectCause(Lost(look), {"only 90", "calibration does not fit"});
}

TEST(DiagnosisTest, TimesAndBaselineInAnotherUnit) {
  RunEvidence fast = Lost(GoodLook());
  fast.refused_speeds = std::vector<double>(9, 4000.0);
  fast.steps_s = {1e-4};
  ExpectCause(fast, {"4e+03 m/s", "0.0001 s from frame to frame", "0.11 m", "units"});
  RunEvidence millimetres = Lost(GoodLook());
  millimetres.baseline_m = 110.0;
  ExpectCause(millimetres, {"baseline", "110 m", "in metres"});
}

TEST(DiagnosisTest, FramesFarApart) {
  StereoLook look = GoodLook();
  look.followed = 10;
  RunEvidence evidence = Lost(look);
  evidence.steps_s = {3.0};
  evidence.matched = 2.0;
  ExpectCause(evidence, {"30 of 600", "3 s later", "too slowly"});
}

TEST(DiagnosisTest, PairsThatShowDifferentThings) {
  StereoLook look = GoodLook();
  look.found = 10;
  look.fit = 4;
  look.fit_exchanged = 3;
  look.fit_inverted = 3;
  ExpectCause(Lost(look), {"30 of 600", "little in common"});
}

TEST(DiagnosisTest, WeightsAreBlamedOnlyWherePlainCornersMatch) {
  RunEvidence evidence = Lost(GoodLook());
  evidence.uses_networks = true;
  evidence.matched = 1.0;
  evidence.stereo = 2.0;
  ExpectCause(evidence, {"420 of 600", "weights"});
  evidence.uses_networks = false;
  EXPECT_TRUE(Causes(evidence).empty());
}

TEST(DiagnosisTest, LooksOnlyAtFramesThatWereLost) {
  StereoRig rig;
  for (Camera& camera : rig.cameras) {
    camera = {.width = 64, .height = 48, .fx = 50.0, .fy = 50.0, .cx = 32.0, .cy = 24.0};
  }
  rig.body_from_cam[1].translation = {0.2, 0.0, 0.0};
  Diagnosis diagnosis(rig, /*uses_networks=*/false);
  const cv::Mat black = cv::Mat::zeros(48, 64, CV_8UC1);
  int64_t timestamp_ns = 0;
  const auto add = [&](int frames, int inliers, bool has_images) {
    for (int i = 0; i < frames; ++i) {
      timestamp_ns += 50'000'000;
      FrameResult result{.timestamp_ns = timestamp_ns, .stereo = 60, .inliers = inliers};
      diagnosis.Add(
          {timestamp_ns, {has_images ? black : cv::Mat(), has_images ? black : cv::Mat()}}, result);
    }
  };
  add(1, 0, true);  // The first one has nothing to be located by.
  add(9, 50, true);
  EXPECT_TRUE(diagnosis.evidence().looks.empty());
  add(5, 0, false);
  EXPECT_TRUE(diagnosis.evidence().looks.empty());
  add(9, 0, true);
  EXPECT_EQ(diagnosis.evidence().looks.size(), 4U);  // The 1st, 2nd, 4th, 8th.
  EXPECT_EQ(diagnosis.evidence().frames, 24);
  EXPECT_EQ(diagnosis.evidence().located, 9);
  EXPECT_DOUBLE_EQ(diagnosis.evidence().baseline_m, 0.2);
  EXPECT_NEAR(diagnosis.evidence().steps_s.front(), 0.05, 1e-12);
  EXPECT_EQ(diagnosis.Causes().size(), 1U);
}

}  // namespace
}  // namespace gluevo::vo
