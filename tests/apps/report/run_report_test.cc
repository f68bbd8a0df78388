#include "run_report.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <numbers>

#include "apps/report/html_check.h"
#include "gluevo/nn/error.h"
#include "temporary_folder.h"

namespace gluevo::apps {
namespace {

namespace fs = std::filesystem;

// A flight in a circle with ground truth, the estimate 2 % too long.
RunReport Circle(int frames, int reset_at) {
  RunReport report;
  report.dataset = "data/circle";
  report.method = "superglue";
  report.rig.body_from_cam[0].rotation =
      Eigen::Quaterniond(Eigen::AngleAxisd(-0.5 * std::numbers::pi, Eigen::Vector3d::UnitX()));
  vo::Trajectory truth;
  vo::Trajectory estimate;
  for (int i = 0; i < frames; ++i) {
    const double angle = 2.0 * std::numbers::pi * i / frames;
    vo::FrameResult frame;
    frame.timestamp_ns = i * 100'000'000LL;
    const Eigen::Vector3d place(5.0 * std::cos(angle), 3.0 * std::sin(angle), 0.1 * angle);
    frame.world_from_body.translation = 1.02 * place;
    frame.is_keyframe = i % 3 == 0;
    frame.segment = i >= reset_at ? 1 : 0;
    frame.tracked = 100 + i % 7;
    frame.inliers = 90 + i % 5;
    frame.stereo = 150;
    frame.observations = 200;
    report.frames.push_back(frame);
    truth.push_back({frame.timestamp_ns, {Eigen::Quaterniond::Identity(), place}});
    estimate.push_back({frame.timestamp_ns, frame.world_from_body});
    for (const char* const stage : {"read", "frontend", "estimator", "total"}) {
      report.stages_ms[stage].push_back(3.0 + i % 4);
    }
  }
  report.groundtruth = truth;
  report.evaluation = vo::Evaluate(estimate, truth, {});
  report.duration_s = 2.0;
  report.options = {{"method", "superglue"}};
  report.weights = {{"SuperPoint", "built in", std::string(64, 'a')}};
  report.processor = "A processor";
  return report;
}

class RunReportTest : public ::testing::Test {
 protected:
  std::string Write(const RunReport& report) const {
    const fs::path path = folder_.path() / "report.html";
    WriteRunReport(path, report);
    std::ifstream stream(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(stream), {}};
  }
  TemporaryFolder folder_;
};

std::size_t Count(const std::string& text, const std::string& part) {
  std::size_t count = 0;
  for (std::size_t at = text.find(part); at != std::string::npos; at = text.find(part, at + 1)) {
    ++count;
  }
  return count;
}

TEST_F(RunReportTest, ShowsEveryPart) {
  const std::string html = Write(Circle(60, 1000));
  ExpectSelfContained(html);
  for (const char* const part :
       {"From above", "From the side", "SE(3)-aligned", "Sim(3)-aligned", "Position error",
        "Along the path", "Matches a frame", "key frames", "Segments", "Time a frame", "Options",
        "Weights", "A processor", "built in"}) {
    EXPECT_NE(html.find(part), std::string::npos) << part;
  }
  EXPECT_EQ(html.find("No ground truth"), std::string::npos);
  EXPECT_NE(html.find("0.9804"), std::string::npos) << "the scale";
  EXPECT_EQ(html.find("nan"), std::string::npos);
}

TEST_F(RunReportTest, SaysWhereGroundTruthIsMissing) {
  RunReport report = Circle(60, 1000);
  report.groundtruth.reset();
  report.evaluation.reset();
  const std::string html = Write(report);
  ExpectSelfContained(html);
  EXPECT_EQ(Count(html, "No ground truth"), 2U) << "above, and where the errors would be";
  EXPECT_NE(html.find("From above"), std::string::npos);
  report.evaluation_failure = "only 2 poses <b>";
  EXPECT_NE(Write(report).find("only 2 poses &lt;b&gt;"), std::string::npos);
}

TEST_F(RunReportTest, ShowsWhereTrackingWasLost) {
  const std::string whole = Write(Circle(60, 1000));
  const std::string broken = Write(Circle(60, 25));
  EXPECT_EQ(whole.find("tracking lost at"), std::string::npos);
  EXPECT_NE(broken.find("tracking lost at frame 25, 2.5 s"), std::string::npos);
  EXPECT_NE(broken.find("2 segments, not linked"), std::string::npos);
  // One polyline more in each of the four pictures and no line over the break.
  EXPECT_EQ(Count(broken, "class=\"path estimate\" points"),
            Count(whole, "class=\"path estimate\" points") + 4);
}

TEST_F(RunReportTest, EscapesWhatComesFromOutside) {
  RunReport report = Circle(10, 1000);
  const std::string evil = "\"><script>alert(1)</script><img src='http://x.invalid/'>";
  report.dataset = evil;
  report.method = evil;
  report.options = {{evil, evil}};
  report.weights = {{evil, evil, evil}};
  report.processor = evil;
  report.warnings = {evil};
  report.isa = evil;
  report.version = evil;
  report.stages_ms[evil] = {1.0};
  const std::string html = Write(report);
  EXPECT_EQ(html.find("<script"), std::string::npos);
  EXPECT_EQ(html.find("<img"), std::string::npos);
  ExpectSelfContained(html);
}

TEST_F(RunReportTest, StaysSmallForLongRuns) {
  const std::string html = Write(Circle(20000, 7000));
  EXPECT_LT(html.size(), 600'000U);
}

// A path whose error jitters from frame to frame changes its colour all the time.
TEST_F(RunReportTest, StaysSmallForLongJitteryRuns) {
  RunReport report = Circle(20'000, 12'000);
  vo::Trajectory estimate;
  for (std::size_t i = 0; i < report.frames.size(); ++i) {
    vo::FrameResult& frame = report.frames[i];
    frame.world_from_body.translation.x() += i % 2 == 0 ? 0.0 : 0.015;
    estimate.push_back({frame.timestamp_ns, frame.world_from_body});
  }
  report.evaluation = vo::Evaluate(estimate, *report.groundtruth, {});
  EXPECT_LT(Write(report).size(), 900'000U);
}

TEST_F(RunReportTest, HoldsForRunsWithNextToNothing) {
  for (const int frames : {3, 4}) {
    ExpectSelfContained(Write(Circle(frames, 1)));
  }
  RunReport still = Circle(12, 1000);
  vo::Trajectory estimate;
  for (vo::FrameResult& frame : still.frames) {
    frame.world_from_body = {};
    estimate.push_back({frame.timestamp_ns, {}});
  }
  still.evaluation = vo::Evaluate(estimate, *still.groundtruth, {});
  EXPECT_EQ(Write(still).find("nan"), std::string::npos);
  RunReport empty;
  EXPECT_EQ(Write(empty).find("nan"), std::string::npos);
}

TEST_F(RunReportTest, LeavesNothingWhereItCannotBeWritten) {
  EXPECT_THROW(WriteRunReport(folder_.path() / "absent" / "report.html", Circle(10, 1000)), Error);
  EXPECT_TRUE(fs::is_empty(folder_.path()));
}

TEST_F(RunReportTest, LoopsAreShownBeforeAndAfterWithWhatWasRejected) {
  RunReport report = Circle(40, 100);
  EXPECT_EQ(Write(report).find("<h2>Loops"), std::string::npos);
  report.loops.emplace();
  EXPECT_NE(Write(report).find("0 closed of 0"), std::string::npos);
  for (const vo::FrameResult& frame : report.frames) {
    report.loops->optimized.push_back({frame.timestamp_ns, frame.world_from_body});
  }
  report.loops->attempts = {
      {.query_ns = 3'900'000'000,
       .candidate_ns = 0,
       .matches = 80,
       .inliers = 61,
       .is_closed = true},
      {.query_ns = 3'800'000'000, .candidate_ns = 0, .matches = 12, .reason = "12 <matches>"},
      {.query_ns = 3'700'000'000, .candidate_ns = 5, .is_of_loaded_map = true, .is_closed = true}};
  const std::string html = Write(report);
  ExpectSelfContained(html);
  for (const char* const part :
       {"2 closed of 3", "Before", "After", "12 &lt;matches&gt;", "the map"}) {
    EXPECT_NE(html.find(part), std::string::npos) << part;
  }
  // One line in each picture: places of a loaded map are none of the run's.
  std::size_t lines = 0;
  for (std::size_t at = html.find("path loop"); at != std::string::npos;
       at = html.find("path loop", at + 1)) {
    ++lines;
  }
  EXPECT_EQ(lines, 2U);
}

}  // namespace
}  // namespace gluevo::apps
