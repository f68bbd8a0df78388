#include "segments_file.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <string>

#include "gluevo/nn/error.h"
#include "gluevo/vo/io/whole_file.h"

namespace gluevo::apps {
namespace {

struct Segment {
  std::size_t first_frame;
  std::size_t last_frame;
  double start_s;
  double end_s;
};

std::vector<Segment> ParseSegments(const std::filesystem::path& file) {
  const std::string text = vo::ReadWholeFile(file);
  std::vector<Segment> segments;
  try {
    const nlohmann::json metrics = nlohmann::json::parse(text);
    for (const nlohmann::json& entry : metrics.at("segments")) {
      segments.push_back({entry.at("first_frame").get<std::size_t>(),
                          entry.at("last_frame").get<std::size_t>(),
                          entry.at("start_s").get<double>(), entry.at("end_s").get<double>()});
    }
  } catch (const nlohmann::json::exception&) {
    throw Error(file.string() +
                ": expected a metrics.json of gluevo run, with segments of first_frame, "
                "last_frame, start_s and end_s");
  }
  return segments;
}

}  // namespace

std::vector<int> ReadSegments(const std::filesystem::path& metrics_file,
                              const vo::Trajectory& trajectory) {
  const std::vector<Segment> segments = ParseSegments(metrics_file);
  const bool by_row = !segments.empty() && segments.back().last_frame + 1 == trajectory.size();
  // Times as doubles of seconds since 1970 are exact to a quarter of a microsecond.
  constexpr double kRounding = 1e-6;
  std::vector<int> numbers;
  for (std::size_t row = 0; row < trajectory.size(); ++row) {
    const double time_s = static_cast<double>(trajectory[row].timestamp_ns) * 1e-9;
    const auto found = std::find_if(segments.begin(), segments.end(), [&](const Segment& segment) {
      return by_row ? row >= segment.first_frame && row <= segment.last_frame
                    : time_s >= segment.start_s - kRounding && time_s <= segment.end_s + kRounding;
    });
    if (found == segments.end()) {
      throw Error(metrics_file.string() + ": no segment for the pose at " + std::to_string(time_s) +
                  " s: is it of another run than the trajectory?");
    }
    numbers.push_back(static_cast<int>(found - segments.begin()));
  }
  return numbers;
}

}  // namespace gluevo::apps
