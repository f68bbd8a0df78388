// gluevo evaluate as a user runs it: what it prints, where, and how it exits.

#include <gtest/gtest.h>
#include <sys/stat.h>

#include <cmath>
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

// Two legs of 3 s and 4 m along x and y with a break between them, after which the estimate stands
// in a world of its own.
class SegmentsTest : public EvaluateTest {
 protected:
  void SetUp() override {
    for (int i = 0; i < 4; ++i) {
      truth_ += std::to_string(i) + " " + std::to_string(i) + " 0 0 0 0 0 1\n";
      estimate_ += std::to_string(i) + " " + std::to_string(i) + " 0.01 0 0 0 0 1\n";
    }
    for (int i = 0; i < 4; ++i) {
      truth_ += std::to_string(i + 4) + " 4 " + std::to_string(i) + " 0 0 0 0 1\n";
      // Its second motion is too long by a metre.
      const double y = i < 2 ? i : i + 1;
      estimate_ += std::to_string(i + 4) + " 90 " + std::to_string(y) + " 7 0 0 0 1\n";
    }
    groundtruth_file_ = Write("g.tum", truth_);
  }
  static std::string Metrics(const std::string& second) {
    return "{\"segments\": [{\"first_frame\": 0, \"last_frame\": 3, \"start_s\": 0.0, \"end_s\": "
           "3.0}, " +
           second + "]}";
  }
  const std::string whole_ =
      Metrics("{\"first_frame\": 4, \"last_frame\": 7, \"start_s\": 4.0, \"end_s\": 7.0}");
  std::string truth_;
  std::string estimate_;
  std::string groundtruth_file_;
};

TEST_F(SegmentsTest, AreEvaluatedEachOnItsOwn) {
  const std::string estimate = Write("e.tum", estimate_);
  const std::string inputs = "evaluate " + estimate + " " + groundtruth_file_;
  EXPECT_FALSE(nlohmann::json::parse(Run(inputs + " --json").out).contains("within_segments"));

  const std::string named = " --segments " + Write("named.json", whole_);
  const nlohmann::json json = nlohmann::json::parse(Run(inputs + named + " --json").out);
  EXPECT_GT(json["ate_se3_m"], 10.0);
  const nlohmann::json& within = json["within_segments"];
  EXPECT_EQ(within["motions"], 6);
  EXPECT_EQ(within["correct_motions"], 5);
  EXPECT_EQ(within["breaks"], 1);
  EXPECT_EQ(within["pairs"], 8);
  ASSERT_EQ(within["segments"].size(), 2U);
  EXPECT_NEAR(within["segments"][0]["ate_se3_m"], 0.0, 1e-12);
  // 0, 1, 3, 4 against 0, 1, 2, 3: off by 1/2 each about the means.
  EXPECT_NEAR(within["segments"][1]["ate_se3_m"], 0.5, 1e-12);
  EXPECT_NEAR(within["ate_se3_m"], std::sqrt(0.5 * 0.25), 1e-12);

  // The metrics.json beside the estimate.
  Write("metrics.json", whole_);
  EXPECT_EQ(nlohmann::json::parse(Run(inputs + " --json").out), json);
  const Outcome table = Run(inputs + " --plot " + Path("plot.svg"));
  EXPECT_NE(table.out.find("ATE within segments         0.353553 m, over 8 poses"),
            std::string::npos)
      << table.out;
  EXPECT_NE(table.out.find("2, 1 declared break"), std::string::npos) << table.out;
  EXPECT_NE(Contents(Path("plot.svg")).find("ATE within segments 0.3536 m"), std::string::npos);

  // Key frames only: the segments of their times.
  const std::string keyframes =
      Write("keyframes.tum", estimate_.substr(0, estimate_.rfind('\n', estimate_.size() - 2) + 1));
  const nlohmann::json of_keyframes =
      nlohmann::json::parse(Run("evaluate " + keyframes + " " + groundtruth_file_ + " --json").out);
  EXPECT_EQ(of_keyframes["within_segments"]["segments"][1]["pairs"], 3);
}

