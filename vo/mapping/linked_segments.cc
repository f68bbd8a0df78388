#include "linked_segments.h"

namespace gluevo::vo::internal {

std::map<int, LinkedSegment> LinkSegments(const std::vector<LoopKeyframe>& keyframes,
                                          const std::vector<Loop>& loops) {
  std::map<int, LinkedSegment> segments;
  for (const LoopKeyframe& keyframe : keyframes) {
    segments[keyframe.segment] = {keyframe.segment, {}};
  }
  // The oldest first, each takes those that hang on it; as many rounds as chains are long.
  for (bool is_changed = true; is_changed;) {
    is_changed = false;
    for (const Loop& loop : loops) {
      const LoopKeyframe& candidate = keyframes[loop.candidate];
      const LoopKeyframe& query = keyframes[loop.query];
      LinkedSegment& a = segments[candidate.segment];
      LinkedSegment& b = segments[query.segment];
      if (a.root == b.root) {
        continue;
      }
      const Rigid3 a_from_b = candidate.world_from_body * loop.measurement.candidate_from_query *
                              query.world_from_body.Inverse();
      if (a.root < b.root) {
        b = {a.root, a.root_from_segment * a_from_b};
      } else {
        a = {b.root, b.root_from_segment * a_from_b.Inverse()};
      }
      is_changed = true;
    }
  }
  return segments;
}

}  // namespace gluevo::vo::internal
