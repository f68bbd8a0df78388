#pragma once

#include <memory>
#include <optional>

#include "gluevo/vo/frontend/frontend.h"
#include "gluevo/vo/frontend/klt_frontend.h"
#include "gluevo/vo/frontend/matcher.h"
#include "gluevo/vo/frontend/optical_flow.h"
#include "gluevo/vo/geometry/epipolar.h"

namespace gluevo::vo {

struct SuperPointFrontEndOptions {
  /// How the left tracks are made; its stereo is not used.
  KltOptions klt;
  /// Lowe's ratio (2004) between the nearest and the second nearest right descriptor within the
  /// epipolar band; 1 accepts all.
  double max_ratio = 0.9;
  /// Right keypoints farther than this from a track's epipolar line are no candidates, pixels.
  double max_epipolar_error_px = 3.0;
  /// A track need not lie on a keypoint of the right image: move its match to where optical flow
  /// from the left image ends.
  bool refine = true;
  FlowOptions refinement = {.window = 11, .levels = 1, .levels_back = 1};
  /// Where optical flow ends farther than this from the match there is none, pixels: SuperPoint's
  /// cells are 8 pixels wide.
  double max_refinement_px = 8.0;

  /// Throws Error naming the option.
  void Validate() const;
};

/// Method 1 of Yoon and Park: left tracks as the baseline makes them, described by SuperPoint (or
/// ALIKED) where they are, and matched to its keypoints of the right image by their nearest
/// neighbours.
class SuperPointFrontEnd final : public FrontEnd {
 public:
  /// Throws Error for bad options.
  SuperPointFrontEnd(const StereoRig& rig, std::unique_ptr<FeatureExtractor> extractor,
                     const SuperPointFrontEndOptions& options);
  void Expect(const ExpectedView& view) override { klt_.Expect(view); }
  TrackedFrame Track(const StereoFrame& frame) override;
  /// As the baseline does.
  std::optional<TrackedFrame> Retry() override;
  void Accept(const FrameOutcome& outcome) override { klt_.Accept(outcome); }
  void PassOver() override { klt_.PassOver(); }

 private:
  /// Adds the right views.
  TrackedFrame MatchRight(TrackedFrame result);
  void Refine(const StereoFrame& images, TrackedFrame& frame) const;

  StereoRig rig_;
  EpipolarCheck epipolar_;
  std::unique_ptr<FeatureExtractor> extractor_;
  SuperPointFrontEndOptions options_;
  KltFrontEnd klt_;
  StereoFrame frame_;  // The newest.
};

}  // namespace gluevo::vo
