#pragma once

#include <algorithm>
#include <cstddef>
#include <vector>

namespace gluevo::vo {

/// The middle value, the upper one of the two where there are two; 0 of none.
template <typename Value>
Value Median(std::vector<Value> values) {
  if (values.empty()) {
    return Value{};
  }
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

}  // namespace gluevo::vo
