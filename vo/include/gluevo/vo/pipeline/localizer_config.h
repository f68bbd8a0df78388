#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "gluevo/nn/lightglue.h"
#include "gluevo/nn/thread_pool.h"
#include "gluevo/vo/mapping/loop_closer.h"
#include "gluevo/vo/mapping/map_localizer.h"
#include "gluevo/vo/mapping/place_map.h"
#include "gluevo/vo/pipeline/networks.h"

namespace gluevo::vo {

/// What finds frames in a map; the map says which network's features it has.
struct LocalizerConfig {
  NetworkFiles networks;
  std::string matcher;  ///< As in FrontEndConfig.
  /// As `gluevo codebook` writes it; empty: the built-in one.
  std::filesystem::path codebook;
  std::optional<float> keypoint_threshold;  ///< UsualKeypointThreshold where there is none.
  int max_keypoints = 500;
  nn::LightGlueOptions lightglue;
  LocalizationOptions options;
};

/// The pool must outlive it; `map_name` is for messages. Throws Error for options out of their
/// range, weights and codebooks that cannot be read, and a map of other weights' features.
MapLocalizer MakeMapLocalizer(const LocalizerConfig& config, PlaceMap map,
                              const std::string& map_name, nn::ThreadPool& pool);

/// One map of two: the places of `more` are looked for among those of `map` as a run's are. Where
/// none is found the parts of both stay apart. Throws Error naming `more_name` where it is of
/// another rig or of other weights' features than `map`, and as MakeMapLocalizer does.
PlaceMap MergeMaps(const LocalizerConfig& config, const LoopOptions& options, const PlaceMap& map,
                   const std::string& map_name, const PlaceMap& more, const std::string& more_name,
                   nn::ThreadPool& pool);

}  // namespace gluevo::vo
