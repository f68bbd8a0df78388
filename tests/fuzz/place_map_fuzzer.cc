#include <cmath>
#include <cstddef>
#include <cstdint>
#include <string>

#include "gluevo/nn/error.h"
#include "place_map_layout.h"

// The file as it is, whose checksum keeps changed ones out, and as the body of one whose checksum
// is right.

namespace {

using namespace gluevo;

void CheckMap(const vo::PlaceMap& map) {
  if (map.map_from_body.size() != map.keyframes.size()) {
    __builtin_trap();
  }
  for (const vo::LoopKeyframe& keyframe : map.keyframes) {
    if (keyframe.keypoints.size() != static_cast<std::size_t>(keyframe.features.size()) ||
        !keyframe.features.descriptors.allFinite() || !keyframe.features.keypoints.allFinite() ||
        !keyframe.world_from_body.translation.allFinite()) {
      __builtin_trap();
    }
  }
  if (map.Parts().size() != map.keyframes.size() || map.LargestPart() < 0) {
    __builtin_trap();
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, std::size_t size) {
  try {
    CheckMap(vo::ParsePlaceMap(data, size, "file"));
  } catch (const Error&) {  // The one answer that a broken file may get.
  }
  try {
    // The checksum of a seed does not matter.
    const std::size_t header = size < vo::place_map::kHeaderSize ? 0 : vo::place_map::kHeaderSize;
    CheckMap(vo::place_map::ParseBody(nn::Bytes(data + header, size - header, "file"), "file"));
  } catch (const Error&) {
  }
  return 0;
}
