#pragma once

#include "gluevo/vo/inertial/initialisation.h"
#include "gluevo/vo/inertial/rest.h"

namespace gluevo::vo {

struct InertialOptions {
  /// What is needed to start in motion. Half a degree: of the recorded flights' starts some were a
  /// degree off where a degree was enough.
  InitialisationOptions start = {.largest_gravity_sigma = 0.0087266};
  RestOptions rest;
  /// A frame that shows something, but nothing that was seen before, is taken where the readings
  /// lead while that is known within this, metres in the worst direction; else a segment starts.
  double max_bridge_sigma_m = 1.0;
  /// Until this time since the last located frame such frames are passed over: the next one may
  /// show more of what was seen before. In place of OdometryOptions::max_predicted_s, seconds.
  double bridge_after_s = 0.3;
  /// Whether the time offset between the clocks of images and readings (see ImuReadings) is
  /// estimated, and what is known of it beforehand: that it is zero within this, seconds.
  bool estimate_time_offset = false;
  double time_offset_sigma_s = 0.01;

  /// Throws Error naming the option.
  void Validate() const;
};

}  // namespace gluevo::vo