TEST_F(SegmentsTest, OfAnotherRunAreRefusedOrLeftAlone) {
  const std::string inputs =
      "evaluate " + Write("e.tum", estimate_) + " " + groundtruth_file_ + " --json";
  const std::string other =
      Metrics("{\"first_frame\": 5, \"last_frame\": 6, \"start_s\": 5.0, \"end_s\": 6.0}");
  for (const std::string& text : {std::string("{"), std::string("{}"), other}) {
    const Outcome named = Run(inputs + " --segments " + Write("named.json", text));
    EXPECT_EQ(named.exit_code, 1);
    EXPECT_EQ(named.out, "");
    EXPECT_NE(named.error.find("named.json"), std::string::npos) << named.error;
    Write("metrics.json", text);
    const Outcome beside = Run(inputs);
    EXPECT_EQ(beside.exit_code, 0);
    EXPECT_NE(beside.error.find("metrics.json"), std::string::npos) << beside.error;
    EXPECT_FALSE(nlohmann::json::parse(beside.out).contains("within_segments"));
  }
  EXPECT_EQ(Run(inputs + " --segments " + Path("none.json")).exit_code, 1);
}

TEST_F(EvaluateTest, SaysHowItReadTheFiles) {
  const std::string truth = Write("g.tum", kTruthTum);
  const std::string estimate =
      Write("e.csv",
            "time [ms],x,y,z,qx,qy,qz,qw\n1000,1,1,0,0,0,0,1\n2000,1,-1,0,0,0,0,1\n"
            "3000,-1,-1,0,0,0,0,1\n3500,nan,nan,nan,0,0,0,1\n4000,-1,1,0,0,0,0,1\n");
  const Outcome outcome = Run("evaluate " + estimate + " " + truth + " --json");
  EXPECT_EQ(outcome.exit_code, 0) << outcome.error;
  const nlohmann::json json = nlohmann::json::parse(outcome.out);
  EXPECT_EQ(json["pairs"], 4);
  EXPECT_EQ(json["estimate_poses"], 4);
  EXPECT_NEAR(json["ate_se3_m"], 0.0, 1e-12);
  ASSERT_EQ(json["warnings"].size(), 1U);
  EXPECT_EQ(outcome.error, "gluevo: note: " + json["warnings"][0].get<std::string>() + "\n");
  EXPECT_NE(outcome.error.find("e.csv: 1 row (first in line 5)"), std::string::npos);
}

TEST_F(EvaluateTest, SaysThatFewPosesHaveAMate) {
  std::string estimate;
  std::string truth;
  for (int i = 0; i < 12; ++i) {
    const std::string pose = " " + std::to_string(i * i) + " " + std::to_string(i) + " 0 0 0 0 1\n";
    truth += std::to_string(i) + pose;
    estimate += std::to_string(i) + (i < 3 ? "" : ".5") + pose;
  }
  const Outcome outcome = Run("evaluate " + Write("e.tum", estimate) + " " + Write("g.tum", truth));
  EXPECT_EQ(outcome.exit_code, 0) << outcome.error;
  EXPECT_NE(outcome.out.find("3 of 12"), std::string::npos) << outcome.out;
  EXPECT_NE(outcome.error.find("warning: only 3 of 12 poses"), std::string::npos) << outcome.error;
}

