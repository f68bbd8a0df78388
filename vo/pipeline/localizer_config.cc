#include "gluevo/vo/pipeline/localizer_config.h"

#include <memory>
#include <utility>

#include "gluevo/nn/error.h"
#include "gluevo/vo/mapping/loop_closer.h"
#include "gluevo/vo/pipeline/loop_config.h"

namespace gluevo::vo {
namespace {

Networks LoadNetworksOf(const LocalizerConfig& config, const PlaceMap& map,
                        const std::string& map_name) {
  const std::string& features = map.features.network;
  if (features != "superpoint" && features != "aliked") {
    throw Error(map_name + ": a map of the features of " + Quoted(features) +
                ", which this version does not know; expected superpoint or aliked");
  }
  Networks networks = LoadNetworks(config.networks, features, MatcherOf(features, config.matcher));
  CheckMapFeatures(map, map_name, FeaturesOf(networks.records));
  return networks;
}

}  // namespace

MapLocalizer MakeMapLocalizer(const LocalizerConfig& config, PlaceMap map,
                              const std::string& map_name, nn::ThreadPool& pool) {
  const Networks networks = LoadNetworksOf(config, map, map_name);
  const KeypointOptions keypoints = {.keypoint_threshold = config.keypoint_threshold.value_or(
                                         UsualKeypointThreshold(map.features.network)),
                                     .max_keypoints = config.max_keypoints};
  PlaceCodebook codebook = LoadCodebook(config.codebook, map.features);
  return {std::move(map), std::move(codebook), MakeExtractor(networks, keypoints, pool),
          MakeMatcher(networks, pool, config.lightglue), config.options};
}

PlaceMap MergeMaps(const LocalizerConfig& config, const LoopOptions& options, const PlaceMap& map,
                   const std::string& map_name, const PlaceMap& more, const std::string& more_name,
                   nn::ThreadPool& pool) {
  const Networks networks = LoadNetworksOf(config, map, map_name);
  CheckMapFeatures(more, more_name, map.features);
  if (!IsSameRig(map.rig, more.rig)) {
    throw Error(more_name + ": a map of another rig than " + map_name +
                "; expected maps that were made with the same calibration");
  }
  LoopCloser closer(map.rig, LoadCodebook(config.codebook, map.features),
                    MakeMatcher(networks, pool, config.lightglue), options);
  closer.Load(map.keyframes, map.loops);
  const int first = map.keyframes.empty() ? 0 : map.keyframes.back().segment + 1;
  for (LoopKeyframe keyframe : more.keyframes) {
    keyframe.segment += first;
    closer.Add(std::move(keyframe));
  }
  return MakePlaceMap(closer, closer.Optimized(), map.features);
}

}  // namespace gluevo::vo
