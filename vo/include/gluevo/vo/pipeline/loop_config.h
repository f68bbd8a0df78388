#pragma once

#include <filesystem>
#include <memory>
#include <vector>

#include "gluevo/nn/thread_pool.h"
#include "gluevo/vo/frontend/matcher.h"
#include "gluevo/vo/geometry/stereo_rig.h"
#include "gluevo/vo/mapping/loop_closer.h"
#include "gluevo/vo/mapping/loop_recorder.h"
#include "gluevo/vo/mapping/place_codebook.h"
#include "gluevo/vo/mapping/place_map.h"
#include "gluevo/vo/pipeline/frontend_config.h"
#include "gluevo/vo/pipeline/networks.h"

namespace gluevo::vo {

/// Whether and how a run looks for places that it has seen before.
struct LoopConfig {
  bool is_on = false;
  /// As `gluevo codebook` writes it for the network that finds keypoints; empty: the built-in one,
  /// which is that of the built-in SuperPoint.
  std::filesystem::path codebook;
  /// A map (place_map.h) whose places the run may come back to; empty: none.
  std::filesystem::path load_map;
  LoopOptions options;
  /// Whether all key frames are adjusted together in the end (AdjustGlobally).
  bool has_final_adjustment = false;
};

/// The networks that front end and loops need together. Throws Error as LoadNetworks does.
Networks LoadNetworksWithLoops(const FrontEndConfig& config);

/// The network that finds the keypoints. Throws Error where none was loaded.
MapFeatures FeaturesOf(const std::vector<WeightsRecord>& records);

/// The places' descriptors for these features. `codebook`: as in LoopConfig. Throws Error naming
/// both where it is of other weights.
PlaceCodebook LoadCodebook(const std::filesystem::path& codebook, const MapFeatures& features);

/// The part that a run's loops need. `extractor`: the front end's, where it has one of its own
/// features. The pool must outlive it. Throws Error naming both where the codebook or the map is of
/// other weights than those that were loaded, or the map of another rig.
LoopRecorder MakeLoopRecorder(const LoopConfig& config, const StereoRig& rig,
                              const Networks& networks, std::shared_ptr<FeatureExtractor> extractor,
                              nn::ThreadPool& pool);

}  // namespace gluevo::vo
