#pragma once

#include <cstddef>
#include <vector>

#include "gluevo/vo/core/rigid3.h"
#include "gluevo/vo/frontend/matcher.h"
#include "gluevo/vo/mapping/loop_closer.h"

namespace gluevo::vo {

struct GlobalAdjustmentOptions {
  float match_threshold = 0.2F;  ///< Confidence of a match between key frames, 0 to 1.
  /// Matches whose points are farther from where the poses and the first one's depth put them than
  /// this are left out, pixels of kReferenceFocalPx.
  double max_error_px = 10.0;
  /// Standard deviation of a keypoint, pixels of kReferenceFocalPx.
  double noise_px = 1.5;
  /// Of the points that three key frames or more see, one in so many has a view that takes no part:
  /// that is what the result is judged by.
  int held_out_every = 4;

  /// Throws Error naming the option.
  void Validate() const;
};

/// Poses of all key frames by all that they see.
struct GlobalAdjustment {
  std::vector<Rigid3> world_from_body;  ///< Those from before where they are not kept.
  bool is_kept = false;
  std::size_t landmarks = 0;
  std::size_t observations = 0;  ///< Views of them that take part.
  std::size_t held_out = 0;      ///< Views that do not.
  /// Mean error of the views held out, pixels of kReferenceFocalPx, each counted up to ten: with
  /// the poses from before, the points adjusted, and with both adjusted.
  double error_before_px = 0.0;
  double error_after_px = 0.0;
};

/// Bundle adjustment (Triggs et al. 2000) of a run's key frames, by the matches of those that
/// follow each other and of loops, together with odometry's motions, from the poses
/// `world_from_body` on. Kept where it lowers the error of views that it does not know. The same
/// for any number of threads. Throws what the matcher throws.
GlobalAdjustment AdjustGlobally(const LoopCloser& closer,
                                const std::vector<Rigid3>& world_from_body, Matcher& matcher,
                                const GlobalAdjustmentOptions& options);

}  // namespace gluevo::vo
