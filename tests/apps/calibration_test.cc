// gluevo calibration as a user runs it.

#include <gtest/gtest.h>

#include <string>

#include "apps/command_test.h"

namespace gluevo::apps {
namespace {

class CalibrationTest : public CommandTest {};

TEST_F(CalibrationTest, RefusesASizeThatIsNotTheFiles) {
  const std::string file = Write("chain.yaml", Camchain(640, 480));
  EXPECT_EQ(Run("calibration " + file + " --size 640x480").exit_code, 0);
  const Outcome outcome = Run("calibration " + file + " --size 752x480");
  EXPECT_EQ(outcome.exit_code, 1);
  EXPECT_EQ(outcome.out, "");
  EXPECT_EQ(outcome.error,
            "gluevo: error: " + file + ": images of 640 x 480 pixels, --size says 752 x 480\n");
}

}  // namespace
}  // namespace gluevo::apps
