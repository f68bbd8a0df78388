#pragma once

#include <optional>

#include "gluevo/vo/core/expected_view.h"
#include "gluevo/vo/core/stereo_frame.h"
#include "gluevo/vo/core/tracked_frame.h"
#include "gluevo/vo/geometry/stereo_rig.h"

namespace gluevo::vo {

/// What became of the frame that a front end gave last.
struct FrameOutcome {
  bool is_keyframe = false;
  /// The pose could not be linked to those before: of what was seen before this frame nothing is
  /// known any more.
  bool starts_segment = false;
  /// It shows nothing by which it could be located: the next frame is to be matched with those
  /// before it.
  bool is_passed_over = false;
};

/// Throws Error naming the camera unless both images are CV_8UC1 of their cameras' sizes.
void CheckImages(const StereoFrame& frame, const StereoRig& rig);

/// Turns stereo images into tracks. The estimator knows front ends only by this interface: KLT,
/// 2-NN, SuperGlue and a replayed file are interchangeable.
class FrontEnd {
 public:
  FrontEnd() = default;
  FrontEnd(const FrontEnd&) = delete;
  FrontEnd& operator=(const FrontEnd&) = delete;
  virtual ~FrontEnd() = default;

  /// What an inertial unit says of the frame that Track() is given next. Not called for frames of
  /// which it says nothing.
  virtual void Expect(const ExpectedView& /*view*/) {}

  /// The next frame of the sequence. Throws Error as CheckImages does; the front end is then as it
  /// was before.
  virtual TrackedFrame Track(const StereoFrame& frame) = 0;

  /// The estimator found no pose with what the last call gave. A front end that knows another way
  /// to match the same frame (which the estimator then tries in its place) returns its result;
  /// each call the next way, nothing when there is none left.
  virtual std::optional<TrackedFrame> Retry() { return std::nullopt; }

  /// The estimator has done with the frame that was given last.
  virtual void Accept(const FrameOutcome& /*outcome*/) {}

  /// Whether Track() for the next frame needs of the outcome only whether this one was passed over.
  /// Accept() may then be called as soon as that is known, with the rest as it is by default, and
  /// Track() be called on another thread than the rest, at a time when nobody else calls.
  virtual bool NeedsOnlyPassedOver() const { return false; }

  /// A frame of the sequence came that shows nothing and was not given to Track().
  virtual void PassOver() {}
};

}  // namespace gluevo::vo
