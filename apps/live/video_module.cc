// The part of gluevo that needs OpenCV's videoio, in a module of its own that is loaded when a
// camera is asked for.

#include <dlfcn.h>

#include <cmath>
#include <cstdlib>
#include <ctime>
#include <opencv2/core/utils/logger.hpp>
#include <opencv2/imgproc.hpp>
#include <opencv2/videoio.hpp>

#include "video_device.h"

namespace gluevo::apps {
namespace {

int64_t MonotonicNs() {
  timespec now = {};
  clock_gettime(CLOCK_MONOTONIC, &now);
  return int64_t{1'000'000'000} * now.tv_sec + now.tv_nsec;
}

// A pipeline that ends in nothing gets an end that keeps the newest image only.
std::string WithSink(const std::string& pipeline) {
  return pipeline.find("appsink") != std::string::npos
             ? pipeline
             : pipeline +
                   " ! videoconvert ! video/x-raw,format=GRAY8 ! appsink max-buffers=2 drop=true";
}

// What GStreamer says of a pipeline that ends before it has begun, in tens of lines, is of its
// insides. Its library is there where OpenCV brings it.
void QuietenGStreamer() {
  using Handler = void (*)(const char*, int, const char*, void*);
  void* const glib = dlopen("libglib-2.0.so.0", RTLD_LAZY | RTLD_NOLOAD);
  void* const set_handler = glib != nullptr ? dlsym(glib, "g_log_set_default_handler") : nullptr;
  if (set_handler != nullptr) {
    // As POSIX has it.
    reinterpret_cast<Handler (*)(Handler, void*)>(set_handler)(
        [](const char*, int, const char*, void*) {}, nullptr);
  }
}

// Asked of the same library: OpenCV would wait for the images of what is left of a pipeline with an
// element that is not there.
bool IsPipeline(const std::string& pipeline) {
  void* const gstreamer = dlopen("libgstreamer-1.0.so.0", RTLD_LAZY | RTLD_NOLOAD);
  if (gstreamer == nullptr) {
    return true;  // OpenCV has to know.
  }
  using Init = void (*)(int*, char***);
  using Parse = void* (*)(const char*, void*, int, void**);
  using Unref = void (*)(void*);
  // As POSIX has it.
  const auto init = reinterpret_cast<Init>(dlsym(gstreamer, "gst_init"));
  const auto parse = reinterpret_cast<Parse>(dlsym(gstreamer, "gst_parse_launch_full"));
  const auto unref = reinterpret_cast<Unref>(dlsym(gstreamer, "gst_object_unref"));
  if (init == nullptr || parse == nullptr || unref == nullptr) {
    return true;
  }
  constexpr int kAllErrorsAreFatal = 1;
  init(nullptr, nullptr);
  void* const parsed = parse(pipeline.c_str(), nullptr, kAllErrorsAreFatal, nullptr);
  if (parsed != nullptr) {
    unref(parsed);
  }
  return parsed != nullptr;
}

bool OpenCapture(const std::string& source, cv::VideoCapture& capture) {
  if (source.find('!') != std::string::npos) {
    const std::string pipeline = WithSink(source);
    return IsPipeline(pipeline) && capture.open(pipeline, cv::CAP_GSTREAMER);
  }
  // Seconds until a camera that gives no images is taken for gone.
  setenv("OPENCV_VIDEOIO_V4L_SELECT_TIMEOUT", "2", /*overwrite=*/0);
  const bool is_number = source.find_first_not_of("0123456789") == std::string::npos;
  return capture.open(is_number ? "/dev/video" + source : source, cv::CAP_V4L2);
}

class CaptureDevice final : public VideoDevice {
 public:
  explicit CaptureDevice(cv::VideoCapture capture) : capture_(std::move(capture)) {}

  bool Grab() override { return capture_.grab(); }

  std::optional<int64_t> StampNs() override {
    if (capture_.getBackendName() != "V4L2") {
      return std::nullopt;
    }
    const auto stamp =
        static_cast<int64_t>(std::llround(1e6 * capture_.get(cv::CAP_PROP_POS_MSEC)));
    // Drivers that stamp by another clock, or not at all, are of no use here.
    constexpr int64_t kSecond = 1'000'000'000;
    const int64_t age = MonotonicNs() - stamp;
    return age >= 0 && age < kSecond ? std::optional(stamp) : std::nullopt;
  }

  bool Retrieve(cv::Mat& gray) override {
    cv::Mat image;
    if (!capture_.retrieve(image) || image.empty()) {
      return false;
    }
    if (image.channels() == 1) {
      gray = image.clone();  // The next image may take its place.
    } else {
      gray = cv::Mat();
      cv::cvtColor(image, gray, image.channels() == 4 ? cv::COLOR_BGRA2GRAY : cv::COLOR_BGR2GRAY);
    }
    return gray.type() == CV_8UC1;
  }

 private:
  cv::VideoCapture capture_;
};

}  // namespace
}  // namespace gluevo::apps

// The caller owns what it gets; null where the source cannot be opened.
extern "C" __attribute__((visibility("default"))) gluevo::apps::VideoDevice* GluevoOpenVideo(
    const char* source) {
  try {
    // What is wrong is told by gluevo.
    cv::utils::logging::setLogLevel(cv::utils::logging::LOG_LEVEL_ERROR);
    gluevo::apps::QuietenGStreamer();
    cv::VideoCapture capture;
    if (!gluevo::apps::OpenCapture(source, capture)) {
      return nullptr;
    }
    return new gluevo::apps::CaptureDevice(std::move(capture));
  } catch (const std::exception&) {
    return nullptr;
  }
}
