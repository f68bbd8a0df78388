#pragma once

#include <filesystem>
#include <memory>

#include "gluevo/nn/thread_pool.h"
#include "gluevo/vo/frontend/matcher.h"
#include "gluevo/vo/geometry/stereo_rig.h"
#include "gluevo/vo/mapping/loop_closer.h"
#include "gluevo/vo/mapping/loop_recorder.h"
#include "gluevo/vo/pipeline/frontend_config.h"
#include "gluevo/vo/pipeline/networks.h"

namespace gluevo::vo {

/// Whether and how a run looks for places that it has seen before.
struct LoopConfig {
  bool is_on = false;
  /// As `gluevo codebook` writes it for the network that finds keypoints; empty: the built-in one,
  /// which is that of the built-in SuperPoint.
  std::filesystem::path codebook;
  LoopOptions options;
};

/// The networks that front end and loops need together. Throws Error as LoadNetworks does.
Networks LoadNetworksWithLoops(const FrontEndConfig& config);

/// The part that a run's loops need. `extractor`: the front end's, where it has one of its own
/// features. The pool must outlive it. Throws Error naming both where the codebook is of other
/// weights than those that were loaded.
LoopRecorder MakeLoopRecorder(const LoopConfig& config, const StereoRig& rig,
                              const Networks& networks, std::shared_ptr<FeatureExtractor> extractor,
                              nn::ThreadPool& pool);

}  // namespace gluevo::vo
