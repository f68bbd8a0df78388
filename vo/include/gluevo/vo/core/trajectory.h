#pragma once

#include <cstdint>
#include <vector>

#include "gluevo/vo/core/rigid3.h"

namespace gluevo::vo {

struct StampedPose {
  int64_t timestamp_ns = 0;  ///< Nanoseconds, the data set's clock.
  Rigid3 world_from_body;
};

/// Poses in order of time.
using Trajectory = std::vector<StampedPose>;

}  // namespace gluevo::vo
