#pragma once

#include <nlohmann/json_fwd.hpp>
#include <vector>

#include "gluevo/vo/core/frame_result.h"

namespace gluevo::apps {

/// The keys of metrics.json with the numbers of the frames whose poses are to be taken with care.
void AddMarkedFrames(const std::vector<vo::FrameResult>& frames, nlohmann::ordered_json& json);

/// The key "segments": poses are linked within a segment only.
nlohmann::ordered_json SegmentsJson(const std::vector<vo::FrameResult>& frames);

}  // namespace gluevo::apps
