#include <map>

#include "gluevo/vo/mapping/place_map.h"
#include "linked_segments.h"

namespace gluevo::vo {

std::vector<int> PlaceMap::Parts() const {
  const std::map<int, internal::LinkedSegment> segments = internal::LinkSegments(keyframes, loops);
  std::vector<int> parts;
  parts.reserve(keyframes.size());
  for (const LoopKeyframe& keyframe : keyframes) {
    parts.push_back(segments.at(keyframe.segment).root);
  }
  return parts;
}

int PlaceMap::LargestPart() const {
  std::map<int, std::size_t> sizes;
  for (const int part : Parts()) {
    ++sizes[part];
  }
  int largest = 0;
  for (const auto& [part, size] : sizes) {
    largest = size > sizes[largest] ? part : largest;
  }
  return largest;
}

}  // namespace gluevo::vo
