#pragma once

#include <array>
#include <cstdint>
#include <deque>
#include <map>
#include <memory>
#include <opencv2/core/mat.hpp>
#include <optional>
#include <string>
#include <unordered_map>
#include <vector>

#include "gluevo/vo/frontend/frontend.h"
#include "gluevo/vo/frontend/matcher.h"
#include "gluevo/vo/frontend/optical_flow.h"
#include "gluevo/vo/geometry/epipolar.h"

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

  /// Keypoints lie on whole pixels, and a track's keypoints at different places of the same corner.
  /// Move the newer point of each match to where optical flow finds the patch of the older one.
  /// A small patch: keypoints like the edges of things, where a large one also sees what is behind
  /// and gives a disparity between the two (with 21 pixels paths came out 0.2 % too long).
  bool refine = true;
  FlowOptions refinement = {.window = 11, .levels = 1, .levels_back = 1};
  /// Where optical flow ends farther than this from the match it does not see the same, pixels.
  double max_refinement_px = 3.0;
  /// Where optical flow confirms at least this share of an image pair's matches, it is the better
  /// judge: the others are dropped. Else the images differ too much for it, and the others stay
  /// where the networks saw them. 0 to 1.
  double min_confirmed_share = 0.6;

  /// A key frame's track that this frame has lost is found again by matching the two. Costs one
  /// more match a frame.
  bool rematch_keyframe = false;
  /// Where the estimator finds no pose, so many of the newest key frames are tried, too.
  int recovery_keyframes = 10;

  /// Networks run on every so many-th frame at least; tracks are carried through those between by
  /// optical flow, as long as enough remain: over so short a way it is the more accurate of the
  /// two. First with a patch that finds large motions, then with `refinement`'s.
  int network_every = 5;
  FlowOptions following = {.window = 21, .levels = 3, .levels_back = 1};
  /// Networks run where optical flow keeps fewer of the tracks that they gave, 0 to 1.
  double min_followed_share = 0.8;

  /// Throws Error naming the option.
  void Validate() const;
};

/// Method 2 of Yoon and Park: keypoints by SuperPoint in both images, matched by SuperGlue from the
/// previous left image to this one (tracks) and from left to right (stereo); other networks may
/// stand in their places.
class LearnedFrontEnd : public FrontEnd {
 public:
  /// `fallback` (may be absent) matches left images in Retry(). Throws Error for bad options.
  LearnedFrontEnd(const StereoRig& rig, std::unique_ptr<FeatureExtractor> extractor,
                  std::unique_ptr<Matcher> matcher, std::unique_ptr<Matcher> fallback,
                  const LearnedFrontEndOptions& options);

  TrackedFrame Track(const StereoFrame& frame) override;
  /// Runs the networks where optical flow was relied on; then the fallback from the previous frame;
  /// then matcher and fallback from each key frame, the newest first.
  std::optional<TrackedFrame> Retry() override;
  void Accept(const FrameOutcome& outcome) override;
  void PassOver() override { frames_are_missing_ = true; }

 private:
  // A point of the scene as the newest frame sees it.
  struct TrackedPoint {
    int64_t id = -1;
    int length = 1;  // Frames that have seen it, this one included.
    cv::Point2f left;
    cv::Point2f motion;  // Of the left pixel since the frame before.
    float tracking_confidence = 0.0F;
    bool has_right = false;
    cv::Point2f right;
    float stereo_confidence = 0.0F;
  };
  // A left image that the networks have seen.
  struct KeypointView {
    nn::Features features;
    std::vector<TrackedPoint> tracks;  // One a keypoint.
    Pyramid pyramid;                   // Empty where no optical flow is used.
  };
  struct Match {
    int from = -1;  // Keypoint of another view.
    int to = -1;    // Of view_.
  };
  // A way to match the frame that has not been tried.
  struct Way {
    std::shared_ptr<const KeypointView> from;
    Matcher* matcher = nullptr;
    float threshold = 0.0F;
  };

  void Advance();
  void KeepFrame();
  void MakePyramids();
  bool FollowTracks();
  void RunNetworks();
  void FindWays();
  nn::Features Extract(const cv::Mat& image, const Camera& camera);
  void MatchFrom(const Way& way);
  void CarryOn(const KeypointView& from, const nn::Matches& matches);
  void RefineLeft(const KeypointView& from, const std::vector<Match>& carried);
  bool FlowJudges(std::size_t refused, std::size_t matches) const;
  void RematchKeyframe();
  void StartTracks();
  void AddRightViews();
  bool SeeTheSame(const cv::Point2f& left, const cv::Point2f& right) const;
  TrackedFrame Observe() const;

  StereoRig rig_;
  EpipolarCheck epipolar_;
  std::unique_ptr<FeatureExtractor> extractor_;
  std::unique_ptr<Matcher> matcher_;
  std::unique_ptr<Matcher> fallback_;
  LearnedFrontEndOptions options_;

  int64_t next_track_id_ = 0;

  // The newest frame.
  StereoFrame frame_;
  std::array<Pyramid, 2> pyramids_;
  std::vector<TrackedPoint> tracks_;    // Where the networks ran one a keypoint of view_.
  std::shared_ptr<KeypointView> view_;  // Absent where only optical flow was run.
  nn::Features right_features_;
  nn::Matches stereo_;  // From view_ to them.
  std::map<std::string, double> stages_ms_;
  std::optional<std::deque<Way>> ways_;  // Absent before the first Retry().
  FrameOutcome outcome_;
  bool frames_are_missing_ = false;  // Between this frame and the next.

  // The frames before.
  std::unordered_map<int64_t, TrackedPoint> previous_tracks_;
  Pyramid previous_pyramid_;                                   // Left.
  std::shared_ptr<const KeypointView> reference_;              // The newest.
  std::deque<std::shared_ptr<const KeypointView>> keyframes_;  // The newest first.
  int frames_since_networks_ = 0;
};

}  // namespace gluevo::vo
