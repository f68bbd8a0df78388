#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <map>
#include <optional>
#include <unordered_map>
#include <vector>

#include "gluevo/vo/core/rigid3.h"
#include "gluevo/vo/estimator/pose_prior.h"
#include "gluevo/vo/frontend/frontend.h"
#include "gluevo/vo/geometry/camera.h"
#include "gluevo/vo/geometry/pnp.h"
#include "gluevo/vo/geometry/pose_manifold.h"
#include "gluevo/vo/geometry/triangulation.h"

namespace gluevo::vo {

struct SlidingWindowOptions {
  /// Frames in the window, the newest included.
  int size = 11;
  /// Standard deviation of a keypoint, normalised plane: half a pixel, as optical flow and refined
  /// matches have it. VINS-Fusion takes 1.5 px; with that the robust loss takes errors of a pixel
  /// for noise, and drift is larger. (PnP, which judges matches that may be worse, has its own.)
  double noise = 0.5 / 460.0;
  /// Huber threshold of the reprojection residuals, in standard deviations.
  double huber = 1.0;
  /// Limit of the solver. By count and never by time, so that results repeat.
  int max_iterations = 8;
  /// Landmarks with a larger mean reprojection error (normalised plane, both cameras) are dropped.
  double max_mean_error = 3.0 / 460.0;
  /// A frame is a key frame when its tracks have moved this much, on average, since the last key
  /// frame (normalised plane) ...
  double keyframe_parallax = 10.0 / 460.0;
  /// ... or fewer tracks than this were followed ...
  int min_tracked = 20;
  /// ... or fewer than this were followed that have at least `long_track` observations ...
  int min_long_tracked = 40;
  int long_track = 4;
  /// ... or there are more new tracks than this times those that were followed.
  double max_new_share = 0.5;
  /// How well the calibration knows the right camera's orientation in the rig: standard deviation
  /// on each axis, radians. Within it the orientation is refined with each bundle adjustment; 0
  /// keeps it fixed. A third of a pixel of rectification error, as KITTI's has, makes distances
  /// wrong by a percent. Tighter than such an error on purpose: a keypoint's error in one frame is
  /// much the same in the next, so that many frames agree on more than they know.
  double right_turn_sigma = 5e-5;
  /// Whether a dropped key frame leaves what it knew of the others' poses as a prior.
  bool marginalize = true;
  TriangulationOptions triangulation;

  /// Throws Error naming the option.
  void Validate() const;
};

/// A point of the scene and the track that shows it.
struct MapPoint {
  int64_t track_id = 0;
  Eigen::Vector3d point_in_world = Eigen::Vector3d::Zero();  ///< Metres.
};

/// Poses and landmarks of the newest frames, estimated together (Qin et al. 2018, section VI,
/// without the inertial part). Landmarks are known by bearing and inverse depth in their anchor,
/// the left view of the first frame in the window that sees them. The oldest pose stays fixed: it
/// is the gauge.
class SlidingWindow {
 public:
  SlidingWindow(const StereoRig& rig, const SlidingWindowOptions& options);

  bool empty() const { return frames_.empty(); }
  /// The rig with the right camera's refined orientation.
  const StereoRig& rig() const { return rig_; }
  /// The newest frame's. The window must not be empty.
  const Rigid3& world_from_body() const { return frames_.back().world_from_body; }
  bool newest_is_keyframe() const { return frames_.back().is_keyframe; }
  /// Landmarks that have a depth.
  std::size_t CountLandmarks() const;
  std::vector<MapPoint> MapPoints() const;

  /// An observation of a frame that is not in the window yet, with the landmark it belongs to.
  struct Correspondence {
    std::size_t observation = 0;  ///< Index into TrackedFrame::observations.
    PnpObservation pnp;
  };
  /// Those observations of `frame` whose landmarks have a depth, and how well they know it where
  /// keypoints have a standard deviation of `noise` on the normalised plane.
  std::vector<Correspondence> Correspond(const TrackedFrame& frame, double noise) const;

