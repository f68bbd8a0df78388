#pragma once

#include <cstdint>
#include <map>
#include <nlohmann/json_fwd.hpp>

#include "gluevo/vo/core/tracked_frame.h"

namespace gluevo::apps {

/// How often the networks of a front end ran, and how late what they made of a frame came in. Its
/// memory does not grow with the frames.
class NetworkRecord {
 public:
  void Add(const vo::TrackedFrame& frame);

  /// The key "networks" of metrics.json; none where no networks ran.
  void AddTo(nlohmann::ordered_json& json) const;

 private:
  std::map<int, int64_t> runs_by_age_;  // TrackedFrame::networks_age.
};

}  // namespace gluevo::apps
