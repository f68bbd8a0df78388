#pragma once

#include <Eigen/Core>
#include <cstdint>

namespace gluevo::vo {

/// A point of the scene and the track that shows it.
struct MapPoint {
  int64_t track_id = 0;
  Eigen::Vector3d point_in_world = Eigen::Vector3d::Zero();  ///< Metres.
};

}  // namespace gluevo::vo
