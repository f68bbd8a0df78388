// What a command line that asks for what there is not is answered: one line, and what was expected.

#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/file.h>
#include <unistd.h>

#include <algorithm>
#include <string>
#include <vector>

#include "apps/command_test.h"

namespace gluevo::apps {
namespace {

class UsageTest : public CommandTest {
 protected:
  void ExpectRefused(const std::string& arguments, int exit_code, const std::string& phrase) const {
    SCOPED_TRACE(arguments);
    const Outcome outcome = Run(arguments);
    EXPECT_EQ(outcome.exit_code, exit_code);
    EXPECT_EQ(outcome.out, "");
    EXPECT_EQ(std::count(outcome.error.begin(), outcome.error.end(), '\n'), 1) << outcome.error;
    EXPECT_EQ(outcome.error.rfind("gluevo: error: ", 0), 0U) << outcome.error;
    EXPECT_NE(outcome.error.find(phrase), std::string::npos) << outcome.error;
    EXPECT_NE(outcome.error.find("expected"), std::string::npos) << outcome.error;
  }
  void ExpectBadUsage(const std::string& arguments, const std::string& phrase) const {
    ExpectRefused(arguments, 2, phrase);
    EXPECT_NE(Run(arguments).error.find("; see gluevo "), std::string::npos) << arguments;
  }
};

TEST_F(UsageTest, WhatThereIsNotIsNamed) {
  ExpectBadUsage("", "no command, expected one of run, live, extract");
  ExpectBadUsage("fly data", "\"fly\" is no command, expected one of run, live, extract");
  ExpectBadUsage("run", "DATASET is missing, expected: Folder of the data set; see gluevo run");
  ExpectBadUsage("run data", "--output is missing, expected: Folder for the results");
  ExpectBadUsage("extract images --out f.h5", "\"--out\" is no option of gluevo extract");
  ExpectBadUsage("run data more -o out", "\"more\" is one argument too many, expected DATASET");
  ExpectBadUsage("run data -o", "--output has no value, expected: Folder for the results");
  ExpectBadUsage("run data -o out --count 1 --count 2", "--count is given 2 times, expected once");
  ExpectBadUsage("run data -o out --method orb",
                 "--method: expected superglue, superpoint or klt, got \"orb\"");
  ExpectBadUsage("run data -o out --replay a.h5 --save-matches b.h5", "expected one of them");
  ExpectBadUsage("match features.h5", "--pairs and --output are expected");
}

TEST_F(UsageTest, NumbersAreWhatTheyAreExpectedToBe) {
  const std::string run = "run data -o out ";
  for (const auto& [arguments, phrase] : std::vector<std::pair<std::string, std::string>>{
           {run + "--right-turn-mrad -1", "--right-turn-mrad: expected a number from 0 to 1e+06"},
           {run + "--max-predicted nan", "--max-predicted: expected a number from 0 to 1e+06"},
           {run + "--threads 0", "--threads: expected a whole number from 1 to 1024, got \"0\""},
           {run + "--threads 2x", "--threads: expected a whole number from 1 to 1024, got \"2x\""},
           {run + "--count -1", "--count: expected a whole number >= 1, got \"-1\""},
           {run + "--count 99999999999", "--count: expected a whole number >= 1"},
           {run + "--rate 1e-30", "--rate: expected a number from 0.001 to 1e+06"},
           {run + "--max-epipolar-error inf", "--max-epipolar-error: expected a number, got"},
           {run + "--min-distance inf", "--min-distance: expected a number, got \"inf\""},
           {run + "--marginalize 1e30", "--marginalize: expected true or false, got \"1e30\""},
           {run + "--max-keypoints 0", "--max-keypoints: expected a whole number >= 1"},
           {run + "--window 010", "--window: expected a whole number, got \"010\""},
           {run + "--window 0x10", "--window: expected a whole number, got \"0x10\""},
           {run + "--tracking-threshold 1", "--tracking-threshold: expected a number >= 0 and < 1"},
           {run + "--depth-confidence 1", "--depth-confidence: expected a number >= 0 and < 1"},
           {run + "--strict=2", "--strict: expected true or false, got \"2\""},
           {"match a.png b.png --max-error nan", "--max-error: expected a number > 0, got \"nan\""},
           {"evaluate a b --delta 0", "--delta: expected a whole number >= 1, got \"0\""},
           {"simulate -o made --seed -1", "--seed: expected a whole number >= 0, got \"-1\""},
           {"simulate -o made --noise nan", "--noise: expected a number, got \"nan\""},
           {"simulate -o made --width 1e3", "--width: expected a whole number, got \"1e3\""}}) {
    ExpectBadUsage(arguments, phrase);
  }
}

TEST_F(UsageTest, DecimalNumbersAreTaken) {
  const Outcome outcome =
      Run("simulate -o " + Path("made") +
          " --duration +0.2 --rate 10 --width 96 --height +64 --seed 18446744073709551615");
  EXPECT_EQ(outcome.exit_code, 0) << outcome.error;
  EXPECT_NE(Contents(Path("made/mav0/cam0/sensor.yaml")).find("[96, 64]"), std::string::npos);
}

TEST_F(UsageTest, WhatIsOutOfRangeIsNamedAsItIsTyped) {
  ASSERT_EQ(
      Run("simulate -o " + Path("flight") + " --duration 0.2 --rate 10 --width 96 --height 64")
          .exit_code,
      0);
  const std::string run = "run " + Path("flight") + " --method klt -o " + Path("out") + " ";
  for (const std::string option :
       {"--window 2", "--iterations 0", "--klt-corners 0", "--keyframe-parallax 0",
        "--max-epipolar-error 0", "--min-distance -1", "--recovery-keyframes -1", "--max-ratio 2",
        "--min-confirmed-share 2"}) {
    ExpectBadUsage(run + option, "(" + option.substr(0, option.find(' ')) + ")");
  }
  ExpectBadUsage(run + "--loop-interval -1 --loops on", "(--loop-interval)");
  ExpectBadUsage(run + "--loop-candidates 0", "(--loop-candidates)");
  EXPECT_EQ(Run(run + "--superpoint absent.safetensors").exit_code, 1);
  ExpectBadUsage(run + "--loops off --final-adjustment on", "expected --loops on");
  ExpectBadUsage(run + "--start 2", "(--start); expected at most 1");
  ExpectBadUsage(run + "--solver ceres --imu on", "(--solver) is \"ceres\"; expected gluevo");
  const std::string simulate = "simulate -o " + Path("other");
  for (const std::string& command :
       {simulate + " --duration 0", simulate + " --calibration-error 11", simulate + " --width 16",
        simulate + " --path rest --laps 2", std::string("bench --size 7x7")}) {
    const Outcome outcome = Run(command);
    EXPECT_EQ(outcome.exit_code, 2) << command;
    EXPECT_NE(outcome.error.find("; see gluevo "), std::string::npos) << outcome.error;
  }
}

// Before anything is looked for: no folder "data" is there.
TEST_F(UsageTest, ValuesThatDoNotGoTogetherAreNamedFirst) {
  for (const std::string command : {"run data -o out ", "live data -o out "}) {
    ExpectBadUsage(command + "--window 2", "(--window)");
    ExpectBadUsage(command + "--loop-interval -1", "(--loop-interval)");
    ExpectBadUsage(command + "--imu off --imu-rate", "--imu off uses no inertial unit");
    ExpectBadUsage(command + "--imu off --estimate-time-offset", "expected no --estimate-time");
    ExpectBadUsage(command + "--solver ceres --imu-rate", "--solver ceres uses no inertial unit");
    ExpectBadUsage(command + "--features aliked --matcher superglue", "expected lightglue or nn");
  }
  ExpectBadUsage("live data -o out --udp x", "--udp is \"x\"; expected HOST:PORT");
  ExpectBadUsage("live data -o out --view x:y", "--view is \"x:y\"; expected PORT");
  ExpectBadUsage("live data -o out --view-token a", "expected --view");
  ExpectBadUsage("live data -o out --rounds 2 --imu-rate", "--rounds goes backwards");
  ExpectBadUsage("live /dev/video0 -o out --imu on --calibration c.yaml", "expected --imu off");
  EXPECT_EQ(Run("live data -o out").exit_code, 1);
}

TEST_F(UsageTest, FilesOfOptionsAreUsageToo) {
  const auto expect_refused = [&](const std::string& text, const std::string& phrase) {
    ExpectBadUsage("run data -o out --config " + Write("o.yaml", text), phrase);
  };
  expect_refused("stride: 2\ncount: x\n", "o.yaml:2: --count: expected a whole number >= 1");
  expect_refused("counts: 3\n", "o.yaml:1: unknown option \"counts\"");
  expect_refused("count: [1, 2]\n", "o.yaml:1: expected one value of option count");
  expect_refused("window: 2\n", "(--window)");
  expect_refused("imu: off\nimu-rate: true\n", "--imu off uses no inertial unit");
  ExpectRefused("run data -o out --config " + Write("o.yaml", "- a\n"), 1, "expected a map");
}

TEST_F(UsageTest, EmptyValuesAreNoValues) {
  for (const std::string option :
       {"--cpus", "--imu", "--load-map", "--save-map", "--calibration", "--groundtruth",
        "--weights", "--map", "--replay", "--config", "-o"}) {
    ExpectBadUsage("run data " + std::string(option == "-o" ? "" : "-o out ") + option + " ''",
                   "expected a value that is not empty, got \"\"");
  }
  ExpectBadUsage("run '' -o out", "DATASET: expected a value that is not empty");
  ExpectBadUsage("live data -o out --udp ''", "--udp: expected a value that is not empty");
  ExpectBadUsage("extract images -o ''", "--output: expected a value that is not empty");
}

TEST_F(UsageTest, ResultsOfAnotherRunAreLeftToIt) {
  ASSERT_EQ(
      Run("simulate -o " + Path("flight") + " --duration 0.2 --rate 10 --width 96 --height 64")
          .exit_code,
      0);
  fs::create_directory(Path("out"));
  const int folder = open(Path("out").c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  ASSERT_GE(folder, 0);
  ASSERT_EQ(flock(folder, LOCK_EX), 0);
  ExpectRefused("run " + Path("flight") + " --method klt -o " + Path("out"), 1,
                "another program is writing its results there");
  close(folder);
}

TEST_F(UsageTest, ProcessorsAreThoseThatThereAre) {
  ASSERT_EQ(
      Run("simulate -o " + Path("flight") + " --duration 0.4 --rate 10 --width 96 --height 64")
          .exit_code,
      0);
  const std::string run = "run " + Path("flight") + " --method klt -o " + Path("out") + " --cpus ";
  for (const std::string wrong : {"x", "1-", "3-1", "0,,1", "0,"}) {
    ExpectBadUsage(run + wrong, "expected numbers of processors as in 0,2-3");
  }
  ExpectBadUsage(run + "1000", "--cpus names processor 1000; expected one that is there");
  // One processor, and so one thread.
  EXPECT_NE(Run(run + "0").error.find("frame"), std::string::npos);
  EXPECT_NE(Contents(Path("out/metrics.json")).find("\"threads\": 1"), std::string::npos);
  // More are as asked for, and TBB says nothing of it.
  const Outcome more = Run(run + "0 --threads 3");
  EXPECT_EQ(more.error.find("workers"), std::string::npos) << more.error;
  EXPECT_NE(Contents(Path("out/metrics.json")).find("\"threads\": 3"), std::string::npos);
}

TEST_F(UsageTest, NamesDoNotSteerTheTerminal) {
  const Outcome in_shell =
      RunProgram("bash", "-c \"" GLUEVO_PROGRAM " run $'no\\n\\x1b[31m\\xc2\\x9bsuch' -o out\"");
  EXPECT_EQ(in_shell.exit_code, 1);
  EXPECT_EQ(in_shell.error.rfind("gluevo: error: no\\x0a\\x1b[31m\\xc2\\x9bsuch: ", 0), 0U)
      << in_shell.error;
  EXPECT_EQ(in_shell.error.find('\n'), in_shell.error.size() - 1) << in_shell.error;
}

}  // namespace
}  // namespace gluevo::apps
