#include "gluevo/vo/pipeline/loop_config.h"

#include <algorithm>
#include <string>
#include <utility>

#include "gluevo/nn/error.h"
#include "gluevo/nn/weights.h"

namespace gluevo::vo {
namespace {

const WeightsRecord& RecordOfFeatures(const Networks& networks) {
  const auto found =
      std::find_if(networks.records.begin(), networks.records.end(), [](const auto& record) {
        return record.network == "superpoint" || record.network == "aliked";
      });
  if (found == networks.records.end()) {
    throw Error("loops need a network that finds keypoints; none was loaded");
  }
  return *found;
}

PlaceCodebook LoadCodebook(const LoopConfig& config, const WeightsRecord& features) {
  const nn::Weights file =
      config.codebook.empty() ? nn::OpenPlaceCodebook() : nn::ReadWeights(config.codebook);
  PlaceCodebook codebook = PlaceCodebook::FromWeights(file);
  if (codebook.of_weights() != features.checksum) {
    throw Error(file.source + " is not of the weights " + features.source +
                ": places cannot be told by it; expected a codebook that \"gluevo codebook\" made "
                "with these weights (--codebook), or --loops off");
  }
  return codebook;
}

}  // namespace

Networks LoadNetworksWithLoops(const FrontEndConfig& config) {
  config.Validate();
  return LoadNetworks(config.networks, config.features, MatcherOf(config.features, config.matcher));
}

LoopRecorder MakeLoopRecorder(const LoopConfig& config, const StereoRig& rig,
                              const Networks& networks, std::shared_ptr<FeatureExtractor> extractor,
                              nn::ThreadPool& pool) {
  return {rig, LoadCodebook(config, RecordOfFeatures(networks)), std::move(extractor),
          MakeMatcher(networks, pool), config.options};
}

}  // namespace gluevo::vo
