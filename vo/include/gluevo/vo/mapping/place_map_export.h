#pragma once

#include "gluevo/vo/core/trajectory.h"
#include "gluevo/vo/mapping/map.h"
#include "gluevo/vo/mapping/place_map.h"

namespace gluevo::vo {

/// The keypoints of known depth as points, and the key frames, for WritePly: a part of the map is a
/// segment here. Points are gray by their inverse depth where they were seen: near ones bright.
Map SparseMapOf(const PlaceMap& map);

/// The key frames of one part, in order of time; of several with the same time the first.
Trajectory KeyframesOf(const PlaceMap& map, int part);

}  // namespace gluevo::vo
