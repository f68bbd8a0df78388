#include "gluevo/vo/learned_frontend.h"

#include <algorithm>
#include <numeric>
#include <utility>

#include "gluevo/nn/error.h"
#include "stopwatch.h"

namespace gluevo::vo {
namespace {

Eigen::Vector2d PixelOf(const nn::Features& features, int keypoint) {
  return features.keypoints.row(keypoint).transpose().cast<double>();
}

void CheckSize(const cv::Mat& image, const Camera& camera, const char* side) {
  if (image.cols != camera.width || image.rows != camera.height) {
    throw Error(std::string("the ") + side + " image has " + std::to_string(image.cols) + " x " +
                std::to_string(image.rows) + " pixels, its camera " + std::to_string(camera.width) +
                " x " + std::to_string(camera.height));
  }
}

}  // namespace

void LearnedFrontEndOptions::Validate() const {
  for (const auto& [name, threshold] :
       {std::pair{"tracking", tracking_threshold}, std::pair{"stereo", stereo_threshold}}) {
    if (!(threshold >= 0.0F && threshold < 1.0F)) {
      throw Error(std::string(name) + " threshold " + std::to_string(threshold) +
                  " is out of range: expected 0 or more and below 1");
    }
  }
  if (!(max_epipolar_error_px > 0.0)) {
    throw Error("largest epipolar error " + std::to_string(max_epipolar_error_px) +
                " px is out of range: expected above 0");
  }
  if (!(min_distance_px >= 0.0)) {
    throw Error("minimum distance " + std::to_string(min_distance_px) +
                " px is out of range: expected 0 or more");
  }
}

LearnedFrontEnd::LearnedFrontEnd(const StereoRig& rig, std::unique_ptr<FeatureExtractor> extractor,
                                 std::unique_ptr<Matcher> matcher,
                                 std::unique_ptr<Matcher> fallback,
                                 const LearnedFrontEndOptions& options)
    : rig_(rig),
      epipolar_(rig),
      extractor_(std::move(extractor)),
      matcher_(std::move(matcher)),
      fallback_(std::move(fallback)),
      options_(options) {
  options_.Validate();
}

TrackedFrame LearnedFrontEnd::Track(const StereoFrame& frame) {
  CheckSize(frame.images[0], rig_.cameras[0], "left");
  CheckSize(frame.images[1], rig_.cameras[1], "right");
  stages_ms_.clear();
  retried_ = false;
  timestamp_ns_ = frame.timestamp_ns;

  Stopwatch watch;
  const nn::Features left = extractor_->Extract(frame.images[0]);
  nn::Features right = extractor_->Extract(frame.images[1]);
  stages_ms_["superpoint"] = watch.Lap();

  previous_ = std::move(current_);
  const nn::Matches from_previous =
      matcher_->Match(previous_.features, left, options_.tracking_threshold);
  current_ = ContinueTracks(left, from_previous);
  stages_ms_["superglue_track"] = watch.Lap();

  right_ = MatchStereo(left, std::move(right));
  stages_ms_["superglue_stereo"] = watch.Lap();
  return Observe();
}

std::optional<TrackedFrame> LearnedFrontEnd::Retry() {
  if (retried_ || fallback_ == nullptr) {
    return std::nullopt;
  }
  retried_ = true;
  Stopwatch watch;
  current_ = ContinueTracks(current_.features,
                            fallback_->Match(previous_.features, current_.features, 0.0F));
  stages_ms_["superglue_track"] += watch.Lap();
  return Observe();
}

LearnedFrontEnd::LeftImage LearnedFrontEnd::ContinueTracks(const nn::Features& features,
                                                           const nn::Matches& from_previous) {
  const auto count = static_cast<std::size_t>(features.size());
  LeftImage image{features, std::vector<int64_t>(count, -1), std::vector<int>(count, 1),
                  std::vector<float>(count, 0.0F)};
  for (std::size_t i = 0; i < from_previous.matches0.size(); ++i) {
    const int match = from_previous.matches0[i];
    if (match >= 0) {
      image.track_ids[match] = previous_.track_ids[i];
      image.track_lengths[match] = previous_.track_lengths[i] + 1;
      image.track_confidences[match] = from_previous.scores0[i];
    }
  }
  for (int64_t& track_id : image.track_ids) {
    track_id = track_id < 0 ? next_track_id_++ : track_id;
  }
  return image;
}

LearnedFrontEnd::RightViews LearnedFrontEnd::MatchStereo(const nn::Features& left,
                                                         nn::Features right) {
  RightViews views{std::move(right), {}};
  views.matches = matcher_->Match(left, views.features, options_.stereo_threshold);
  for (int i = 0; i < left.size(); ++i) {
    int& match = views.matches.matches0[i];
    if (match < 0) {
      continue;
    }
    const Eigen::Vector2d in_left = rig_.cameras[0].Undistort(PixelOf(left, i));
    const Eigen::Vector2d in_right = rig_.cameras[1].Undistort(PixelOf(views.features, match));
    // Also false where a pixel is beyond the camera model and has no ray.
    const bool on_line = epipolar_.Distance(in_left, in_right) <= options_.max_epipolar_error_px;
    if (!on_line || !epipolar_.InFront(in_left, in_right, options_.max_epipolar_error_px)) {
      match = -1;
      views.matches.scores0[i] = 0.0F;
    }
  }
  return views;
}

TrackedFrame LearnedFrontEnd::Observe() const {
  const nn::Features& features = current_.features;
  std::vector<int> order(static_cast<std::size_t>(features.size()));
  std::iota(order.begin(), order.end(), 0);
  std::stable_sort(order.begin(), order.end(), [&](int i, int j) {
    return current_.track_lengths[i] > current_.track_lengths[j];
  });

  TrackedFrame frame{timestamp_ns_, {}, stages_ms_};
  const double min_squared_distance = options_.min_distance_px * options_.min_distance_px;
  for (const int i : order) {
    Observation observation;
    observation.left_pixel = PixelOf(features, i);
    const auto is_close = [&](const Observation& other) {
      return (other.left_pixel - observation.left_pixel).squaredNorm() < min_squared_distance;
    };
    if (std::any_of(frame.observations.begin(), frame.observations.end(), is_close)) {
      continue;
    }
    observation.track_id = current_.track_ids[i];
    observation.left = rig_.cameras[0].Undistort(observation.left_pixel);
    observation.tracking_confidence = current_.track_confidences[i];
    if (const int match = right_.matches.matches0[i]; match >= 0) {
      observation.has_right = true;
      observation.right_pixel = PixelOf(right_.features, match);
      observation.right = rig_.cameras[1].Undistort(observation.right_pixel);
      observation.stereo_confidence = right_.matches.scores0[i];
    }
    frame.observations.push_back(observation);
  }
  return frame;
}

}  // namespace gluevo::vo
