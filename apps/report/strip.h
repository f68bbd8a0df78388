#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <string>
#include <unordered_map>
#include <vector>

#include "gluevo/vo/io/dataset.h"
#include "gluevo/vo/pipeline/odometry.h"

namespace gluevo::apps {

/// Where something was and where it is, in pixels of the original image.
struct PixelMotion {
  Eigen::Vector2f from = Eigen::Vector2f::Zero();
  Eigen::Vector2f to = Eigen::Vector2f::Zero();
};

/// A frame of the run as the report shows it.
struct StripFrame {
  std::size_t index = 0;  ///< Of the frame in the run.
  int64_t timestamp_ns = 0;
  bool is_reset = false;      ///< Tracking was lost here: the frame starts a new segment.
  int width = 0, height = 0;  ///< Of the original images, pixels.
  std::vector<uint8_t> left_jpeg, right_jpeg;
  std::vector<PixelMotion> tracked;         ///< In the left image, from the frame before.
  std::vector<Eigen::Vector2f> new_points;  ///< In the left image, tracks that start here.
  std::vector<PixelMotion> stereo;          ///< From the left image's place to the right image's.
};

/// Picks a few frames spread evenly over a run, and the first few at which tracking was lost, and
/// keeps these with their images; of all others it keeps nothing.
class StripRecorder {
 public:
  /// `frames`: of the run; 0 where nobody knows how many there will be.
  explicit StripRecorder(std::size_t frames);

  /// To be called for every frame in turn.
  void Add(const vo::FrameResult& result, const std::function<vo::StereoFrame()>& images);

  const std::vector<StripFrame>& frames() const { return frames_; }

 private:
  bool IsChosen() const;
  void Thin();

  std::size_t count_;                // of the run; 0: not known
  std::size_t every_ = 1;            // one is kept where it is not
  std::size_t index_ = 0;            // of the next frame
  std::vector<std::size_t> resets_;  // the frames that are kept for one
  int segment_ = 0;
  std::unordered_map<int64_t, Eigen::Vector2f> last_left_;  // by track
  std::vector<StripFrame> frames_;
};

/// The strip as HTML figures: each frame's left image with the motion of its tracks, and its right
/// image with the way from the left image's places.
std::string DrawStrip(const std::vector<StripFrame>& frames, int64_t start_ns);

}  // namespace gluevo::apps
