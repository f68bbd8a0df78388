#pragma once

#include <cstdint>

namespace gluevo::vo {

/// Seconds from one timestamp to another, both in nanoseconds; negative where `to_ns` is earlier.
constexpr double SecondsBetween(int64_t from_ns, int64_t to_ns) {
  return static_cast<double>(to_ns - from_ns) * 1e-9;
}

}  // namespace gluevo::vo
