#include "gluevo/vo/pipeline/still_views.h"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "gluevo/vo/core/median.h"
#include "gluevo/vo/core/reference_focal.h"
#include "gluevo/vo/core/seconds.h"
#include "gluevo/vo/geometry/eigen_solvers.h"

namespace gluevo::vo {
namespace {

using Twist = Eigen::Matrix<double, 6, 1>;  // Position, then rotation, of the camera.

struct Displacement {
  Eigen::Matrix<double, 2, 6> by_twist;
  Eigen::Vector2d moved;
};

// Where a point goes on the normalised plane when the camera moves a little.
Eigen::Matrix<double, 2, 6> ByTwist(const Eigen::Vector2d& at, double inverse_depth) {
  const double u = at.x();
  const double v = at.y();
  Eigen::Matrix<double, 2, 6> by_twist;
  by_twist << -inverse_depth, 0.0, u * inverse_depth, u * v, -1.0 - u * u, v,  //
      0.0, -inverse_depth, v * inverse_depth, 1.0 + v * v, -u * v, -u;
  return by_twist;
}

// One standard deviation of an axis, were nothing moving.
double NoiseOf(const std::vector<Displacement>& displacements) {
  std::vector<double> sizes;
  sizes.reserve(2 * displacements.size());
  for (const Displacement& displacement : displacements) {
    sizes.push_back(std::abs(displacement.moved.x()));
    sizes.push_back(std::abs(displacement.moved.y()));
  }
  constexpr double kSigmaByMedian = 1.4826;
  constexpr double kLeastPx = 0.05;  // Of optical flow.
  return std::max(FromReferencePx(kLeastPx), kSigmaByMedian * Median(std::move(sizes)));
}

}  // namespace

void StillViews::Begin(const TrackedFrame& frame, const std::vector<MapPoint>& points,
                       const Rigid3& left_cam_from_world) {
  begin_ns_ = frame.timestamp_ns;
  rays_.clear();
  std::unordered_map<int64_t, double> inverse_depths;
  for (const MapPoint& point : points) {
    const double depth = (left_cam_from_world * point.point_in_world).z();
    if (depth > 0.0) {
      inverse_depths[point.track_id] = 1.0 / depth;
    }
  }
  for (const Observation& observation : frame.observations) {
    const auto depth = inverse_depths.find(observation.track_id);
    if (depth != inverse_depths.end()) {
      rays_[observation.track_id] = {observation.left, depth->second};
    }
  }
}

std::optional<StillViews::Still> StillViews::Compare(const TrackedFrame& frame) const {
  constexpr std::size_t kFewest = 20;
  constexpr double kOutlier = 3.0;     // Standard deviations.
  constexpr double kLargest = 22.458;  // Chi-square of six, 99.9 %.
  std::vector<Displacement> displacements;
  displacements.reserve(rays_.size());
  for (const Observation& observation : frame.observations) {
    const auto ray = rays_.find(observation.track_id);
    if (ray != rays_.end()) {
      displacements.push_back({ByTwist(ray->second.left, ray->second.inverse_depth),
                               observation.left - ray->second.left});
    }
  }
  if (displacements.size() < kFewest) {
    return std::nullopt;
  }
  const double noise = NoiseOf(displacements);
  Eigen::Matrix<double, 6, 6> information = Eigen::Matrix<double, 6, 6>::Zero();
  Twist slope = Twist::Zero();
  for (const auto& [by_twist, moved] : displacements) {
    if (moved.norm() < kOutlier * noise) {
      information += by_twist.transpose() * by_twist / (noise * noise);
      slope += by_twist.transpose() * moved / (noise * noise);
    }
  }
  const Eigen::LDLT<Eigen::Matrix<double, 6, 6>> factors(information);
  if (factors.info() != Eigen::Success || !factors.isPositive() ||
      !(slope.dot(factors.solve(slope)) < kLargest)) {
    return std::nullopt;
  }
  const Eigen::Matrix<double, 6, 6> covariance = information.inverse();
  return Still{SecondsBetween(begin_ns_, frame.timestamp_ns),
               WorstSigma(covariance.topLeftCorner<3, 3>()),
               WorstSigma(covariance.bottomRightCorner<3, 3>())};
}

}  // namespace gluevo::vo
