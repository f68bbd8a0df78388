#pragma once

#include <cstddef>
#include <filesystem>
#include <string>
#include <vector>

#include "gluevo/vo/core/rigid3.h"
#include "gluevo/vo/geometry/stereo_rig.h"
#include "gluevo/vo/mapping/loop_closer.h"
#include "gluevo/vo/mapping/loop_consistency.h"
#include "gluevo/vo/mapping/loop_keyframe.h"

namespace gluevo::vo {

/// Whose features the key frames of a map have.
struct MapFeatures {
  std::string network;   ///< "superpoint" or "aliked".
  std::string source;    ///< The weights' file, or "built-in NAME"; for messages.
  std::string checksum;  ///< SHA-256 of the weights.
};

/// What runs have kept to come back to.
struct PlaceMap {
  MapFeatures features;
  StereoRig rig;
  /// Segment after segment, in order of time in each: as LoopCloser has them. Segments are numbered
  /// from 0 on.
  std::vector<LoopKeyframe> keyframes;
  std::vector<Loop> loops;
  /// Of each key frame the pose that fits odometry and loops, metres. Segments that loops link are
  /// one part of the map; its frame is the world of the part's oldest segment.
  std::vector<Rigid3> map_from_body;

  /// Of each key frame the part that it belongs to, by the number of the part's oldest segment.
  std::vector<int> Parts() const;
  /// The part with the most key frames, the oldest of those that are equally large; 0 of an empty
  /// map.
  int LargestPart() const;
};

/// What is kept, at these poses (closer.Optimized(), or better ones); segments get numbers without
/// gaps.
PlaceMap MakePlaceMap(const LoopCloser& closer, const std::vector<Rigid3>& map_from_body,
                      const MapFeatures& features);

/// Whether rays and depths of the one are those of the other, to half a pixel and a millimetre.
bool IsSameRig(const StereoRig& a, const StereoRig& b);

/// Writes a map beside its place, then renames: it is there whole or not at all. Descriptors are
/// kept in 8 bits a value, pixels in steps of 1/65535 of the image's longer side, and a key frame
/// in at most 118 kB: of one with more keypoints those without depth go first, then the weakest.
/// Throws Error where it cannot be written.
void WritePlaceMap(const std::filesystem::path& path, const PlaceMap& map);

/// Reads such a file. Throws Error naming the file, the byte and what is wrong with it: cut short,
/// changed (by its checksum), of another version, or with values that no map has.
PlaceMap ReadPlaceMap(const std::filesystem::path& path);

/// The same from memory; `source` names it in messages.
PlaceMap ParsePlaceMap(const void* bytes, std::size_t size, const std::string& source);

/// Throws Error naming both where a map's features are of other weights than `features`.
void CheckMapFeatures(const PlaceMap& map, const std::string& map_name,
                      const MapFeatures& features);

}  // namespace gluevo::vo
