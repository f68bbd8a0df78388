// The programs of apps/examples do what docs/LIBRARY.md says of them.

#include <gtest/gtest.h>

#include <algorithm>
#include <sstream>

#include "apps/command_test.h"

namespace gluevo::apps {
namespace {

class ExamplesTest : public CommandTest {
 protected:
  // Eight pairs of a rendered flight, small.
  std::string MakeFlight() const {
    const Outcome outcome = Run("simulate -o " + Path("flight") +
                                " --start 3 --duration 0.8 --width 320 --height 240 --threads 2");
    EXPECT_EQ(outcome.exit_code, 0) << outcome.error;
    return Path("flight");
  }
  static std::ptrdiff_t Lines(const std::string& text) {
    return std::count(text.begin(), text.end(), '\n');
  }
};

TEST_F(ExamplesTest, OdometryPrintsWhatTheCommandWrites) {
  const std::string flight = MakeFlight();
  const Outcome printed = RunProgram(GLUEVO_EXAMPLES "odometry", flight);
  ASSERT_EQ(printed.exit_code, 0) << printed.error;
  const Outcome run = Run("run " + flight + " -o " + Path("out"));
  ASSERT_EQ(run.exit_code, 0) << run.error;
  std::istringstream example(printed.out);
  std::istringstream command(Contents(Path("out/trajectory.tum")));
  std::string line;
  for (double a = 0.0; example >> a;) {
    while ((command >> std::ws).peek() == '#') {
      std::getline(command, line);
    }
    double b = 0.0;
    ASSERT_TRUE(command >> b);
    EXPECT_NEAR(a, b, 1e-6);
  }
  EXPECT_EQ(Lines(printed.out), 8);
  const Outcome refused = RunProgram(GLUEVO_EXAMPLES "odometry", Path("absent"));
  EXPECT_EQ(refused.exit_code, 1);
  EXPECT_NE(refused.error.find("absent"), std::string::npos);
}

TEST_F(ExamplesTest, LiveTellsOfEveryFrame) {
  const Outcome outcome = RunProgram(GLUEVO_EXAMPLES "live", MakeFlight() + " klt");
  ASSERT_EQ(outcome.exit_code, 0) << outcome.error;
  // A busy machine may drop some of the eight.
  const auto dropped = outcome.out.find("8 frames, ");
  ASSERT_NE(dropped, std::string::npos) << outcome.out;
  EXPECT_EQ(Lines(outcome.out), 9 - std::stoi(outcome.out.substr(dropped + 10))) << outcome.out;
}

TEST_F(ExamplesTest, MatchImagesMatchesAnImageWithItself) {
  const fs::path images = fs::path(MakeFlight()) / "mav0" / "cam0" / "data";
  const std::string image = fs::directory_iterator(images)->path().string();
  const Outcome outcome = RunProgram(GLUEVO_EXAMPLES "match_images", image + " " + image);
  ASSERT_EQ(outcome.exit_code, 0) << outcome.error;
  EXPECT_GT(Lines(outcome.out), 50);
  std::istringstream lines(outcome.out);
  int same = 0;
  for (double x0 = 0, y0 = 0, x1 = 0, y1 = 0, confidence = 0;
       lines >> x0 >> y0 >> x1 >> y1 >> confidence;) {
    same += x0 == x1 && y0 == y1 ? 1 : 0;
  }
  EXPECT_GT(same, 0.9 * static_cast<double>(Lines(outcome.out)));
}

TEST_F(ExamplesTest, CustomMatcherKeepsTheFramesLinked) {
  const Outcome outcome = RunProgram(GLUEVO_EXAMPLES "custom_matcher", MakeFlight());
  ASSERT_EQ(outcome.exit_code, 0) << outcome.error;
  EXPECT_EQ(outcome.out, "frames: 8, segments: 1\n");
}

}  // namespace
}  // namespace gluevo::apps
