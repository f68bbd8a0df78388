#include "gluevo/vo/pipeline/frontend_config.h"

#include <utility>

#include "gluevo/nn/option_error.h"
#include "gluevo/vo/frontend/network_matcher.h"
#include "gluevo/vo/frontend/network_memo.h"
#include "name_check.h"

namespace gluevo::vo {
namespace {

std::unique_ptr<FrontEnd> MakeUnguarded(const FrontEndConfig& config, const StereoRig& rig,
                                        const Networks& networks, nn::ThreadPool& pool,
                                        std::shared_ptr<FeatureExtractor> shared) {
  if (config.method == "klt") {
    return std::make_unique<KltFrontEnd>(rig, config.klt);
  }
  std::unique_ptr<FeatureExtractor> extractor;
  const bool asks_on_another_thread =
      config.method == "superglue" && config.learned.network_lag > 0;
  if (shared != nullptr && !asks_on_another_thread) {
    extractor = std::make_unique<SharedExtractor>(std::move(shared));
  } else {
    extractor = MakeFrontEndExtractor(config, networks, pool);
  }
  if (config.method == "superpoint") {
    SuperPointFrontEndOptions options = config.stereo;
    options.klt = config.klt;
    options.max_epipolar_error_px = config.learned.max_epipolar_error_px;
    options.refine = config.refine == "lk";
    return std::make_unique<SuperPointFrontEnd>(rig, std::move(extractor), options);
  }
  LearnedFrontEndOptions learned = config.learned;
  learned.refine = config.refine == "lk";
  learned.stereo_in_band = config.stereo_matching == "band";
  learned.begin_at_corners = config.features == "aliked";
  return std::make_unique<LearnedFrontEnd>(rig, std::move(extractor),
                                           MakeMatcher(networks, pool, config.lightglue),
                                           MakeNearestNeighborMatcher(), learned);
}

}  // namespace

void FrontEndConfig::Validate() const {
  CheckName(method, {"superglue", "superpoint", "klt"}, "method");
  // The other methods have no matcher that could fail to fit.
  CheckNetworkNames(features, method == "superglue" ? matcher : "");
  CheckName(refine, {"none", "subpixel", "lk"}, "refine");
  CheckName(stereo_matching, {"band", "network"}, "stereo_matching");
  if (features == "aliked" && refine == "subpixel") {
    throw OptionError(
        "option refine is \"subpixel\", which refines SuperPoint's keypoints: for features "
        "\"aliked\", which are refined already, expected none or lk");
  }
  CheckName(networks.precision, {"float", "bf16"}, "precision");
  keypoints.Validate();
  lightglue.Validate();
  learned.Validate();
  stereo.Validate();
  klt.Validate();
  freeze.Validate();
}

std::string MatcherOf(const FrontEndConfig& config) {
  return config.method == "superglue" ? MatcherOf(config.features, config.matcher) : "";
}

Networks LoadFrontEndNetworks(const FrontEndConfig& config) {
  config.Validate();
  if (config.method == "klt") {
    return {};
  }
  return LoadNetworks(config.networks, config.features, MatcherOf(config));
}

std::unique_ptr<FeatureExtractor> MakeFrontEndExtractor(const FrontEndConfig& config,
                                                        const Networks& networks,
                                                        nn::ThreadPool& pool) {
  KeypointOptions keypoints = config.keypoints;
  keypoints.subpixel = config.refine == "subpixel";
  return MakeExtractor(networks, keypoints, pool);
}

std::unique_ptr<FrontEnd> MakeFrontEnd(const FrontEndConfig& config, const StereoRig& rig,
                                       const Networks& networks, nn::ThreadPool& pool,
                                       std::shared_ptr<FeatureExtractor> extractor) {
  config.Validate();
  return std::make_unique<FreezeGuard>(
      MakeUnguarded(config, rig, networks, pool, std::move(extractor)), config.freeze);
}

}  // namespace gluevo::vo
