#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "gluevo/vo/io/dataset.h"

namespace gluevo::vo {

/// A point of the scene as one stereo frame sees it.
struct Observation {
  int64_t track_id = 0;  ///< The same in all frames that see the same point; never used again.
  Eigen::Vector2d left_pixel = Eigen::Vector2d::Zero();
  Eigen::Vector2d left = Eigen::Vector2d::Zero();  ///< Undistorted, on the normalised plane z = 1.
  bool has_right = false;
  Eigen::Vector2d right_pixel = Eigen::Vector2d::Zero();
  Eigen::Vector2d right = Eigen::Vector2d::Zero();  ///< The same in the right camera.
  float tracking_confidence = 0.0F;                 ///< 0 to 1; 0 for a new track.
  float stereo_confidence = 0.0F;                   ///< 0 to 1; 0 without a right observation.
};

/// What a front end makes of one stereo frame. At most one observation a track.
struct TrackedFrame {
  int64_t timestamp_ns = 0;
  std::vector<Observation> observations;
  std::map<std::string, double> stages_ms;  ///< Time spent by stage ("superpoint", ...).
};

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
