#include "live_record.h"

#include <nlohmann/json.hpp>

namespace gluevo::apps {

void AddLive(const LiveRecord& record, nlohmann::ordered_json& json) {
  const vo::LiveStatistics& statistics = record.statistics;
  json["frames_dropped"] = record.dropped();
  json["latency_ms"] = {{"median", statistics.latency_median_ms},
                        {"p95", statistics.latency_p95_ms},
                        {"max", statistics.latency_max_ms}};
  json["live"] = {{"frames_late", record.source.frames_late},
                  {"frames_old", statistics.frames_dropped_old},
                  {"frames_refused", statistics.frames_refused},
                  {"frames_unpaired", record.source.frames_unpaired},
                  {"frames_paused", record.frames_paused},
                  {"stamps_still", statistics.stamps_still},
                  {"stamps_back", statistics.stamps_back},
                  {"clock_steps", statistics.clock_steps},
                  {"readings_left_out", statistics.readings_left_out},
                  {"readings_wait_ms", statistics.readings_wait_ms},
                  {"cameras_gone", record.source.cameras_gone}};
}

std::vector<std::string> LiveWarnings(const LiveRecord& record) {
  std::vector<std::string> warnings;
  const auto warn = [&](int64_t count, const std::string& what) {
    if (count > 0) {
      warnings.push_back(std::to_string(count) + what);
    }
  };
  const vo::LiveStatistics& statistics = record.statistics;
  warn(record.dropped(), " frames dropped: this machine is too slow for so many");
  warn(statistics.frames_refused, " frames left out that the front end refused");
  warn(record.source.frames_unpaired, " images of one camera without the other's");
  warn(statistics.stamps_still, " frames left out whose stamps stood still");
  warn(statistics.stamps_back, " frames left out whose stamps went back");
  warn(statistics.clock_steps, " times a clock stepped: stamps went on as if it had not");
  warn(record.source.cameras_gone, " times a camera was gone");
  return warnings;
}

}  // namespace gluevo::apps
