#include <algorithm>
#include <cmath>

#include "gluevo/vo/core/text.h"
#include "markup.h"
#include "sections.h"

namespace gluevo::apps {
namespace {

std::string Tile(const std::string& name, const std::string& value, const std::string& unit,
                 const std::string& note, bool is_warning = false) {
  return std::string("<div class=\"tile") + (is_warning ? " warn" : "") + "\"><dt>" + name +
         "</dt><dd>" + value + (unit.empty() ? "" : "<small> " + unit + "</small>") +
         (note.empty() ? "" : "<span>" + note + "</span>") + "</dd></div>\n";
}

// Three digits that matter.
std::string Metres(double value) {
  const int decimals = value > 0.0 && std::isfinite(value)
                           ? std::clamp(2 - static_cast<int>(std::floor(std::log10(value))), 0, 4)
                           : 3;
  return Fixed(value, decimals);
}

// Long paths may wrap between their folders.
std::string BreakableAtSlashes(const std::string& path) {
  std::string html;
  for (const char c : Escape(path)) {
    html += c;
    html += c == '/' ? "<wbr>" : "";
  }
  return html;
}

std::string ErrorTiles(const vo::Evaluation& evaluation) {
  const vo::EvaluationOptions bounds;  // gluevo run evaluates with the defaults
  return Tile("ATE, SE(3)", Metres(evaluation.ate_se3_m), "m", "aligned, not scaled") +
         Tile("ATE, Sim(3)", Metres(evaluation.ate_sim3_m), "m", "aligned and scaled") +
         Tile("Scale", Fixed(evaluation.scale, 4), "", "truth over estimate") +
         Tile("RPE", Fixed(evaluation.rpe_translation_percent, 2), "%",
              Fixed(evaluation.rpe_rotation_deg_per_m, 4) + " deg/m") +
         Tile("Correct motions",
              std::to_string(evaluation.correct_motions) + "<small> of " +
                  std::to_string(evaluation.pairs - 1) + "</small>",
              "",
              "within " + Fixed(bounds.correct_motion_m, 1) + " m and " +
                  Fixed(bounds.correct_motion_deg, 0) + "\u00B0",
              evaluation.correct_motions + 1 < evaluation.pairs) +
         Tile("Coverage", Fixed(100.0 * evaluation.coverage, 1), "%", "of the truth\u2019s time");
}

}  // namespace

double SecondsIn(const RunReport& report, int64_t timestamp_ns) {
  return report.frames.empty()
             ? 0.0
             : static_cast<double>(timestamp_ns - report.frames.front().timestamp_ns) * 1e-9;
}

std::string NoGroundTruth(const RunReport& report) {
  return "<p class=\"notice\">" +
         (report.evaluation_failure.empty()
              ? std::string("No ground truth: the data set has none and <code>--groundtruth</code> "
                            "named none, so there are no errors to show.")
              : "The ground truth could not be used: " + Escape(report.evaluation_failure) + ".") +
         "</p>\n";
}

std::string VerdictSection(const RunReport& report) {
  const auto keyframes = std::count_if(report.frames.begin(), report.frames.end(),
                                       [](const auto& frame) { return frame.is_keyframe; });
  const int resets = report.frames.empty() ? 0 : report.frames.back().segment;
  const auto frames = static_cast<double>(report.frames.size());
  std::string html =
      "<header><p class=\"kind\">gluevo run</p><h1>" + BreakableAtSlashes(report.dataset) +
      "</h1><p>Method <b>" + Escape(report.method) + "</b>, " +
      std::to_string(report.frames.size()) + " stereo frames" +
      (report.frames.empty()
           ? ""
           : " over " + Fixed(SecondsIn(report, report.frames.back().timestamp_ns), 1) + " s") +
      "</p></header>\n<dl class=\"tiles\">\n";
  if (report.evaluation) {
    html += ErrorTiles(*report.evaluation);
  }
  html += Tile("Speed", Fixed(frames / std::max(report.duration_s, 1e-9), 1), "frames/s",
               vo::Counted(report.threads, "thread"));
  html += Tile("Resets", std::to_string(resets), "",
               resets == 0 ? "one segment" : std::to_string(resets + 1) + " segments, not linked",
               resets > 0);
  html += Tile("Key frames", std::to_string(keyframes), "",
               "of " + vo::Counted(report.frames.size(), "frame"));
  html += "</dl>\n";
  for (const std::string& warning : report.warnings) {
    html += "<p class=\"notice warn\">" + Escape(warning) + "</p>\n";
  }
  if (!report.stereo_calibration.empty()) {
    html += "<p class=\"notice\">" + Escape(report.stereo_calibration) + ".</p>\n";
  }
  return report.evaluation ? html : html + NoGroundTruth(report);
}

}  // namespace gluevo::apps
