#pragma once

#include <cstdint>
#include <opencv2/core/mat.hpp>
#include <optional>
#include <vector>

#include "gluevo/vo/frontend/frontend.h"
#include "gluevo/vo/frontend/optical_flow.h"
#include "gluevo/vo/geometry/epipolar.h"
#include "gluevo/vo/geometry/stereo_rig.h"

namespace gluevo::vo {

/// Constants of VINS-Fusion's front end (its EuRoC configuration; KITTI: 200 corners).
struct KltOptions {
  int max_corners = 150;
  /// Between two tracks, pixels.
  int min_distance = 30;
  /// Least corner response, as a share of the best one's.
  double quality = 0.01;
  /// Side of the patch that is followed, pixels, and number of coarser pyramid levels.
  int window = 21;
  int levels = 3;
  /// A point followed forth and back must return this close to where it was, pixels.
  double max_return_distance = 0.5;
  /// Once an inertial unit says where points will be, a smaller patch is followed from where the
  /// large one ends, which sees less of what lies behind a corner; farther off than this, pixels,
  /// it is lost. Not in images with noise for which a smaller patch's place would be known no
  /// better than this (MedianFlowSigma), pixels.
  FlowOptions refinement = {.window = 11, .levels = 1, .levels_back = 1};
  double max_refinement_px = 3.0;
  double max_refinement_sigma_px = 0.035;
  /// Points closer to the image's edge are given up, pixels.
  int border = 1;
  /// A stereo match farther than this from its epipolar line is none, pixels. VINS-Fusion has no
  /// such check.
  double max_epipolar_error_px = 1.5;
  /// Start the search where the track would be if it moved on as it did last.
  bool predict = true;
  /// Reject tracks by a fundamental matrix (RANSAC, this distance in pixels at focal length 460).
  bool reject_by_fundamental = false;
  double fundamental_distance = 1.0;
  /// Follow the points into the right image.
  bool stereo = true;

  /// Throws Error naming the option.
  void Validate() const;
};

/// The baseline: Shi-Tomasi corners (Shi and Tomasi 1994) followed by pyramidal Lucas-Kanade
/// (Bouguet 2001) from frame to frame and from left to right.
class KltFrontEnd final : public FrontEnd {
 public:
  /// Throws Error for options out of their range.
  KltFrontEnd(const StereoRig& rig, const KltOptions& options);
  void Expect(const ExpectedView& view) override { expected_ = view; }
  TrackedFrame Track(const StereoFrame& frame) override;
  /// Where frames are missing before this one, which optical flow may not bridge: starts it where
  /// descriptors say. (Else there is no other way, as in the baseline.)
  std::optional<TrackedFrame> Retry() override;
  void Accept(const FrameOutcome& outcome) override;
  bool NeedsOnlyPassedOver() const override { return true; }
  void PassOver() override { ++frames_since_last_; }

 private:
  struct Corner {
    int64_t id = 0;
    int length = 1;           // frames
    cv::Point2f pixel;        // in the newest left image
    cv::Point2f motion = {};  // pixels a frame
  };

  static std::vector<cv::Point2f> PixelsOf(const std::vector<Corner>& corners);
  /// Whether an inertial unit says where known points are in the newest image.
  bool KnowsPoints() const { return expected_ && !expected_->pixels.empty(); }
  std::vector<cv::Point2f> GuessWhereExpected() const;
  std::vector<cv::Point2f> GuessByMotion() const;
  /// Sees the last image from where the camera has turned to, where that is far.
  void TurnLast();
  /// What is followed from: the last image, or what TurnLast() made of it, and last_tracks_ in it.
  const Pyramid& From() const { return turned_.empty() ? last_left_ : turned_; }
  std::vector<cv::Point2f> FromPixels() const {
    return turned_.empty() ? PixelsOf(last_tracks_) : turned_pixels_;
  }
  /// Finds last_tracks_ in the newest image, from where they may be.
  void Follow(const std::vector<cv::Point2f>& guesses);
  void FollowFromWhereSeen();
  /// What was found, new tracks, and the right views of both.
  TrackedFrame Complete();
  void RejectByFundamental(const std::vector<Corner>& before);
  void AddCorners(const cv::Mat& image);
  void MatchStereo(TrackedFrame& result) const;

  StereoRig rig_;
  EpipolarCheck epipolar_;
  KltOptions options_;
  std::vector<Corner> tracks_, last_tracks_;
  int64_t timestamp_ns_ = 0;
  bool has_retried_ = false;
  Pyramid left_, right_, last_left_;
  std::optional<ExpectedView> expected_;  // Of the newest frame.
  // What the last left image would have been had the camera been turned as it is now, and where it
  // would have shown last_tracks_; empty where it was not turned far.
  Pyramid turned_;
  std::vector<cv::Point2f> turned_pixels_;
  int frames_since_last_ = 1;
  int64_t next_id_ = 0;
};

}  // namespace gluevo::vo