TEST_F(EvaluateTest, PrintsATable) {
  const Outcome outcome =
      Run("evaluate " + Write("e.tum", kEstimateTum) + " " + Write("g.tum", kTruthTum));
  EXPECT_EQ(outcome.exit_code, 0) << outcome.error;
  EXPECT_NE(outcome.out.find("1.414214 m"), std::string::npos) << outcome.out;
  EXPECT_NE(outcome.out.find("0.500000"), std::string::npos) << outcome.out;
  // Of steps of 2 m the estimate makes 4.
  EXPECT_NE(outcome.out.find("RPE over 1 frame            2.000000 m, 0.000000 deg; median 2."),
            std::string::npos)
      << outcome.out;
  EXPECT_NE(outcome.out.find("RPE, lengths                1, 2, 3"), std::string::npos)
      << outcome.out;
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

TEST_F(EvaluateTest, SaysWhyAFigureIsUndefined) {
  const std::string still = Write("s.tum", "1 0 0 0 0 0 0 1\n2 0 0 0 0 0 0 1\n3 0 0 0 0 0 0 1\n");
  const Outcome outcome = Run("evaluate " + still + " " + still + " --delta 9");
  EXPECT_EQ(outcome.exit_code, 0) << outcome.error;
  EXPECT_EQ(outcome.out.find("nan"), std::string::npos) << outcome.out;
  for (const char* const why :
       {"ground truth does not move", "one of both does not move", "fewer poses"}) {
    EXPECT_NE(outcome.out.find(why), std::string::npos) << why << '\n' << outcome.out;
  }
}

TEST_F(EvaluateTest, SaysThatThePathIsShorterThanTheLengths) {
  const Outcome outcome = Run("evaluate " + Write("e.tum", kEstimateTum) + " " +
                              Write("g.tum", kTruthTum) + " --rpe-lengths 2000,1000");
  EXPECT_EQ(outcome.exit_code, 0) << outcome.error;
  EXPECT_NE(outcome.out.find(" m is too short, expected more than 1000 m"), std::string::npos)
      << outcome.out;
  EXPECT_EQ(outcome.out.find("does not move"), std::string::npos) << outcome.out;
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
  EXPECT_NE(shorter.error.find("has 1 pose "), std::string::npos) << shorter.error;
}

TEST_F(EvaluateTest, ReadsPipesOnce) {
  const std::string truth = Write("g.tum", kTruthTum);
  const std::string estimate = Write("e.tum", kEstimateTum);
  const std::string pipe = Path("pipe");
  ASSERT_EQ(mkfifo(pipe.c_str(), 0600), 0);
  // A second look at the pipe would find nobody who writes, and wait for ever.
  const Outcome outcome =
      RunProgram("cat " + estimate + " >" + pipe + " & timeout 60 " + std::string(GLUEVO_PROGRAM),
                 "evaluate " + pipe + " " + truth + " --json");
  EXPECT_EQ(outcome.exit_code, 0) << outcome.error;
  EXPECT_EQ(nlohmann::json::parse(outcome.out)["pairs"], 4);
}

TEST_F(EvaluateTest, NumbersOfFramesGoBeforeRows) {
  const std::string rows[] = {"1 0 0 1 0 1 0 1 0 0 1 0\n", "1 0 0 1 0 1 0 -1 0 0 1 0\n",
                              "1 0 0 -1 0 1 0 -1 0 0 1 0\n", "1 0 0 -1 0 1 0 1 0 0 1 0\n"};
  std::string last_three;
  for (int i = 1; i < 4; ++i) {
    last_three += std::to_string(5 + i);
    last_three += " ";
    last_three += rows[i];
  }
  std::string four = "5 ";
  four += rows[0];
  four += last_three;
  const std::string all = Write("all.txt", four);
  const std::string fewer = Write("fewer.txt", last_three);
  const Outcome outcome = Run("evaluate " + fewer + " " + all + " --json");
  ASSERT_EQ(outcome.exit_code, 0) << outcome.error;
  EXPECT_EQ(nlohmann::json::parse(outcome.out)["pairs"], 3);
  EXPECT_NEAR(nlohmann::json::parse(outcome.out)["ate_se3_m"], 0.0, 1e-12);

  // As many rows, but whether they are of the same frames nothing tells.
  const std::string plain = Write("plain.txt", kTruthKitti);
  for (const auto& [first, second] : {std::pair(all, plain), std::pair(plain, all)}) {
    const Outcome mixed = Run("evaluate " + first + " " + second);
    EXPECT_EQ(mixed.exit_code, 1);
    EXPECT_NE(mixed.error.find("all.txt has the numbers of its frames"), std::string::npos)
        << mixed.error;
    EXPECT_NE(mixed.error.find("plain.txt has none"), std::string::npos) << mixed.error;
  }
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
  EXPECT_EQ(Run("evaluate " + good + " " + good + " --delta 0").exit_code, 2);
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
