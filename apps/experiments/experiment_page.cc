#include "experiment_page.h"

#include <iomanip>
#include <optional>
#include <sstream>

#include "gluevo/nn/error.h"
#include "gluevo/vo/evaluation/segment_evaluation.h"
#include "gluevo/vo/io/trajectory_file.h"
#include "markup.h"
#include "run_stamp.h"
#include "segments_file.h"
#include "style.h"
#include "trajectory_lines.h"

namespace gluevo::apps {
namespace {

namespace fs = std::filesystem;

// What the style sheet of a run's report does not have.
constexpr const char* kMoreStyle = R"css(
main{max-width:1400px}
table{white-space:nowrap}
th:nth-child(2),td:nth-child(2){text-align:left}
ul{color:var(--muted);padding-left:1.2rem;overflow-wrap:anywhere}
.cards{display:grid;gap:12px;grid-template-columns:repeat(auto-fill,minmax(170px,1fr))}
.card{background:var(--card);border-radius:8px;padding:10px;font-size:.9rem;color:inherit;
text-decoration:none;overflow-wrap:anywhere}
.card span{color:var(--muted);display:block}
)css";

// A run's trajectory, over ground truth where there is any. Nothing where it cannot be read.
std::optional<TrajectoryLines> ReadLines(const RunOutcome& outcome, const fs::path& folder) {
  try {
    const vo::Trajectory estimate = vo::ReadTrajectory(folder / "trajectory.tum");
    const std::vector<int> segments = ReadSegments(folder / "metrics.json", estimate);
    const vo::Dataset dataset = OpenDatasetOf(outcome.run);
    if (!dataset.groundtruth || !outcome.metrics.contains("ate_se3_m")) {
      TrajectoryLines lines;
      lines.estimate.emplace_back();
      for (const vo::StampedPose& pose : estimate) {
        lines.estimate.back().push_back(pose.world_from_body.translation);
      }
      return lines;
    }
    return AlignSegments(estimate, segments, *dataset.groundtruth,
                         vo::EvaluateSegments(estimate, segments, *dataset.groundtruth, {}));
  } catch (const Error&) {
    return std::nullopt;
  }
}

std::string Picture(const TrajectoryLines& lines) {
  constexpr double kSize = 200.0;
  constexpr double kMargin = 8.0;
  constexpr double kLeastStep = 0.7;  // Pixels; nobody sees less.
  const PlanView view = ChooseView(lines);
  const double scale = (kSize - 2.0 * kMargin) / view.Extent();
  const Eigen::Vector3d center = view.box.isEmpty() ? Eigen::Vector3d(0, 0, 0) : view.box.center();
  std::ostringstream svg;
  svg << std::fixed << std::setprecision(1) << "<svg viewBox=\"0 0 " << kSize << ' ' << kSize
      << "\" role=\"img\" aria-label=\"trajectory\">";
  const auto place = [&](const Eigen::Vector3d& point) -> Eigen::Vector2d {
    return {kSize / 2.0 + scale * (point[view.across] - center[view.across]),
            kSize / 2.0 - scale * (point[view.up] - center[view.up])};
  };
  const auto draw = [&](const std::vector<Eigen::Vector3d>& line, const char* name) {
    svg << "<polyline class=\"" << name << "\" points=\"";
    std::optional<Eigen::Vector2d> last;
    for (std::size_t i = 0; i < line.size(); ++i) {
      const Eigen::Vector2d point = place(line[i]);
      if (!last || (point - *last).norm() >= kLeastStep || i + 1 == line.size()) {
        svg << point.x() << ',' << point.y() << ' ';
        last = point;
      }
    }
    svg << "\"/>";
  };
  draw(lines.groundtruth, "truth");
  for (const std::vector<Eigen::Vector3d>& line : lines.estimate) {
    draw(line, "estimate");
  }
  if (!lines.estimate.empty() && !lines.estimate.front().empty()) {
    const Eigen::Vector2d start = place(lines.estimate.front().front());
    svg << "<circle class=\"start\" cx=\"" << start.x() << "\" cy=\"" << start.y()
        << "\" r=\"3\"/>";
  }
  svg << "</svg>";
  return svg.str();
}

// Of a run below the experiment's folder, as an address relative to the page.
std::string Address(const fs::path& path) {
  std::ostringstream address;
  for (const char c : path.generic_string()) {
    if (c == '%' || c == '#' || c == '?' || c == '"') {
      address << '%' << std::hex << std::uppercase << static_cast<int>(c) << std::dec;
    } else {
      address << c;
    }
  }
  return address.str();
}

void AddCard(const RunOutcome& outcome, const fs::path& output, std::ostream& page) {
  const fs::path& folder = outcome.run.folder;
  const bool has_report = fs::exists(output / folder / "report.html");
  const bool has_log = fs::exists(output / folder / kRunLog);
  std::string name = outcome.run.method;
  for (const auto& [option, value] : outcome.run.swept) {
    name.append(", ").append(option).append(" ").append(value);
  }
  if (has_report || has_log) {
    page << "<a class=\"card\" href=\"" << Address(folder / (has_report ? "report.html" : kRunLog))
         << "\">";
  } else {
    page << "<div class=\"card\">";
  }
  if (outcome.HasResult()) {
    if (const auto lines = ReadLines(outcome, output / folder)) {
      page << Picture(*lines);
    }
  }
  page << Escape(name) << "<span>";
  if (!outcome.HasResult()) {
    page << Escape(outcome.reason);
  } else if (outcome.metrics.contains("ate_se3_m") && outcome.metrics["ate_se3_m"].is_number()) {
    page << std::fixed << std::setprecision(4) << "ATE "
         << outcome.metrics["ate_se3_m"].get<double>() << " m";
  }
  page << "</span>" << (has_report || has_log ? "</a>\n" : "</div>\n");
}

}  // namespace

