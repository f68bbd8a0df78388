#include "gluevo/vo/pipeline/odometry_config.h"

#include "gluevo/vo/core/options_check.h"

namespace gluevo::vo {

void OdometryOptions::Validate() const {
  pnp.Validate();
  keypoint_noise.Validate();
  window.Validate();
  votes.Validate();
  inertial.Validate();
  CheckPositive(max_speed_m_per_s, "max_speed_m_per_s");
  CheckPositive(max_turn_deg_per_s, "max_turn_deg_per_s");
  CheckAtLeast(min_stereo, 0, "min_stereo");
  CheckWithin(max_predicted_s, 0.0, 1e6, "max_predicted_s (--max-predicted)");
}

void OdometryConfig::Validate() const {
  frontend.Validate();
  odometry.Validate();
  CheckAtLeast(threads, 0, "threads (--threads)");
}

}  // namespace gluevo::vo