  /// Adds the newest frame and decides whether it is a key frame. `verdicts`, one an observation
  /// where known: an outlier starts a new landmark instead of spoiling the old one, a wrong right
  /// view is left out.
  void AddFrame(const TrackedFrame& frame, const Rigid3& world_from_body,
                const std::vector<std::optional<PnpVerdict>>& verdicts);
  /// Gives a depth to landmarks that have none and can be triangulated, from one frame's stereo or
  /// from several frames.
  void Triangulate();
  /// Bundle adjustment. Throws nothing: where the solver fails the window stays as it was, and the
  /// answer is false.
  bool Optimize();
  /// Drops landmarks that fit badly or came to lie behind a camera that sees them; those seen in
  /// the newest frame start again from it.
  void RemoveOutliers();
  /// Makes room for the next frame: where the window is full, the newest but one leaves if it is
  /// no key frame (and tracking has not just broken down), else the oldest. What the oldest frame
  /// and the landmarks anchored in it say of the other poses stays as a prior.
  void Slide();

 private:
  struct Frame {
    int64_t id = 0;
    Rigid3 world_from_body;
    bool is_keyframe = false;
    bool lost_tracks = false;  // so few tracks came through that the frame before matters
  };
  struct LandmarkView {
    int64_t frame_id = 0;
    Eigen::Vector2d left = Eigen::Vector2d::Zero();  // normalised plane
    std::optional<Eigen::Vector2d> right;
  };
  struct Landmark {
    int64_t track_id = 0;
    std::vector<LandmarkView> views;  // in order of frames; the first is the anchor
    /// Estimate in the anchor's left view: u, v on the normalised plane, inverse depth (1/m).
    std::optional<Eigen::Vector3d> point;
    int observations = 1;  // dropped views included
  };
  using Landmarks = std::map<int64_t, Landmark>;
  // Where residuals are taken and where their derivatives are, one pose a frame, and what lies
  // between the two, by the tangents of the whole state.
  struct Linearization {
    std::vector<PoseParameters> present, first_estimates;
    Eigen::VectorXd delta;
  };

  std::size_t FrameIndex(int64_t frame_id) const;
  const Frame& FrameOf(const LandmarkView& view) const {
    return frames_[FrameIndex(view.frame_id)];
  }
  /// Calls visit(cam_from_anchor_cam, observed) for every view, left and right, of a landmark.
  template <typename Visitor>
  void ForEachView(const Landmark& landmark, Visitor visit) const;
  /// Without its uncertainty.
  AnchoredPoint ToAnchoredPoint(const Landmark& landmark) const;
  double InverseDepthSigma(const Landmark& landmark, double noise) const;
  void DecideKeyframe(std::size_t new_tracks);
  double MeanParallax(int64_t frame_id0, int64_t frame_id1) const;
  /// The point in the first view (as Landmark::point), where triangulation succeeds.
  std::optional<Eigen::Vector3d> TriangulateViews(const std::vector<LandmarkView>& views) const;
  std::optional<double> MeanReprojectionError(const Landmark& landmark) const;
  /// Puts into the prior what the landmarks say that are anchored in the oldest frame and no longer
  /// tracked, and removes them. Those that are tracked on keep their other views and so must not
  /// enter it: their views would count twice (Leutenegger et al. 2015, section 3.4).
  void MarginalizeOldest();
  Linearization LinearizeAt(const PosePrior& prior) const;
  void AddToMarginalizer(const Landmark& landmark, const Linearization& at,
                         Marginalizer& marginalizer) const;
  void DropFrame(std::size_t index);
  Landmarks::iterator Erase(Landmarks::iterator landmark);

  StereoRig rig_;
  Eigen::Quaterniond calibrated_body_from_right_;
  SlidingWindowOptions options_;
  std::deque<Frame> frames_;
  Landmarks landmarks_;  // by a number of their own: a track may have had several
  std::unordered_map<int64_t, int64_t> landmark_of_track_;
  std::optional<PosePrior> prior_;
  int64_t next_frame_id_ = 0;
  int64_t next_landmark_id_ = 0;
};

}  // namespace gluevo::vo
