// gluevo calibration as a user runs it.

#include <gtest/gtest.h>

#include <string>

#include "apps/command_test.h"

namespace gluevo::apps {
namespace {

class CalibrationTest : public CommandTest {};

TEST_F(CalibrationTest, RefusesASizeThatIsNotTheFiles) {
  std::string text;
  for (const std::string camera : {"0", "1"}) {
    text += "cam" + camera +
            ":\n  camera_model: pinhole\n  distortion_model: radtan\n"
            "  distortion_coeffs: [0, 0, 0, 0]\n  intrinsics: [500, 500, 320, 240]\n"
            "  resolution: [640, 480]\n";
  }
  text += "  T_cn_cnm1: [[1, 0, 0, -0.1], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]\n";
  const std::string file = Write("chain.yaml", text);
  EXPECT_EQ(Run("calibration " + file + " --size 640x480").exit_code, 0);
  const Outcome outcome = Run("calibration " + file + " --size 752x480");
  EXPECT_EQ(outcome.exit_code, 1);
  EXPECT_EQ(outcome.out, "");
  EXPECT_EQ(outcome.error,
            "gluevo: error: " + file + ": images of 640 x 480 pixels, --size says 752 x 480\n");
}

}  // namespace
}  // namespace gluevo::apps
