#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <opencv2/core/mat.hpp>
#include <optional>
#include <string>

namespace gluevo::apps {

/// A camera, or a pipeline that gives images.
class VideoDevice {
 public:
  VideoDevice() = default;
  VideoDevice(const VideoDevice&) = delete;
  VideoDevice& operator=(const VideoDevice&) = delete;
  virtual ~VideoDevice() = default;

  /// Takes the next image, waiting for it a second or two at most. False where none comes any more.
  virtual bool Grab() = 0;
  /// Of the image that was taken last: when, on the steady clock, nanoseconds; nothing where the
  /// driver does not say.
  virtual std::optional<int64_t> StampNs() = 0;
  /// That image, gray, 8 bits; false where it cannot be had.
  virtual bool Retrieve(cv::Mat& gray) = 0;
};

/// Null where it cannot be opened.
using OpenVideo = std::function<std::unique_ptr<VideoDevice>(const std::string& source)>;

/// Opens by OpenCV: "/dev/video0" or "0" by V4L2, what has a '!' in it as a pipeline of GStreamer.
/// OpenCV's part for that, with the hundred libraries it needs, is loaded by the first call. Throws
/// Error where it is not there.
std::unique_ptr<VideoDevice> OpenVideoDevice(const std::string& source);

}  // namespace gluevo::apps
