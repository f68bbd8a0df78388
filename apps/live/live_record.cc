#include "live_record.h"

#include <nlohmann/json.hpp>

#include "gluevo/vo/core/text.h"

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
  const auto warn = [&](int64_t count, const std::string& noun, const std::string& what) {
    if (count > 0) {
      warnings.push_back(vo::Counted(count, noun) + what);
    }
  };
  const vo::LiveStatistics& statistics = record.statistics;
  warn(record.dropped(), "frame", " dropped: this machine is too slow for so many");
  warn(statistics.frames_refused, "frame", " left out that the front end refused");
  warn(record.source.frames_unpaired, "image", " of one camera without the other's");
  warn(statistics.stamps_still, "frame", " left out whose stamps stood still");
  warn(statistics.stamps_back, "frame", " left out whose stamps went back");
  warn(statistics.clock_steps, "time", " a clock stepped: stamps went on as if it had not");
  warn(record.source.cameras_gone, "time", " a camera was gone");
  return warnings;
}

}  // namespace gluevo::apps
