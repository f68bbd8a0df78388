#include "gluevo/vo/pipeline/frontend_config.h"

#include <algorithm>
#include <initializer_list>
#include <utility>

#include "gluevo/nn/error.h"
#include "gluevo/vo/frontend/network_matcher.h"

namespace gluevo::vo {
namespace {

void CheckName(const std::string& value, std::initializer_list<const char*> expected,
               const std::string& option) {
  if (std::find(expected.begin(), expected.end(), value) != expected.end()) {
    return;
  }
  std::string names;
  for (const char* const name : expected) {
    names += (names.empty() ? "" : ", ") + std::string(name);
  }
  throw Error("option " + option + " is " + Quoted(value) + "; expected one of " + names);
}

std::unique_ptr<FrontEnd> MakeUnguarded(const FrontEndConfig& config, const StereoRig& rig,
                                        const Networks& networks, nn::ThreadPool& pool) {
  if (config.method == "klt") {
    return std::make_unique<KltFrontEnd>(rig, config.klt);
  }
  nn::SuperPointOptions superpoint = config.superpoint;
  superpoint.subpixel = config.refine == "subpixel";
  std::unique_ptr<FeatureExtractor> extractor = MakeExtractor(networks, superpoint, pool);
  if (config.method == "superpoint") {
    SuperPointFrontEndOptions options = config.stereo;
    options.klt = config.klt;
    options.max_epipolar_error_px = config.learned.max_epipolar_error_px;
    options.refine = config.refine == "lk";
    return std::make_unique<SuperPointFrontEnd>(rig, std::move(extractor), options);
  }
  LearnedFrontEndOptions learned = config.learned;
  learned.refine = config.refine == "lk";
  return std::make_unique<LearnedFrontEnd>(rig, std::move(extractor), MakeMatcher(networks, pool),
                                           MakeNearestNeighborMatcher(), learned);
}

}  // namespace

void FrontEndConfig::Validate() const {
  CheckName(method, {"superglue", "superpoint", "klt"}, "method");
  CheckName(matcher, {"superglue", "nn"}, "matcher");
  CheckName(refine, {"none", "subpixel", "lk"}, "refine");
  CheckName(networks.precision, {"float", "bf16"}, "precision");
  superpoint.Validate();
  learned.Validate();
  stereo.Validate();
  klt.Validate();
  freeze.Validate();
}

Networks LoadFrontEndNetworks(const FrontEndConfig& config) {
  if (config.method == "klt") {
    return {};
  }
  return LoadNetworks(config.networks,
                      config.method == "superglue" && config.matcher == "superglue");
}

std::unique_ptr<FrontEnd> MakeFrontEnd(const FrontEndConfig& config, const StereoRig& rig,
                                       const Networks& networks, nn::ThreadPool& pool) {
  config.Validate();
  return std::make_unique<FreezeGuard>(MakeUnguarded(config, rig, networks, pool), config.freeze);
}

}  // namespace gluevo::vo
