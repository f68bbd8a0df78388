#include <algorithm>
#include <cmath>
#include <utility>

#include "chart.h"
#include "frame_series.h"
#include "markup.h"
#include "path_views.h"
#include "sections.h"

namespace gluevo::apps {
namespace {

std::string StatisticsTable(
    const std::vector<std::pair<std::string, std::vector<double>>>& all_errors) {
  std::string html =
      "<div class=\"wide\"><table><caption>Motions lead from one pose with ground truth to the "
      "next; those over a declared break are left out.</caption><thead><tr><th>Error<th>Median"
      "<th>RMSE<th>95 %<th>Most</thead><tbody>";
  for (const auto& [name, with_gaps] : all_errors) {
    std::vector<double> errors;
    double sum = 0.0;
    for (const double error : with_gaps) {
      if (std::isfinite(error)) {
        errors.push_back(error);
        sum += error * error;
      }
    }
    const double rmse = std::sqrt(sum / static_cast<double>(errors.size()));
    html += "<tr><td>" + name + "<td>" + Fixed(Quantile(errors, 0.5), 4) + "<td>" + Fixed(rmse, 4) +
            "<td>" + Fixed(Quantile(errors, 0.95), 4) + "<td>" + Fixed(Quantile(errors, 1.0), 4);
  }
  return html + "</tbody></table></div>";
}

}  // namespace

std::string ErrorSection(const RunReport& report) {
  std::string html = "<section><h2>Error</h2>\n";
  const auto chart = [&](const std::string& title, const std::string& y_label,
                         const std::vector<Series>& series) {
    return DrawChart({.title = title,
                      .x_label = "time, s",
                      .y_label = y_label,
                      .series = series,
                      .marks_name = "tracking lost",
                      .marks = ResetMarks(report)});
  };
  const Series sigma = PositionSigmaSeries(report, "third");
  if (!report.evaluation) {
    return html + NoGroundTruth(report) + "<div class=\"columns\">" +
           chart("How far off positions may be", "1 sigma, m", {sigma}) + "</div></section>\n";
  }
  Series se3{"SE(3)-aligned", "first", {}, {}, {}};
  Series sim3{"Sim(3)-aligned", "second", {}, {}, {}};
  Series step_m{"", "first", {}, {}, {}};
  Series step_deg{"", "first", {}, {}, {}};
  const std::vector<std::size_t> breaks = ErrorBreaks(report);
  double most = 0.0;
  for (const vo::PoseError& error : report.evaluation->errors) {
    const double time = SecondsIn(report, error.timestamp_ns);
    for (Series* series : {&se3, &sim3, &step_m, &step_deg}) {
      series->x.push_back(time);
    }
    se3.y.push_back(error.se3_m);
    sim3.y.push_back(error.sim3_m);
    // The first pose has no motion before it, and a declared break is none.
    const bool is_motion =
        se3.y.size() > 1 && !std::binary_search(breaks.begin(), breaks.end(), se3.y.size() - 1);
    step_m.y.push_back(is_motion ? error.motion_m : NAN);
    step_deg.y.push_back(is_motion ? error.motion_deg : NAN);
    most = std::max({most, error.se3_m, error.sim3_m});
  }
  html += "<div class=\"columns\">" +
          DrawPathPicture(ErrorView(report, /*with_scale=*/false, most)) +
          DrawPathPicture(ErrorView(report, /*with_scale=*/true, most)) + "</div>" +
          ColorScale(most, "distance from the ground truth", "m") + "<div class=\"columns\">" +
          chart("Position error, and how large it may be by the estimate", "error, m",
                {se3, sim3, sigma}) +
          chart("Error of each motion from frame to frame", "error, m", {step_m}) +
          chart("Turning error of each motion", "error, deg", {step_deg}) +
          StatisticsTable({{"position, SE(3)-aligned, m", se3.y},
                           {"position, Sim(3)-aligned, m", sim3.y},
                           {"motion, m", step_m.y},
                           {"motion, deg", step_deg.y}}) +
          "</div></section>\n";
  return html;
}

}  // namespace gluevo::apps
