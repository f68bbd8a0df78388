#pragma once

#include <optional>
#include <vector>

#include "gluevo/vo/core/rigid3.h"
#include "gluevo/vo/geometry/pnp.h"
#include "gluevo/vo/inertial/still_factor.h"
#include "gluevo/vo/pipeline/odometry.h"

namespace gluevo::vo {

/// Where a frame enters the window.
struct Odometry::FramePose {
  Rigid3 world_from_body;
  int inliers = 0;
  std::vector<std::optional<PnpVerdict>> verdicts;  // One an observation, where it was judged.
  double median_error_px = 0.0;                     // As in PnpResult.
  std::optional<StillFactor> still = {};            // Since the frame before.
};

}  // namespace gluevo::vo
