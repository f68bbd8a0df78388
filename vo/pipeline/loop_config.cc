#include "gluevo/vo/pipeline/loop_config.h"

#include <algorithm>
#include <string>
#include <utility>

#include "gluevo/nn/error.h"
#include "gluevo/nn/weights.h"

namespace gluevo::vo {

MapFeatures FeaturesOf(const std::vector<WeightsRecord>& records) {
  const auto found = std::find_if(records.begin(), records.end(), [](const auto& record) {
    return record.network == "superpoint" || record.network == "aliked";
  });
  if (found == records.end()) {
    throw Error("loops need a network that finds keypoints; none was loaded");
  }
  return {found->network, found->source, found->checksum};
}

PlaceCodebook LoadCodebook(const std::filesystem::path& codebook, const MapFeatures& features) {
  const nn::Weights file = codebook.empty() ? nn::OpenPlaceCodebook() : nn::ReadWeights(codebook);
  PlaceCodebook places = PlaceCodebook::FromWeights(file);
  if (places.of_weights() != features.checksum) {
    throw Error(file.source + " is not of the weights " + features.source +
                "; expected one by gluevo codebook (--codebook)");
  }
  return places;
}

Networks LoadNetworksWithLoops(const FrontEndConfig& config) {
  config.Validate();
  return LoadNetworks(config.networks, config.features, MatcherOf(config.features, config.matcher));
}

LoopRecorder MakeLoopRecorder(const LoopConfig& config, const StereoRig& rig,
                              const Networks& networks, std::shared_ptr<FeatureExtractor> extractor,
                              nn::ThreadPool& pool) {
  const MapFeatures features = FeaturesOf(networks.records);
  LoopRecorder recorder(rig, LoadCodebook(config.codebook, features), std::move(extractor),
                        MakeMatcher(networks, pool), config.options);
  if (!config.load_map.empty()) {
    const PlaceMap map = ReadPlaceMap(config.load_map);
    CheckMapFeatures(map, config.load_map.string(), features);
    recorder.Load(map, config.load_map.string());
  }
  return recorder;
}

}  // namespace gluevo::vo
