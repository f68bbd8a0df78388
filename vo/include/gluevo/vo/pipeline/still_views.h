#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <unordered_map>
#include <vector>

#include "gluevo/vo/core/map_point.h"
#include "gluevo/vo/core/rigid3.h"
#include "gluevo/vo/core/tracked_frame.h"

namespace gluevo::vo {

/// Whether tracks are where they were some time ago, so that a slow motion shows, too, once it has
/// gone on for long enough.
class StillViews {
 public:
  bool has_begun() const { return !rays_.empty(); }
  /// Later frames are compared with this one. `points`: of the map, by which it knows how far away
  /// its tracks are.
  void Begin(const TrackedFrame& frame, const std::vector<MapPoint>& points,
             const Rigid3& left_cam_from_world);
  void Clear() { rays_.clear(); }

  struct Still {
    double since_s = 0.0;
    /// How well the views know that, in the worst direction.
    double position_sigma_m = 0.0;
    double rotation_sigma_rad = 0.0;
  };
  /// By the motion of the left camera that explains best where the tracks of both frames went:
  /// nothing where it is more than their noise (as they show it, with outliers among them), and
  /// where few tracks are left.
  std::optional<Still> Compare(const TrackedFrame& frame) const;

 private:
  struct Ray {
    Eigen::Vector2d left;  // On the normalised plane.
    double inverse_depth;  // 1/m.
  };
  int64_t begin_ns_ = 0;
  std::unordered_map<int64_t, Ray> rays_;  // By track.
};

}  // namespace gluevo::vo
