#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "gluevo/vo/epipolar.h"
#include "gluevo/vo/frontend.h"
#include "gluevo/vo/matcher.h"

namespace gluevo::vo {

struct LearnedFrontEndOptions {
  /// Confidence above which a match from the previous left image to this one carries a track on.
  float tracking_threshold = 0.2F;
  /// The same from the left image to the right one.
  float stereo_threshold = 0.2F;
  /// A stereo match farther than this from its epipolar line is none, pixels.
  double max_epipolar_error_px = 3.0;
  /// Of points closer than this to each other only the one with the longest track is observed,
  /// pixels.
  double min_distance_px = 0.0;

  /// Throws Error naming the option.
  void Validate() const;
};

/// Method 2 of Yoon and Park: keypoints by SuperPoint in both images, matched by SuperGlue from the
/// previous left image to this one (tracks) and from left to right (stereo).
class LearnedFrontEnd : public FrontEnd {
 public:
  /// `fallback` (may be absent) matches left images in Retry(). Throws Error for bad options.
  LearnedFrontEnd(const StereoRig& rig, std::unique_ptr<FeatureExtractor> extractor,
                  std::unique_ptr<Matcher> matcher, std::unique_ptr<Matcher> fallback,
                  const LearnedFrontEndOptions& options);

  TrackedFrame Track(const StereoFrame& frame) override;
  std::optional<TrackedFrame> Retry() override;

 private:
  // A left image with the tracks that its keypoints belong to.
  struct LeftImage {
    nn::Features features;
    std::vector<int64_t> track_ids;
    std::vector<int> track_lengths;  // Frames that have seen the track, this one included.
    std::vector<float> track_confidences;
  };
  // The right view of each left keypoint.
  struct RightViews {
    nn::Features features;
    nn::Matches matches;  // From left; only those that pass the epipolar check.
  };

  LeftImage ContinueTracks(const nn::Features& features, const nn::Matches& from_previous);
  RightViews MatchStereo(const nn::Features& left, nn::Features right);
  TrackedFrame Observe() const;

  StereoRig rig_;
  EpipolarCheck epipolar_;
  std::unique_ptr<FeatureExtractor> extractor_;
  std::unique_ptr<Matcher> matcher_;
  std::unique_ptr<Matcher> fallback_;
  LearnedFrontEndOptions options_;

  int64_t next_track_id_ = 0;
  int64_t timestamp_ns_ = 0;
  LeftImage previous_;
  LeftImage current_;
  RightViews right_;
  std::map<std::string, double> stages_ms_;
  bool retried_ = false;
};

}  // namespace gluevo::vo
