#pragma once

#include "gluevo/vo/estimator/sliding_window_options.h"
#include "gluevo/vo/geometry/pnp.h"

namespace gluevo::vo {

struct OdometryOptions {
  PnpOptions pnp;
  SlidingWindowOptions window;
  /// Faster motion than this between two frames is a failure, not a motion.
  double max_speed_m_per_s = 60.0;
  double max_turn_deg_per_s = 720.0;

  /// Throws Error naming the option.
  void Validate() const;
};

}  // namespace gluevo::vo