std::string ExperimentPage(const std::string& title, const ExperimentTable& table,
                           const std::vector<RunOutcome>& outcomes, const fs::path& output) {
  const std::string name = Escape(title.empty() ? "gluevo experiment" : title);
  std::ostringstream page;
  page << "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n"
       << "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n"
       // An empty icon, for which a browser would ask otherwise.
       << "<link rel=\"icon\" href=\"data:,\">\n<title>" << name << "</title>\n<style>" << kStyle
       << kMoreStyle << "</style>\n</head>\n<body><main>\n<h1>" << name
       << "</h1>\n<div class=\"wide\"><table>\n";
  const auto add_row = [&](const std::vector<std::string>& cells, const char* tag) {
    page << "<tr>";
    for (const std::string& cell : cells) {
      page << '<' << tag << '>' << Escape(cell) << "</" << tag << '>';
    }
    page << "</tr>\n";
  };
  add_row(table.header, "th");
  for (const std::vector<std::string>& row : table.rows) {
    add_row(row, "td");
  }
  page << "</table></div>\n<ul>\n";
  for (const std::string& note : table.notes) {
    page << "<li>" << Escape(note) << "</li>\n";
  }
  page << "</ul>\n<p>Pictures: the estimate over the ground truth, which is wide and gray "
       << "(each segment aligned by SE(3)), seen along the axis in which the ground truth extends "
       << "least. The circle is the start. A picture leads to the run's report.</p>\n";
  for (std::size_t i = 0; i < outcomes.size(); ++i) {
    if (i == 0 || outcomes[i].run.data != outcomes[i - 1].run.data) {
      page << (i == 0 ? "" : "</div>\n") << "<h2>" << Escape(outcomes[i].run.data)
           << "</h2>\n<div class=\"cards\">\n";
    }
    AddCard(outcomes[i], output, page);
  }
  page << (outcomes.empty() ? "" : "</div>\n") << "</main></body>\n</html>\n";
  return page.str();
}

}  // namespace gluevo::apps
