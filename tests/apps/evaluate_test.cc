// gluevo evaluate as a user runs it: what it prints, where, and how it exits.

#include <gtest/gtest.h>

#include <fstream>
#include <nlohmann/json.hpp>
#include <string>

#include "apps/command_test.h"

namespace gluevo::apps {
namespace {

class EvaluateTest : public CommandTest {};

// The corners of a square of 2 m, in TUM's and in KITTI's form; the estimate is twice as large.
constexpr const char* kTruthTum =
    "1 1 1 0 0 0 0 1\n2 1 -1 0 0 0 0 1\n3 -1 -1 0 0 0 0 1\n4 -1 1 0 0 0 0 1\n";
constexpr const char* kEstimateTum =
    "# estimate\n1 2 2 0 0 0 0 1\n2 2 -2 0 0 0 0 1\n3 -2 -2 0 0 0 0 1\n4 -2 2 0 0 0 0 1\n";
constexpr const char* kTruthKitti =
    "1 0 0 1 0 1 0 1 0 0 1 0\n1 0 0 1 0 1 0 -1 0 0 1 0\n"
    "1 0 0 -1 0 1 0 -1 0 0 1 0\n1 0 0 -1 0 1 0 1 0 0 1 0\n";

TEST_F(EvaluateTest, PrintsJson) {
  const Outcome outcome =
      Run("evaluate " + Write("e.tum", kEstimateTum) + " " + Write("g.tum", kTruthTum) + " --json");
  EXPECT_EQ(outcome.exit_code, 0) << outcome.error;
  EXPECT_EQ(outcome.error, "");
  const nlohmann::json json = nlohmann::json::parse(outcome.out);
  EXPECT_EQ(json["pairs"], 4);
  EXPECT_NEAR(json["ate_se3_m"], std::sqrt(2.0), 1e-12);  // (2, 2) is sqrt(2) from (1, 1).
  EXPECT_NEAR(json["ate_sim3_m"], 0.0, 1e-12);
  EXPECT_NEAR(json["scale"], 0.5, 1e-12);
  EXPECT_EQ(json["coverage"], 1.0);
  // Of the way of 6 m: sub-paths of 1 to 5 m end after 2, 4 or 6 m (the first pose beyond), where
  // the estimate is off by as much as the truth moved: 2 m, or the diagonal, or 2 m again.
  const double diagonal = std::sqrt(8.0);
  const double sum =
      3 * 2.0 / 1.0 + 2 * diagonal / 2.0 + 2 * diagonal / 3.0 + 2.0 / 4.0 + 2.0 / 5.0;
  EXPECT_NEAR(json["rpe_translation_percent"], 100.0 * sum / 9.0, 1e-10);
  EXPECT_NEAR(json["rpe_rotation_deg_per_m"], 0.0, 1e-12);
  EXPECT_EQ(json["rpe_lengths_m"], (std::vector<double>{1.0, 2.0, 3.0, 4.0, 5.0}));
}

TEST_F(EvaluateTest, PrintsATable) {
  const Outcome outcome =
      Run("evaluate " + Write("e.tum", kEstimateTum) + " " + Write("g.tum", kTruthTum));
  EXPECT_EQ(outcome.exit_code, 0) << outcome.error;
  EXPECT_NE(outcome.out.find("1.414214 m"), std::string::npos) << outcome.out;
  EXPECT_NE(outcome.out.find("0.500000"), std::string::npos) << outcome.out;
}

TEST_F(EvaluateTest, WritesNullForWhatIsUndefined) {
  const std::string still = Write("s.tum", "1 0 0 0 0 0 0 1\n2 0 0 0 0 0 0 1\n3 0 0 0 0 0 0 1\n");
  const Outcome outcome = Run("evaluate " + still + " " + still + " --json");
  EXPECT_EQ(outcome.exit_code, 0) << outcome.error;
  const nlohmann::json json = nlohmann::json::parse(outcome.out);
  EXPECT_EQ(json["ate_se3_m"], 0.0);
  EXPECT_TRUE(json["scale"].is_null());
  EXPECT_TRUE(json["rpe_translation_percent"].is_null());
}

TEST_F(EvaluateTest, DrawsAPlot) {
  const std::string inputs = Write("e.tum", kEstimateTum) + " " + Write("g.tum", kTruthTum);
  const Outcome outcome = Run("evaluate " + inputs + " --plot " + Path("plot.svg"));
  EXPECT_EQ(outcome.exit_code, 0) << outcome.error;
  const std::string svg = Contents(Path("plot.svg"));
  EXPECT_EQ(svg.find("<svg "), 0U);
  EXPECT_EQ(svg.substr(svg.size() - 7), "</svg>\n");
  EXPECT_NE(svg.find("<polyline"), std::string::npos);
  EXPECT_EQ(Files(), 3U);

  const Outcome failed = Run("evaluate " + inputs + " --plot " + Path("missing/plot.svg"));
  EXPECT_EQ(failed.exit_code, 1);
  EXPECT_EQ(failed.out, "");
  EXPECT_NE(failed.error.find("missing/plot.svg"), std::string::npos) << failed.error;
  EXPECT_EQ(Files(), 3U);
}

TEST_F(EvaluateTest, TakesKittiFiles) {
  const std::string kitti = Write("k.txt", kTruthKitti);
  // By rows where neither has times, by the times given where one has.
  EXPECT_EQ(Run("evaluate " + kitti + " " + kitti).exit_code, 0);
  const std::string times = Write("times.txt", "1\n2\n3\n4\n");
  const Outcome outcome =
      Run("evaluate " + kitti + " " + Write("g.tum", kTruthTum) + " --json --times " + times);
  EXPECT_EQ(outcome.exit_code, 0) << outcome.error;
  EXPECT_EQ(nlohmann::json::parse(outcome.out)["pairs"], 4);

  const Outcome without_times = Run("evaluate " + kitti + " " + Path("g.tum"));
  EXPECT_EQ(without_times.exit_code, 1);
  EXPECT_NE(without_times.error.find("--times"), std::string::npos) << without_times.error;
  const Outcome shorter =
      Run("evaluate " + Write("s.txt", "1 0 0 0 0 1 0 0 0 0 1 0\n") + " " + kitti);
  EXPECT_EQ(shorter.exit_code, 1);
  EXPECT_NE(shorter.error.find("has 1 poses"), std::string::npos) << shorter.error;
}

TEST_F(EvaluateTest, BadInputIsOneLineAndExitOne) {
  const std::string good = Write("g.tum", kTruthTum);
  for (const std::string& bad :
       {Path("missing.tum"), Write("empty.tum", ""), Write("bad.tum", "1 2 3\n"),
        Write("late.tum", "91 1 1 0 0 0 0 1\n92 1 -1 0 0 0 0 1\n93 -1 -1 0 0 0 0 1\n")}) {
    const Outcome outcome = Run("evaluate " + bad + " " + good + " --json");
    EXPECT_EQ(outcome.exit_code, 1) << bad;
    EXPECT_EQ(outcome.out, "");
    EXPECT_EQ(outcome.error.find("gluevo: error: "), 0U) << outcome.error;
    EXPECT_EQ(outcome.error.find('\n'), outcome.error.size() - 1) << outcome.error;
  }
}

TEST_F(EvaluateTest, BadUsageIsExitTwo) {
  const std::string good = Write("g.tum", kTruthTum);
  EXPECT_EQ(Run("").exit_code, 2);
  EXPECT_EQ(Run("evaluate").exit_code, 2);
  EXPECT_EQ(Run("evaluate " + good).exit_code, 2);
  EXPECT_EQ(Run("evaluate " + good + " " + good + " --nonsense").exit_code, 2);
  EXPECT_EQ(Run("evaluate " + good + " " + good + " --max-time-difference -1").exit_code, 2);
  EXPECT_EQ(Run("unknown").exit_code, 2);
}

TEST_F(EvaluateTest, HelpAndVersionAreExitZero) {
  const Outcome help = Run("evaluate --help");
  EXPECT_EQ(help.exit_code, 0);
  EXPECT_NE(help.out.find("Example"), std::string::npos) << help.out;
  EXPECT_EQ(Run("--version").exit_code, 0);
}

}  // namespace
}  // namespace gluevo::apps
