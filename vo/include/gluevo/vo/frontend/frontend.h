#pragma once

#include <optional>

#include "gluevo/vo/core/stereo_frame.h"
#include "gluevo/vo/core/tracked_frame.h"

namespace gluevo::vo {

/// Turns stereo images into tracks. The estimator knows front ends only by this interface: KLT,
/// 2-NN, SuperGlue and a replayed file are interchangeable.
class FrontEnd {
 public:
  FrontEnd() = default;
  FrontEnd(const FrontEnd&) = delete;
  FrontEnd& operator=(const FrontEnd&) = delete;
  virtual ~FrontEnd() = default;

  /// The next frame of the sequence. Throws Error for images of another size than the rig's.
  virtual TrackedFrame Track(const StereoFrame& frame) = 0;

  /// The estimator found no pose with what the last call gave. A front end that knows another way
  /// to match the same frame (which the estimator then tries in its place) returns its result;
  /// each call the next way, nothing when there is none left.
  virtual std::optional<TrackedFrame> Retry() { return std::nullopt; }

  /// The estimator has done with the frame that was given last, and took it for a key frame or not.
  virtual void Accept(bool /*is_keyframe*/) {}
};

}  // namespace gluevo::vo
