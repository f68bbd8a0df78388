#include "camera_source.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <utility>

#include "gluevo/nn/error.h"
#include "gluevo/vo/core/seconds.h"
#include "gluevo/vo/core/text.h"

namespace gluevo::apps {
namespace {

constexpr int64_t kTryAgainNs = 200'000'000;

std::string SizeText(const cv::Size& size) {
  return std::to_string(size.width) + "x" + std::to_string(size.height);
}

}  // namespace

CameraSource::CameraSource(CameraSourceOptions options, OpenVideo open, SourceClock clock)
    : options_(std::move(options)),
      open_(std::move(open)),
      clock_(std::move(clock)),
      stamps_(options_.cameras.size()) {
  if (!Open()) {
    throw Error(gone_ +
                ": cannot be opened as a camera; expected a device of V4L2 as /dev/video0, "
                "or a pipeline of GStreamer");
  }
  const std::optional<Taken> first = Take();
  if (!first) {
    throw Error(gone_ + ": gives no images");
  }
  size_ = first->images[0].size();
  CheckSizes(*first);
}

bool CameraSource::Open() {
  devices_.clear();
  for (const std::string& camera : options_.cameras) {
    devices_.push_back(open_(camera));
    if (devices_.back() == nullptr) {
      gone_ = camera;
      devices_.clear();
      return false;
    }
  }
  last_left_ns_.reset();
  return true;
}

bool CameraSource::Grab(std::size_t camera) {
  if (!devices_[camera]->Grab()) {
    gone_ = options_.cameras[camera];
    return false;
  }
  const std::optional<int64_t> stamp_ns = devices_[camera]->StampNs();
  stamps_[camera] = stamp_ns ? *stamp_ns : clock_.now_ns();
  return true;
}

// Where one camera is a frame behind the other its older image has no mate.
bool CameraSource::GrabMates() {
  constexpr int kTries = 4;
  for (int i = 0; i < kTries && interval_ns_ > 0; ++i) {
    const int64_t behind_ns = stamps_[1] - stamps_[0];
    if (std::abs(behind_ns) <= interval_ns_ / 2) {
      return true;
    }
    ++counts_.frames_unpaired;
    if (!Grab(behind_ns > 0 ? 0 : 1)) {
      return false;
    }
  }
  return true;
}

std::optional<CameraSource::Taken> CameraSource::Take() {
  for (std::size_t i = 0; i < devices_.size(); ++i) {
    if (!Grab(i)) {
      return std::nullopt;
    }
  }
  if (devices_.size() == 2 && !GrabMates()) {
    return std::nullopt;
  }
  if (last_left_ns_ && stamps_[0] > *last_left_ns_) {
    const int64_t interval_ns = stamps_[0] - *last_left_ns_;
    interval_ns_ = interval_ns_ == 0 ? interval_ns : std::min(interval_ns_, interval_ns);
  }
  last_left_ns_ = stamps_[0];
  Taken taken{stamps_[0], {}};
  for (std::size_t i = 0; i < devices_.size(); ++i) {
    if (!devices_[i]->Retrieve(taken.images[i])) {
      gone_ = options_.cameras[i];
      return std::nullopt;
    }
  }
  if (devices_.size() == 1) {
    const cv::Mat both = taken.images[0];
    const int width = both.cols / 2;
    taken.images = {both.colRange(0, width).clone(), both.colRange(width, 2 * width).clone()};
  }
  return taken;
}

void CameraSource::CheckSizes(const Taken& taken) {
  for (std::size_t i = 0; i < 2; ++i) {
    if (taken.images[i].size() != size_) {
      throw Error(options_.cameras[std::min(i, options_.cameras.size() - 1)] +
                  ": gives images of " + SizeText(taken.images[i].size()) + "; expected " +
                  SizeText(size_) + ", as the first one was");
    }
  }
}

SourceEvent CameraSource::TryAgain() {
  SourceEvent event;
  const double gone_s = vo::SecondsBetween(gone_since_ns_, clock_.now_ns());
  if (gone_s > options_.give_up_s) {
    throw Error(gone_ + ": the camera is gone for more than " + vo::ShortText(options_.give_up_s) +
                " s");
  }
  const std::string gone = gone_;
  if (Open()) {
    gone_.clear();
    event.warning = gone + ": the camera is back after " +
                    vo::ShortText(0.1 * std::round(10.0 * gone_s)) + " s";
  } else {
    clock_.sleep_until(clock_.now_ns() + kTryAgainNs);
  }
  return event;
}

SourceEvent CameraSource::Next() {
  if (!gone_.empty()) {
    return TryAgain();
  }
  SourceEvent event;
  std::optional<Taken> taken = Take();
  if (!taken) {
    ++counts_.cameras_gone;
    gone_since_ns_ = clock_.now_ns();
    devices_.clear();
    event.warning = gone_ + ": the camera is gone, it is waited for";
    return event;
  }
  CheckSizes(*taken);
  event.frame = vo::StereoFrame{taken->stamp_ns, std::move(taken->images)};
  return event;
}

}  // namespace gluevo::apps
