#include <cstdint>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "markup.h"
#include "path_views.h"
#include "sections.h"

namespace gluevo::apps {
namespace {

using Pairs = std::vector<std::pair<std::size_t, std::size_t>>;

// The frames of the loops that are believed, but for those with places of a loaded map, which no
// frame of the run is at.
Pairs ClosedPairs(const RunReport& report) {
  std::map<int64_t, std::size_t> frames;
  for (std::size_t i = 0; i < report.frames.size(); ++i) {
    frames[report.frames[i].timestamp_ns] = i;
  }
  Pairs pairs;
  for (const vo::LoopAttempt& attempt : report.loops->attempts) {
    const auto query = frames.find(attempt.query_ns);
    const auto candidate = frames.find(attempt.candidate_ns);
    if (attempt.is_closed && !attempt.is_of_loaded_map && query != frames.end() &&
        candidate != frames.end()) {
      pairs.emplace_back(candidate->second, query->second);
    }
  }
  return pairs;
}

std::string Pictures(const RunReport& report) {
  const Pairs pairs = ClosedPairs(report);
  std::vector<Eigen::Vector3d> before;
  std::vector<Eigen::Vector3d> after;
  before.reserve(report.frames.size());
  after.reserve(report.frames.size());
  for (std::size_t i = 0; i < report.frames.size(); ++i) {
    before.push_back(report.frames[i].world_from_body.translation);
    after.push_back(report.loops->optimized[i].world_from_body.translation);
  }
  return "<div class=\"columns\"><div><h3>Before</h3>" +
         DrawPathPicture(LoopView(report, before, pairs)) + "</div><div><h3>After</h3>" +
         DrawPathPicture(LoopView(report, after, pairs)) + "</div></div>\n";
}

std::string Row(const RunReport& report, const vo::LoopAttempt& attempt) {
  return "<tr><td>" + Fixed(SecondsIn(report, attempt.query_ns), 1) + "<td>" +
         (attempt.is_of_loaded_map ? "the map"
                                   : Fixed(SecondsIn(report, attempt.candidate_ns), 1)) +
         "<td>" + Fixed(attempt.similarity, 2) + "<td>" + std::to_string(attempt.matches) + "<td>" +
         std::to_string(attempt.inliers) + "<td>" +
         (attempt.is_closed ? "closed" : Escape(attempt.reason));
}

std::string Table(const RunReport& report) {
  constexpr std::size_t kMostRows = 200;
  const std::vector<vo::LoopAttempt>& attempts = report.loops->attempts;
  std::string html =
      "<div class=\"wide\"><table><thead><tr><th>at, s<th>taken for, s<th>similarity<th>matches"
      "<th>fit<th>outcome</thead><tbody>";
  for (std::size_t i = 0; i < attempts.size() && i < kMostRows; ++i) {
    html += Row(report, attempts[i]);
  }
  html += "</tbody></table></div>\n";
  return attempts.size() <= kMostRows ? html
                                      : html + "<p>" + std::to_string(attempts.size() - kMostRows) +
                                            " more are in metrics.json.</p>\n";
}

}  // namespace

std::string LoopsSection(const RunReport& report) {
  if (!report.loops) {
    return "";
  }
  std::size_t closed = 0;
  for (const vo::LoopAttempt& attempt : report.loops->attempts) {
    closed += attempt.is_closed ? 1 : 0;
  }
  std::string html = "<section><h2>Loops</h2>\n<p>" + std::to_string(closed) + " closed of " +
                     std::to_string(report.loops->attempts.size()) +
                     " pairs of key frames that look alike.</p>\n";
  if (closed > 0 && report.loops->optimized.size() == report.frames.size()) {
    html += Pictures(report);
  }
  return html + (report.loops->attempts.empty() ? "" : Table(report)) + "</section>\n";
}

}  // namespace gluevo::apps
