#pragma once

#include <cstddef>
#include <vector>

#include "gluevo/vo/frontend/matcher.h"
#include "gluevo/vo/mapping/global_adjustment.h"
#include "gluevo/vo/mapping/loop_closer.h"

namespace gluevo::vo::internal {

/// A keypoint of a key frame, by their indices.
struct KeyframeView {
  std::size_t keyframe = 0;
  std::size_t keypoint = 0;
};

/// A point of the scene and the key frames that see it, in their order, each at most once.
using GlobalTrack = std::vector<KeyframeView>;

/// By the matches between key frames that follow each other and those of loops. Points that one key
/// frame alone sees, that have no depth anywhere, or that matches give two places in one key frame,
/// are left out.
std::vector<GlobalTrack> FindTracks(const LoopCloser& closer,
                                    const std::vector<Rigid3>& world_from_body, Matcher& matcher,
                                    const GlobalAdjustmentOptions& options);

/// Where a key frame's keypoint that has a depth is, in the world.
Eigen::Vector3d PointInWorld(const LoopCloser& closer, const std::vector<Rigid3>& world_from_body,
                             const KeyframeView& view);

}  // namespace gluevo::vo::internal
