#include "network_record.h"

#include <nlohmann/json.hpp>

namespace gluevo::apps {

void NetworkRecord::Add(const vo::TrackedFrame& frame) {
  if (frame.networks_age) {
    ++runs_by_age_[*frame.networks_age];
  }
}

void NetworkRecord::AddTo(nlohmann::ordered_json& json) const {
  if (runs_by_age_.empty()) {
    return;
  }
  int64_t in_line = 0;
  int64_t late = 0;
  for (const auto& [age, runs] : runs_by_age_) {
    (age == 0 ? in_line : late) += runs;
  }
  int median = 0;
  int64_t below = 0;
  for (const auto& [age, runs] : runs_by_age_) {
    if (age > 0 && 2 * below < late) {
      median = age;
      below += runs;
    }
  }
  json["networks"] = {{"runs", in_line + late},
                      {"in_line", in_line},
                      {"lag_frames", {{"median", median}, {"max", runs_by_age_.rbegin()->first}}}};
}

}  // namespace gluevo::apps
