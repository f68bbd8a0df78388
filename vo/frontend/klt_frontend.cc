#include "gluevo/vo/frontend/klt_frontend.h"

#include <algorithm>
#include <opencv2/calib3d.hpp>
#include <opencv2/imgproc.hpp>
#include <string>
#include <utility>

#include "gluevo/vo/core/options_check.h"
#include "gluevo/vo/core/reference_focal.h"
#include "gluevo/vo/core/stopwatch.h"
#include "gluevo/vo/frontend/optical_flow.h"
#include "wide_flow.h"

namespace gluevo::vo {
namespace {

bool IsInside(const cv::Point2f& pixel, const cv::Size& size, int border) {
  return pixel.x >= border && pixel.y >= border && pixel.x < size.width - border &&
         pixel.y < size.height - border;
}

Flow FollowCorners(const Pyramid& from, const Pyramid& to, const std::vector<cv::Point2f>& pixels,
                   const std::vector<cv::Point2f>& guesses, const KltOptions& options,
                   bool finely) {
  // On the way back the search starts at the answer: one level less coarse is enough to tell
  // whether the point returns.
  constexpr int kLevelsBack = 1;
  Flow flow =
      FollowBothWays(from, to, pixels, guesses,
                     {options.window, options.levels, kLevelsBack, options.max_return_distance});
  finely = finely && MedianFlowSigma(from, pixels, flow, options.refinement.window) <=
                         options.max_refinement_sigma_px;
  if (finely) {
    flow = FollowFinely(from, to, pixels, flow, options.refinement, options.max_refinement_px);
  }
  for (std::size_t i = 0; i < pixels.size(); ++i) {
    flow.found[i] =
        flow.found[i] != 0 && IsInside(flow.pixels[i], to.front().size(), options.border);
  }
  return flow;
}

}  // namespace

void KltOptions::Validate() const {
  CheckAtLeast(max_corners, 1, "klt.max_corners (--klt-corners)");
  CheckAtLeast(min_distance, 1, "klt.min_distance");
  CheckWithin(quality, 1e-9, 1.0, "klt.quality");
  CheckAtLeast(window, 3, "klt.window");
  CheckAtLeast(levels, 0, "klt.levels");
  CheckPositive(max_return_distance, "klt.max_return_distance");
  refinement.Validate("klt.refinement");
  CheckPositive(max_refinement_px, "klt.max_refinement_px");
  CheckPositive(max_refinement_sigma_px, "klt.max_refinement_sigma_px");
  CheckAtLeast(border, 0, "klt.border");
  CheckPositive(max_epipolar_error_px, "klt.max_epipolar_error_px");
  CheckPositive(fundamental_distance, "klt.fundamental_distance");
}

KltFrontEnd::KltFrontEnd(const StereoRig& rig, const KltOptions& options)
    : rig_(rig), epipolar_(rig), options_(options) {
  options_.Validate();
}

TrackedFrame KltFrontEnd::Track(const StereoFrame& frame) {
  // Of a frame that is refused nothing stays.
  std::optional<ExpectedView> expected = std::exchange(expected_, std::nullopt);
  CheckImages(frame, rig_);
  expected_ = std::move(expected);
  Stopwatch watch;
  std::swap(left_, last_left_);
  RemakePyramid(frame.images[0], options_.window, options_.levels, left_);
  if (options_.stereo) {
    RemakePyramid(frame.images[1], options_.window, options_.levels, right_);
  }
  timestamp_ns_ = frame.timestamp_ns;
  has_retried_ = false;
  last_tracks_ = std::move(tracks_);
  TurnLast();
  FollowFromWhereSeen();
  const double track_ms = watch.Lap();
  TrackedFrame result = Complete();
  result.stages_ms["klt_track"] = track_ms;
  return result;
}

std::optional<TrackedFrame> KltFrontEnd::Retry() {
  if (last_tracks_.empty()) {
    return std::nullopt;
  }
  Stopwatch watch;
  if (expected_ && has_retried_) {
    // As if nothing were known of the camera's motion.
    expected_.reset();
    has_retried_ = false;
    TurnLast();
    Follow(GuessByMotion());
  } else if (has_retried_ || (frames_since_last_ == 1 && !expected_)) {
    return std::nullopt;
  } else {
    has_retried_ = true;
    const bool is_expected = KnowsPoints() || !turned_.empty();
    Follow(GuessByDescriptors(From().front(), left_.front(), FromPixels(),
                              is_expected ? GuessWhereExpected() : GuessByMotion()));
  }
  const double track_ms = watch.Lap();
  TrackedFrame result = Complete();
  result.stages_ms["klt_track"] = track_ms;
  return result;
}

TrackedFrame KltFrontEnd::Complete() {
  TrackedFrame result;
  result.timestamp_ns = timestamp_ns_;
  Stopwatch watch;
  AddCorners(left_.front());
  result.stages_ms["klt_detect"] = watch.Lap();
  MatchStereo(result);
  result.stages_ms["klt_stereo"] = watch.Lap();
  return result;
}

void KltFrontEnd::Accept(const FrameOutcome& outcome) {
  expected_.reset();
  if (outcome.is_passed_over) {
    std::swap(left_, last_left_);
    tracks_ = std::move(last_tracks_);
    ++frames_since_last_;
  } else {
    frames_since_last_ = 1;
  }
}

std::vector<cv::Point2f> KltFrontEnd::PixelsOf(const std::vector<Corner>& corners) {
  std::vector<cv::Point2f> pixels;
  pixels.reserve(corners.size());
  for (const Corner& corner : corners) {
    pixels.push_back(corner.pixel);
  }
  return pixels;
}

void KltFrontEnd::Follow(const std::vector<cv::Point2f>& guesses) {
  const auto frames = static_cast<float>(frames_since_last_);
  const Flow flow = FollowCorners(From(), left_, FromPixels(), guesses, options_, KnowsPoints());
  std::vector<Corner> before;
  tracks_.clear();
  for (std::size_t i = 0; i < last_tracks_.size(); ++i) {
    const Corner& last = last_tracks_[i];
    if (flow.found[i] != 0) {
      before.push_back(last);
      tracks_.push_back(
          {last.id, last.length + 1, flow.pixels[i], (flow.pixels[i] - last.pixel) / frames});
    }
  }
  if (options_.reject_by_fundamental) {
    RejectByFundamental(before);
  }
}

void KltFrontEnd::RejectByFundamental(const std::vector<Corner>& before) {
  constexpr std::size_t kFewest = 8;
  if (tracks_.size() < kFewest) {
    return;
  }
  // Without distortion, at VINS-Fusion's virtual focal length.
  const auto undistort = [&](const cv::Point2f& pixel) {
    const Eigen::Vector2d point = kReferenceFocalPx * rig_.cameras[0].Undistort(ToEigen(pixel));
    return cv::Point2d(point.x(), point.y());
  };
  std::vector<cv::Point2d> points0, points1;
  for (std::size_t i = 0; i < tracks_.size(); ++i) {
    points0.push_back(undistort(before[i].pixel));
    points1.push_back(undistort(tracks_[i].pixel));
  }
  std::vector<uchar> inliers;
  cv::findFundamentalMat(points0, points1, cv::FM_RANSAC, options_.fundamental_distance, 0.99,
                         inliers);
  if (inliers.size() != tracks_.size()) {
    return;
  }
  std::vector<Corner> kept;
  for (std::size_t i = 0; i < tracks_.size(); ++i) {
    if (inliers[i] != 0) {
      kept.push_back(tracks_[i]);
    }
  }
  tracks_ = std::move(kept);
}

void KltFrontEnd::AddCorners(const cv::Mat& image) {
  std::stable_sort(tracks_.begin(), tracks_.end(),
                   [](const Corner& a, const Corner& b) { return a.length > b.length; });
  cv::Mat mask(image.size(), CV_8UC1, cv::Scalar(255));
  std::vector<Corner> kept;
  for (const Corner& track : tracks_) {
    if (mask.at<uchar>(track.pixel) != 0) {
      kept.push_back(track);
      cv::circle(mask, track.pixel, options_.min_distance, cv::Scalar(0), cv::FILLED);
    }
  }
  tracks_ = std::move(kept);
  const int missing = options_.max_corners - static_cast<int>(tracks_.size());
  if (missing <= 0) {
    return;
  }
  std::vector<cv::Point2f> corners;
  cv::goodFeaturesToTrack(image, corners, missing, options_.quality, options_.min_distance, mask);
  for (const cv::Point2f& corner : corners) {
    tracks_.push_back({next_id_++, 1, corner});
  }
}

void KltFrontEnd::MatchStereo(TrackedFrame& result) const {
  const std::vector<cv::Point2f> pixels = PixelsOf(tracks_);
  const Flow flow = options_.stereo
                        ? FollowCorners(left_, right_, pixels, pixels, options_, KnowsPoints())
                        : Flow{pixels, std::vector<uchar>(pixels.size(), 0)};
  for (std::size_t i = 0; i < tracks_.size(); ++i) {
    Observation observation;
    observation.track_id = tracks_[i].id;
    observation.left_pixel = ToEigen(tracks_[i].pixel);
    observation.left = rig_.cameras[0].Undistort(observation.left_pixel);
    if (!observation.left.allFinite()) {
      continue;  // Beyond the camera model there is no ray.
    }
    observation.tracking_confidence = tracks_[i].length > 1 ? 1.0F : 0.0F;
    const Eigen::Vector2d right_pixel = ToEigen(flow.pixels[i]);
    const Eigen::Vector2d in_right = rig_.cameras[1].Undistort(right_pixel);
    if (flow.found[i] != 0 &&
        epipolar_.Allows(observation.left, in_right, options_.max_epipolar_error_px)) {
      observation.has_right = true;
      observation.right_pixel = right_pixel;
      observation.right = in_right;
      observation.stereo_confidence = 1.0F;
    }
    result.observations.push_back(observation);
  }
}

}  // namespace gluevo::vo
