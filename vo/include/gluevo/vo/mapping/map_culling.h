#pragma once

#include "gluevo/vo/mapping/place_map.h"

namespace gluevo::vo {

/// When other key frames show what one shows (Mur-Artal et al. 2015, section VI-E, by where points
/// are instead of who has matched them).
struct MapCullingOptions {
  bool is_on = true;
  /// A key frame goes where this share of its points with depth ...
  double min_share = 0.9;
  /// ... is in the left images of so many others of its part of the map, ...
  int min_views = 3;
  /// ... which see them from a direction that differs by less than this, degrees, ...
  double max_angle_deg = 15.0;
  /// ... from at most so many times as far or as near, and ...
  double max_scale = 1.3;
  /// ... are turned by less than this, degrees.
  double max_turn_deg = 30.0;

  /// Throws Error naming the option.
  void Validate() const;
};

/// The map without the key frames that others make needless: it grows with the space that was
/// seen, not with time. What older key frames show is what counts. A loop to one that goes leads to
/// the nearest that stays, by where the map has the two, so that parts hang together as before.
/// Throws Error for options out of their range.
PlaceMap CullPlaceMap(PlaceMap map, const MapCullingOptions& options);

}  // namespace gluevo::vo
