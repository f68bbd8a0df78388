#pragma once

#include "gluevo/vo/estimator/sliding_window_options.h"
#include "gluevo/vo/geometry/pnp.h"
#include "gluevo/vo/pipeline/inertial_options.h"
#include "gluevo/vo/pipeline/keypoint_noise.h"
#include "gluevo/vo/pipeline/track_votes.h"

namespace gluevo::vo {

struct OdometryOptions {
  /// Its noise_px is the start of what the frames say, see `keypoint_noise`.
  PnpOptions pnp;
  KeypointNoiseOptions keypoint_noise;
  SlidingWindowOptions window;
  VoteOptions votes;
  InertialOptions inertial;
  /// Faster motion than this between two frames is a failure, not a motion.
  double max_speed_m_per_s = 60.0;
  double max_turn_deg_per_s = 720.0;
  /// A frame seen by both cameras in fewer points than this shows nothing: where it cannot be
  /// located its pose is predicted, and the frames after it are matched with those before it.
  int min_stereo = 15;
  /// The same goes for a frame that shows something, but nothing that was seen before, until this
  /// time has passed since the last located frame, seconds: then it starts a segment.
  double max_predicted_s = 1.0;

  /// Throws Error naming the option.
  void Validate() const;
};

}  // namespace gluevo::vo
