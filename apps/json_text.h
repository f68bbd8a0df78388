#pragma once

#include <nlohmann/json.hpp>
#include <string>

namespace gluevo::apps {

/// JSON as it is written and printed. Names of files may be of any bytes, JSON's texts may not:
/// what is not UTF-8 is shown as U+FFFD.
inline std::string JsonText(const nlohmann::ordered_json& json) {
  return json.dump(2, ' ', /*ensure_ascii=*/false,
                   nlohmann::ordered_json::error_handler_t::replace) +
         '\n';
}

}  // namespace gluevo::apps
