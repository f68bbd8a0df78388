#pragma once

#include <array>
#include <cstdint>
#include <deque>
#include <future>
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
  /// From left to right not the matcher but mutual nearest neighbours by descriptor, among the
  /// keypoints near the epipolar line: the calibration knows what the network would have to find
  /// out. A match is closer than `max_stereo_ratio` times the second nearest.
  bool stereo_in_band = false;
  double max_stereo_ratio = 0.9;
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
  /// With `refine`, a track begins where edges around its keypoint meet, within some pixels: what
  /// optical flow follows is the corner, and a point beside it would keep its distance in pixels
  /// while the view grows. For keypoints that lie beside corners, as ALIKED's do.
  bool begin_at_corners = false;
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

  /// 0: frames wait for the networks. Else these run beside tracking, on a thread of their own, and
  /// what they made of a frame is taken in so many frames later: optical flow carries it on from
  /// there. Frames wait as before where flow has lost the tracks, or the estimator finds no pose.
  int network_lag = 0;
  /// With a lag: where flow keeps fewer tracks than min_followed_share networks are due at once,
  /// but frames wait for them only below this share. Waiting where frames come far apart would make
  /// the next one come later still.
  double min_share_to_go_on = 0.5;
  /// With a lag: a result that is not there by then is waited for, so that results are the same
  /// each time. Else it is taken in with the first frame by which it is there, as cameras that do
  /// not wait need it.
  bool awaits_networks = true;

  /// Throws Error naming the option.
  void Validate() const;
};

/// Method 2 of Yoon and Park: keypoints by SuperPoint in both images, matched by SuperGlue from the
/// previous left image to this one (tracks) and from left to right (stereo); other networks may
/// stand in their places. With a lag (LearnedFrontEndOptions) extractor and matcher are called on
/// another thread, one call at a time, also between the calls of the front end's own functions.
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
  using Tracks = std::unordered_map<int64_t, TrackedPoint>;  // By their id.
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
  // A frame, what was known before it, and what is made of it.
  struct Sight {
    StereoFrame frame;
    std::array<Pyramid, 2> pyramids;
    Tracks previous_tracks;    // As the frame before saw them.
    Pyramid previous_pyramid;  // Its left image.

    std::vector<TrackedPoint> tracks;    // Where the networks ran one a keypoint of `view`.
    std::shared_ptr<KeypointView> view;  // Absent where only optical flow was run.
    nn::Features right_features;
    nn::Matches stereo;  // From `view` to them.
    std::map<std::string, double> stages_ms;
  };
  // A frame that the networks are at work on, beside tracking.
  struct LateSight {
    std::future<Sight> sight;
    int age = 0;  // So many frames have come since.
    bool is_keyframe = false;
  };

  void Advance();
  void KeepFrame();
  void Remember(std::shared_ptr<const KeypointView> view, bool is_keyframe);
  void MakePyramids();
  bool FollowTracks();
  void RunNetworks();
  // What networks make of a frame. New tracks have no id yet.
  void RunNetworksOn(const std::shared_ptr<const KeypointView>& reference,
                     const std::shared_ptr<const KeypointView>& keyframe, Sight& sight) const;
  std::shared_ptr<const KeypointView> KeyframeToRematch() const;  // Null where none is to be.
  void FindWays();
  void MatchStereo(Sight& sight) const;
  nn::Features Extract(const cv::Mat& image, const Camera& camera) const;
  void MatchFrom(const Way& way, Sight& sight) const;
  void CarryOn(const KeypointView& from, const nn::Matches& matches, Sight& sight) const;
  void RefineLeft(const KeypointView& from, const std::vector<Match>& carried, Sight& sight) const;
  bool FlowJudges(std::size_t refused, std::size_t matches) const;
  void RematchKeyframe(const KeypointView& keyframe, Sight& sight) const;
  void StartTracks(Sight& sight);
  void AddRightViews(Sight& sight) const;

  // Networks beside tracking.
  bool NetworksAreDue() const;
  void SendToNetworks();
  void TakeInLate();  // Where it is due.
  void AwaitLate();   // Where there is anything.
  void DiscardLate();
  // Takes in what networks made of an older frame.
  void CarryToNow(Sight late, bool is_keyframe);
  // Points of an older frame as the one before this saw them; those that are not found go.
  std::vector<TrackedPoint> FollowToBefore(const Sight& from,
                                           const std::vector<TrackedPoint>& points) const;
  bool SeeTheSame(const cv::Point2f& left, const cv::Point2f& right) const;
  TrackedFrame Observe() const;

  StereoRig rig_;
  EpipolarCheck epipolar_;
  std::unique_ptr<FeatureExtractor> extractor_;
  std::unique_ptr<Matcher> matcher_;
  std::unique_ptr<Matcher> fallback_;
  LearnedFrontEndOptions options_;

  int64_t next_track_id_ = 0;

  Sight now_;
  std::optional<std::deque<Way>> ways_;  // Absent before the first Retry().
  FrameOutcome outcome_;
  bool frames_are_missing_ = false;  // Between this frame and the next.
  std::optional<int> networks_age_;  // TrackedFrame's.

  // The frames before.
  std::shared_ptr<const KeypointView> reference_;              // The newest.
  std::deque<std::shared_ptr<const KeypointView>> keyframes_;  // The newest first.
  int frames_since_networks_ = 0;
  bool needs_networks_ = false;     // Flow has nothing to go on from.
  std::size_t tracks_to_keep_ = 0;  // That the networks gave last.
  std::optional<LateSight> late_;   // Last: its thread uses the others.
};

}  // namespace gluevo::vo
