#include "gluevo/vo/frontend/superpoint_frontend.h"

#include <utility>
#include <vector>

#include "band_matching.h"
#include "gluevo/vo/core/options_check.h"
#include "gluevo/vo/core/stopwatch.h"

namespace gluevo::vo {
namespace {

KltOptions LeftOnly(KltOptions options) {
  options.stereo = false;
  return options;
}

}  // namespace

void SuperPointFrontEndOptions::Validate() const {
  klt.Validate();
  CheckWithin(max_ratio, 1e-3, 1.0, "max_ratio (--max-ratio)");
  CheckPositive(max_epipolar_error_px, "max_epipolar_error_px (--max-epipolar-error)");
  refinement.Validate("refinement");
  CheckPositive(max_refinement_px, "max_refinement_px");
}

SuperPointFrontEnd::SuperPointFrontEnd(const StereoRig& rig,
                                       std::unique_ptr<FeatureExtractor> extractor,
                                       const SuperPointFrontEndOptions& options)
    : rig_(rig),
      epipolar_(rig),
      extractor_(std::move(extractor)),
      options_(options),
      klt_(rig, LeftOnly(options.klt)) {
  options_.Validate();
}

TrackedFrame SuperPointFrontEnd::Track(const StereoFrame& frame) {
  TrackedFrame tracked = klt_.Track(frame);
  frame_ = frame;
  return MatchRight(std::move(tracked));
}

std::optional<TrackedFrame> SuperPointFrontEnd::Retry() {
  std::optional<TrackedFrame> tracked = klt_.Retry();
  if (!tracked) {
    return std::nullopt;
  }
  return MatchRight(*std::move(tracked));
}

TrackedFrame SuperPointFrontEnd::MatchRight(TrackedFrame result) {
  Stopwatch watch;
  const auto count = static_cast<Eigen::Index>(result.observations.size());
  nn::Features::Points pixels(count, 2);
  std::vector<Eigen::Vector2d> left_rays;
  left_rays.reserve(result.observations.size());
  for (Eigen::Index i = 0; i < count; ++i) {
    pixels.row(i) = result.observations[i].left_pixel.cast<float>().transpose();
    left_rays.push_back(result.observations[i].left);
  }
  const nn::Features left = extractor_->Describe(frame_.images[0], pixels);
  const nn::Features right = extractor_->Extract(frame_.images[1]);
  result.stages_ms[extractor_->Name()] = watch.Lap();

  const std::vector<Eigen::Vector2d> right_rays = RaysOf(right, rig_.cameras[1]);
  const nn::Matches matches = MatchInBand(left, left_rays, right, right_rays, epipolar_,
                                          options_.max_epipolar_error_px, options_.max_ratio);
  for (std::size_t i = 0; i < result.observations.size(); ++i) {
    const int match = matches.matches0[i];
    if (match >= 0) {
      Observation& observation = result.observations[i];
      observation.has_right = true;
      observation.right_pixel = right.keypoints.row(match).transpose().cast<double>();
      observation.right = right_rays[match];
      observation.stereo_confidence = matches.scores0[i];
    }
  }
  result.stages_ms["match_stereo"] = watch.Lap();
  if (options_.refine) {
    Refine(frame_, result);
    result.stages_ms["refine"] = watch.Lap();
  }
  return result;
}

void SuperPointFrontEnd::Refine(const StereoFrame& images, TrackedFrame& frame) const {
  std::vector<cv::Point2f> pixels;
  std::vector<cv::Point2f> guesses;
  std::vector<Observation*> stereo;
  for (Observation& observation : frame.observations) {
    if (observation.has_right) {
      pixels.emplace_back(observation.left_pixel.x(), observation.left_pixel.y());
      guesses.emplace_back(observation.right_pixel.x(), observation.right_pixel.y());
      stereo.push_back(&observation);
    }
  }
  const auto pyramid = [&](int camera) {
    return MakePyramid(images.images[camera], options_.refinement.window,
                       options_.refinement.levels);
  };
  const Flow flow = FollowBothWays(pyramid(0), pyramid(1), pixels, guesses, options_.refinement);
  for (std::size_t i = 0; i < stereo.size(); ++i) {
    Observation& observation = *stereo[i];
    const Eigen::Vector2d found = ToEigen(flow.pixels[i]);
    const bool is_near = (found - observation.right_pixel).norm() <= options_.max_refinement_px;
    observation.right_pixel = found;
    observation.right = rig_.cameras[1].Undistort(found);
    if (flow.found[i] == 0 || !is_near ||
        !epipolar_.Allows(observation.left, observation.right, options_.max_epipolar_error_px)) {
      observation.has_right = false;
      observation.right_pixel.setZero();
      observation.right.setZero();
      observation.stereo_confidence = 0.0F;
    }
  }
}

}  // namespace gluevo::vo
