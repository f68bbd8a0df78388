#pragma once

#include <algorithm>
#include <optional>
#include <vector>

#include "gluevo/vo/core/frame_result.h"

namespace gluevo::apps {

/// What the newest frame that has such an estimate says; null where none has.
template <typename Estimate>
const Estimate* NewestEstimate(const std::vector<vo::FrameResult>& frames,
                               std::optional<Estimate> vo::FrameResult::*estimate) {
  const auto frame =
      std::find_if(frames.rbegin(), frames.rend(),
                   [estimate](const vo::FrameResult& one) { return (one.*estimate).has_value(); });
  return frame == frames.rend() ? nullptr : &*((*frame).*estimate);
}

}  // namespace gluevo::apps
