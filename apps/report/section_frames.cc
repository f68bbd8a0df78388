#include <algorithm>

#include "frame_series.h"
#include "markup.h"
#include "sections.h"

namespace gluevo::apps {
namespace {

double Median(const RunReport& report, int vo::FrameResult::*count) {
  return Quantile(CountSeries(report, "", "", count).y, 0.5);
}

std::string SegmentsTable(const RunReport& report) {
  constexpr int kMostRows = 30;
  std::string html =
      "<div class=\"wide\"><table><caption>Segments: poses are linked within one only</caption>"
      "<thead><tr><th>Segment<th>Frames<th>From, s<th>To, s<th>Key frames<th>Path, m</thead>"
      "<tbody>";
  for (std::size_t begin = 0; begin < report.frames.size();) {
    std::size_t end = begin;
    int keyframes = 0;
    double path_m = 0.0;
    while (end < report.frames.size() &&
           report.frames[end].segment == report.frames[begin].segment) {
      keyframes += report.frames[end].is_keyframe ? 1 : 0;
      if (end > begin) {
        path_m += (report.frames[end].world_from_body.translation -
                   report.frames[end - 1].world_from_body.translation)
                      .norm();
      }
      ++end;
    }
    const int segment = report.frames[begin].segment;
    if (segment == kMostRows) {
      html += "<tr><td colspan=\"6\">and " +
              std::to_string(report.frames.back().segment - kMostRows + 1) +
              " more: see metrics.json";
      break;
    }
    html += "<tr><td>" + std::to_string(segment) + "<td>" + std::to_string(begin) + " to " +
            std::to_string(end - 1) + "<td>" +
            Fixed(SecondsIn(report, report.frames[begin].timestamp_ns), 1) + "<td>" +
            Fixed(SecondsIn(report, report.frames[end - 1].timestamp_ns), 1) + "<td>" +
            std::to_string(keyframes) + "<td>" + Fixed(path_m, 2);
    begin = end;
  }
  return html + "</tbody></table></div>\n";
}

}  // namespace

std::string MatchesSection(const RunReport& report) {
  const Chart matches{
      .title = "Matches a frame",
      .x_label = "time, s",
      .y_label = "points",
      .series = {CountSeries(report, "stereo", "third", &vo::FrameResult::stereo),
                 CountSeries(report, "tracked", "second", &vo::FrameResult::tracked),
                 CountSeries(report, "inliers of the pose", "first", &vo::FrameResult::inliers)},
      .marks_name = "tracking lost",
      .marks = ResetMarks(report),
      .ticks_name = "key frames",
      .axis_ticks = KeyframeTimes(report)};
  const Chart landmarks{.title = "Points in the window",
                        .x_label = "time, s",
                        .y_label = "points",
                        .series = {CountSeries(report, "tracks of the frame", "second",
                                               &vo::FrameResult::observations),
                                   CountSeries(report, "landmarks with a depth", "first",
                                               &vo::FrameResult::landmarks)},
                        .marks_name = "tracking lost",
                        .marks = ResetMarks(report),
                        .ticks_name = "",
                        .axis_ticks = {}};
  return "<section><h2>Matches, key frames, segments</h2>\n<p>Median of a frame: " +
         Fixed(Median(report, &vo::FrameResult::tracked), 0) +
         " points tracked from frames before, " +
         Fixed(Median(report, &vo::FrameResult::stereo), 0) + " matched from left to right, " +
         Fixed(Median(report, &vo::FrameResult::inliers), 0) +
         " agree with the pose.</p>\n<div class=\"columns\">" + DrawChart(matches) +
         DrawChart(landmarks) + "</div>\n" + SegmentsTable(report) + "</section>\n";
}

std::string TimesSection(const RunReport& report) {
  std::vector<std::pair<std::string, std::vector<double>>> stages(report.stages_ms.begin(),
                                                                  report.stages_ms.end());
  // In the order of the work; what is not known by name comes before the sums.
  const auto rank = [](const std::string& name) {
    const std::vector<std::string> order = {"read", "superpoint", "aliked", "match_track",
                                            "match_stereo"};
    const auto found = std::find(order.begin(), order.end(), name);
    return name == "frontend"    ? 10
           : name == "estimator" ? 11
           : name == "total"     ? 12
                                 : static_cast<int>(found - order.begin());
  };
  std::stable_sort(stages.begin(), stages.end(),
                   [&](const auto& a, const auto& b) { return rank(a.first) < rank(b.first); });
  double most = 1e-9;
  for (const auto& [name, times] : stages) {
    most = std::max(most, Quantile(times, 0.95));
  }
  std::string html =
      "<section><h2>Time</h2>\n<div class=\"columns\"><div class=\"wide\"><table><caption>"
      "Milliseconds a frame: median, and the time that 95 of 100 frames stay below</caption>"
      "<thead><tr><th>Stage<th>Median<th>95 %<th class=\"bar\"></thead><tbody>";
  for (const auto& [name, times] : stages) {
    const double median = Quantile(times, 0.5);
    const double p95 = Quantile(times, 0.95);
    html += "<tr><td>" + Escape(name) + "<td>" + Fixed(median, 1) + "<td>" + Fixed(p95, 1) +
            "<td class=\"bar\"><svg viewBox=\"0 0 100 10\" preserveAspectRatio=\"none\" "
            "aria-hidden=\"true\"><rect class=\"p95\" width=\"" +
            Coordinate(100.0 * p95 / most) + "\" height=\"10\"/><rect class=\"median\" width=\"" +
            Coordinate(100.0 * median / most) + "\" height=\"10\"/></svg>";
  }
  html +=
      "</tbody></table><p>\u201Cfrontend\u201D contains the stages of its own that stand above it, "
      "\u201Ctotal\u201D everything.</p></div>";
  const Chart chart{.title = "Time a frame",
                    .x_label = "time in the sequence, s",
                    .y_label = "ms",
                    .series = {StageSeries(report, "total", "first", "total"),
                               StageSeries(report, "front end", "second", "frontend"),
                               StageSeries(report, "estimator", "third", "estimator")},
                    .marks_name = "tracking lost",
                    .marks = ResetMarks(report),
                    .ticks_name = "",
                    .axis_ticks = {}};
  return html + DrawChart(chart) + "</div></section>\n";
}

std::string StripSection(const RunReport& report) {
  if (report.strip.empty()) {
    return "";
  }
  return "<section><h2>Frames</h2>\n<p>Lines in the left image lead from a track\u2019s place in "
         "the frame before to its present one (dot); pale dots were not in the frame before. "
         "Lines in the right image lead from the place in the left image to the match.</p>\n" +
         DrawStrip(report.strip, report.frames.empty() ? 0 : report.frames.front().timestamp_ns) +
         "</section>\n";
}

}  // namespace gluevo::apps
