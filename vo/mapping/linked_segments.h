#pragma once

#include <map>
#include <vector>

#include "gluevo/vo/mapping/loop_consistency.h"

namespace gluevo::vo::internal {

/// Segments that loops link: of each segment the oldest one that it hangs together with, and where
/// its world is in that one's.
struct LinkedSegment {
  int root = 0;
  Rigid3 root_from_segment;
};

/// One a segment that the key frames name.
std::map<int, LinkedSegment> LinkSegments(const std::vector<LoopKeyframe>& keyframes,
                                          const std::vector<Loop>& loops);

}  // namespace gluevo::vo::internal
