#include <algorithm>

#include "chart.h"
#include "frame_series.h"
#include "markup.h"
#include "path_views.h"
#include "sections.h"

namespace gluevo::apps {

std::string ErrorSection(const RunReport& report) {
  std::string html = "<section><h2>Error</h2>\n";
  if (!report.evaluation) {
    return html + NoGroundTruth(report) + "</section>\n";
  }
  Series se3{"SE(3)-aligned", "first", {}, {}, {}};
  Series sim3{"Sim(3)-aligned", "second", {}, {}, {}};
  Series step_m{"", "first", {}, {}, {}};
  Series step_deg{"", "first", {}, {}, {}};
  double most = 0.0;
  for (const vo::PoseError& error : report.evaluation->errors) {
    const double time = SecondsIn(report, error.timestamp_ns);
    for (Series* series : {&se3, &sim3, &step_m, &step_deg}) {
      series->x.push_back(time);
    }
    se3.y.push_back(error.se3_m);
    sim3.y.push_back(error.sim3_m);
    step_m.y.push_back(error.motion_m);
    step_deg.y.push_back(error.motion_deg);
    most = std::max({most, error.se3_m, error.sim3_m});
  }
  const auto chart = [&](const std::string& title, const std::string& y_label,
                         const std::vector<Series>& series) {
    return DrawChart({.title = title,
                      .x_label = "time, s",
                      .y_label = y_label,
                      .series = series,
                      .marks_name = "tracking lost",
                      .marks = ResetMarks(report)});
  };
  html += "<div class=\"columns\">" +
          DrawPathPicture(ErrorView(report, /*with_scale=*/false, most)) +
          DrawPathPicture(ErrorView(report, /*with_scale=*/true, most)) + "</div>" +
          ColorScale(most, "distance from the ground truth, m") + "<div class=\"columns\">" +
          chart("Position error", "error, m", {se3, sim3}) +
          chart("Error of each motion from frame to frame", "error, m", {step_m}) +
          chart("Turning error of each motion", "error, deg", {step_deg}) + "</div></section>\n";
  return html;
}

}  // namespace gluevo::apps
