// gluevo run with networks beside tracking: the same each time, and about as good.

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <string>

#include "apps/command_test.h"

namespace gluevo::apps {
namespace {

using Json = nlohmann::json;

class LateNetworksTest : public CommandTest {
 protected:
  // Of the flight by superglue with more options; the folder of its results.
  std::string Fly(const std::string& name, const std::string& options) const {
    const Outcome outcome =
        Run("run " + Path("flight") + " --imu off " + options + " -o " + Path(name));
    EXPECT_EQ(outcome.exit_code, 0) << outcome.error;
    return Path(name);
  }
  static Json MetricsOf(const std::string& results) {
    return Json::parse(Contents(results + "/metrics.json"));
  }
};

TEST_F(LateNetworksTest, LatenessIsByTheScheduleWhateverTheThreads) {
  ASSERT_EQ(Run("simulate -o " + Path("flight") +
                " --path hall_loop --duration 3 --rate 20 --width 376 --height 240")
                .exit_code,
            0);
  const Json in_line = MetricsOf(Fly("in_line", ""));
  EXPECT_EQ(in_line["networks"]["in_line"], in_line["networks"]["runs"]);
  EXPECT_EQ(in_line["options"]["superglue-lag"], "0");

  const std::string one = Fly("one", "--superglue-lag 3 --threads 1");
  for (const std::string threads : {"2", "4"}) {
    const std::string other = Fly(threads, "--superglue-lag 3 --threads " + threads);
    for (const char* const file : {"/trajectory.tum", "/keyframes.tum", "/covariance.csv"}) {
      EXPECT_EQ(Contents(one + file), Contents(other + file)) << threads << file;
    }
  }
  const Json late = MetricsOf(one);
  EXPECT_EQ(late["networks"]["lag_frames"]["median"], 3);
  EXPECT_EQ(late["networks"]["lag_frames"]["max"], 3);
  EXPECT_LT(late["networks"]["in_line"], 4);
  EXPECT_GT(late["networks"]["runs"], 8);
  EXPECT_TRUE(late["stages_ms"].contains("networks_wait"));
  EXPECT_EQ(late["resets"], 0);
  EXPECT_LE(late["ate_se3_m"].get<double>(), 1.3 * in_line["ate_se3_m"].get<double>());
  EXPECT_NE(Contents(one + "/trajectory.tum"), Contents(Path("in_line/trajectory.tum")));
}

TEST_F(LateNetworksTest, WhatIsWithoutEffectIsSaid) {
  ASSERT_EQ(
      Run("simulate -o " + Path("flight") + " --duration 0.5 --rate 10 --width 160 --height 120")
          .exit_code,
      0);
  const std::string run = "run " + Path("flight") + " -o " + Path("out") + " --loops off ";
  const auto expect_said = [&](const std::string& options, const std::string& sentence) {
    const Outcome outcome = Run(run + options);
    ASSERT_EQ(outcome.exit_code, 0) << outcome.error;
    EXPECT_NE(outcome.error.find("gluevo: warning: " + sentence + "\n"), std::string::npos)
        << outcome.error;
    EXPECT_NE(MetricsOf(Path("out"))["warnings"].dump().find(sentence), std::string::npos);
  };
  expect_said("--method klt --superglue-lag 3 --max-ratio 0.7",
              "--superglue-lag, --max-ratio: not used by --method klt");
  expect_said("--superglue-lag 7 --superglue-every 2",
              "--superglue-lag 7 is more than --superglue-every 2: the networks take up a frame "
              "when they are done with the one before, 7 frames later");
  expect_said("--stereo-threshold 0.5",
              "--stereo-threshold: used with --stereo-matching network only");
  const Outcome quiet = Run(run + "--superglue-lag 2 --save-matches " + Path("m.h5"));
  EXPECT_EQ(quiet.error.find("warning: --superglue-lag"), std::string::npos) << quiet.error;
  expect_said(
      "--superglue-lag 7 --refine none --replay " + Path("m.h5"),
      "--superglue-lag, --refine: not used by --replay, which takes the matches as they are");
}

}  // namespace
}  // namespace gluevo::apps
