#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "frame_source.h"
#include "gluevo/vo/pipeline/live_pipeline.h"

namespace gluevo::apps {

/// How it went with what came as it happened.
struct LiveRecord {
  vo::LiveStatistics statistics;
  SourceCounts source;
  int64_t frames_paused = 0;  ///< Not tracked since a person had paused it.

  int64_t dropped() const { return statistics.frames_dropped + source.frames_late; }
};

/// The keys of metrics.json that `gluevo live` adds.
void AddLive(const LiveRecord& record, nlohmann::ordered_json& json);

/// What a user should know of it, a sentence each.
std::vector<std::string> LiveWarnings(const LiveRecord& record);

}  // namespace gluevo::apps
