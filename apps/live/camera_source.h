#pragma once

#include <array>
#include <memory>
#include <opencv2/core/mat.hpp>
#include <string>
#include <vector>

#include "frame_source.h"
#include "video_device.h"

namespace gluevo::apps {

struct CameraSourceOptions {
  /// Left and right, or one that shows both side by side.
  std::vector<std::string> cameras;
  /// A camera that is gone is waited for so long, seconds.
  double give_up_s = 30.0;
};

/// Cameras. One that is gone is opened again when it is back.
class CameraSource final : public LiveSource {
 public:
  /// Throws Error naming the camera that cannot be opened, or gives no image.
  CameraSource(CameraSourceOptions options, OpenVideo open, SourceClock clock);

  /// Throws Error where the cameras are gone for too long, and where images are not of the size
  /// that they were at first.
  SourceEvent Next() override;
  int64_t Now() const override { return clock_.now_ns(); }
  SourceCounts counts() const override { return counts_; }

  /// Of each of the two images.
  cv::Size image_size() const { return size_; }

 private:
  struct Taken {
    int64_t stamp_ns = 0;
    std::array<cv::Mat, 2> images;
  };

  bool Open();
  /// Nothing where a camera is gone, whose name is then `gone_`.
  std::optional<Taken> Take();
  bool Grab(std::size_t camera);
  bool GrabMates();
  SourceEvent TryAgain();
  void CheckSizes(const Taken& taken);

  CameraSourceOptions options_;
  OpenVideo open_;
  SourceClock clock_;
  std::vector<std::unique_ptr<VideoDevice>> devices_;
  std::vector<int64_t> stamps_;
  std::optional<int64_t> last_left_ns_;
  int64_t interval_ns_ = 0;  // From frame to frame, 0 until it is known.
  std::string gone_;         // Which camera is; empty while all is well.
  int64_t gone_since_ns_ = 0;
  cv::Size size_;
  SourceCounts counts_;
};

}  // namespace gluevo::apps
