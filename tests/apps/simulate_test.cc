#include <gtest/gtest.h>

#include <algorithm>

#include "command_test.h"

namespace gluevo::apps {
namespace {

class SimulateTest : public CommandTest {
 protected:
  /// One line on stderr that names `what`, and nothing left behind.
  void ExpectRefused(const std::string& arguments, const std::string& what, int exit_code = 1) {
    const std::size_t files = Files();
    const Outcome outcome = Run("simulate -o " + Path("out") + " " + arguments);
    EXPECT_EQ(outcome.exit_code, exit_code) << arguments;
    EXPECT_NE(outcome.error.find(what), std::string::npos) << outcome.error;
    if (exit_code == 1) {
      EXPECT_EQ(std::count(outcome.error.begin(), outcome.error.end(), '\n'), 1) << outcome.error;
    }
    EXPECT_EQ(Files(), files) << arguments;
  }
};

TEST_F(SimulateTest, BadOptionsGetOneClearLine) {
  ExpectRefused("--duration 0", "duration", 2);
  ExpectRefused("--rate 1e9", "rate", 2);
  ExpectRefused("--width 10", "pixels", 2);
  ExpectRefused("--noise -1", "noise", 2);
  ExpectRefused("--light 2", "light", 2);
  ExpectRefused("--motion-blur 1000", "motion blur", 2);
  ExpectRefused("--exposure-change 9", "exposure", 2);
  ExpectRefused("--vignetting 2", "--vignetting", 2);
  ExpectRefused("--vignetting nan", "--vignetting", 2);
  ExpectRefused("--start -2", "start", 2);
  ExpectRefused("--movers -2", "movers", 2);
  ExpectRefused("--movers 2 --movers-cover 0.8", "share", 2);
  ExpectRefused("--from-takeoff", "take-off", 2);
  ExpectRefused("--laps 2 --path hover", "no laps", 2);
  ExpectRefused("--laps 2 --duration 3", "--laps", 2);
  ExpectRefused("--trajectory " + Path("none.txt"), "none.txt");
  const std::string short_file = Write("short.txt", "1 0 0 0 0 0 0 1\n1.1 0 0 0 0 0 0 1\n");
  ExpectRefused("--trajectory " + short_file, "short.txt: 2 poses over 0.1");
  const std::string still = Write("still.txt", "1 0 0 0 0 0 0 1\n2 0 0 0 0 0 0 1\n");
  ExpectRefused("--trajectory " + still + " --start 3", "still.txt: ends 1.00 s after");
  ExpectRefused("--trajectory " + still + " --from-takeoff", "still.txt: no take-off");
  ExpectRefused("--path moon", "moon", 2);
  ExpectRefused("--path hover --trajectory " + still, "--trajectory", 2);
  ExpectRefused("--pairs 0", "--pairs", 2);
  ExpectRefused("--pairs 4 --path hover", "--pairs", 2);
  ExpectRefused("--pairs 4 --width 20", "pixels", 2);
}

TEST_F(SimulateTest, MakesSequencesAndTrainingRooms) {
  const Outcome sequence = Run("simulate -o " + Path("hover") +
                               " --path hover --duration 0.2 --width 96 --height 64 --depth "
                               "--correspondences --motion-blur 10 --light 0.3");
  EXPECT_EQ(sequence.exit_code, 0) << sequence.error;
  EXPECT_EQ(sequence.out, "data set: " + Path("hover") + "\n");
  EXPECT_TRUE(fs::exists(Path("hover") + "/mav0/correspondences.h5"));
  const Outcome rooms =
      Run("simulate -o " + Path("rooms") + " --pairs 1 --width 96 --height 64 --seed 3");
  EXPECT_EQ(rooms.exit_code, 0) << rooms.error;
  EXPECT_TRUE(fs::exists(Path("rooms") + "/rooms_00000.h5"));
  EXPECT_EQ(Files(), 2U);
}

}  // namespace
}  // namespace gluevo::apps
