#include "frame_metrics.h"

#include <cstddef>
#include <nlohmann/json.hpp>
#include <utility>

namespace gluevo::apps {

using Json = nlohmann::ordered_json;

void AddMarkedFrames(const std::vector<vo::FrameResult>& frames, Json& json) {
  for (const auto& [key, flag] : {std::pair{"frames_predicted", &vo::FrameResult::is_predicted},
                                  std::pair{"frames_doubtful", &vo::FrameResult::is_doubtful},
                                  std::pair{"frames_left_only", &vo::FrameResult::is_left_only}}) {
    json[key] = Json::array();
    for (std::size_t i = 0; i < frames.size(); ++i) {
      if (frames[i].*flag) {
        json[key].push_back(i);
      }
    }
  }
}

Json SegmentsJson(const std::vector<vo::FrameResult>& frames) {
  Json segments = Json::array();
  for (std::size_t begin = 0; begin < frames.size();) {
    std::size_t end = begin;
    while (end < frames.size() && frames[end].segment == frames[begin].segment) {
      ++end;
    }
    segments.push_back({{"first_frame", begin},
                        {"last_frame", end - 1},
                        {"start_s", static_cast<double>(frames[begin].timestamp_ns) * 1e-9},
                        {"end_s", static_cast<double>(frames[end - 1].timestamp_ns) * 1e-9}});
    begin = end;
  }
  return segments;
}

}  // namespace gluevo::apps
