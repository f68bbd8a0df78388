#include "gluevo/vo/geometry/triangulation.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <vector>

#include "gluevo/vo/core/options_check.h"
#include "gluevo/vo/core/reference_focal.h"
#include "gluevo/vo/geometry/eigen_solvers.h"
#include "gluevo/vo/geometry/projection.h"

namespace gluevo::vo {
namespace {

// Smallest cosine between two rays to the point: the widest parallax.
double MinRayCosine(std::span<const PosedObservation> views, const Eigen::Vector3d& point) {
  std::vector<Eigen::Vector3d> rays;
  rays.reserve(views.size());
  for (const PosedObservation& view : views) {
    rays.push_back((point - view.cam_from_world.Inverse().translation).normalized());
  }
  double cosine = 1.0;
  for (std::size_t i = 0; i < rays.size(); ++i) {
    for (std::size_t j = 0; j < i; ++j) {
      cosine = std::min(cosine, rays[i].dot(rays[j]));
    }
  }
  return cosine;
}

Eigen::Vector4d LinearTriangulation(std::span<const PosedObservation> views) {
  Eigen::Matrix4d normal = Eigen::Matrix4d::Zero();
  for (const PosedObservation& view : views) {
    const Eigen::Matrix<double, 3, 4> p = view.cam_from_world.Matrix();
    for (int axis = 0; axis < 2; ++axis) {
      const Eigen::Vector4d row = (view.normalized[axis] * p.row(2) - p.row(axis)).transpose();
      normal += row * row.transpose();
    }
  }
  return SmallestEigenvector(normal);
}

// Gauss-Newton on the reprojection error; false where the point leaves the front of a camera.
bool Refine(std::span<const PosedObservation> views, Eigen::Vector3d& point) {
  constexpr int kIterations = 4;
  for (int iteration = 0; iteration < kIterations; ++iteration) {
    Eigen::Matrix3d hessian = Eigen::Matrix3d::Zero();
    Eigen::Vector3d gradient = Eigen::Vector3d::Zero();
    for (const PosedObservation& view : views) {
      const Eigen::Vector3d in_cam = view.cam_from_world * point;
      if (!IsInFront(in_cam)) {
        return false;
      }
      const Eigen::Matrix<double, 2, 3> jacobian =
          ProjectionJacobian(in_cam) * view.cam_from_world.rotation.toRotationMatrix();
      hessian += jacobian.transpose() * jacobian;
      gradient += jacobian.transpose() * (in_cam.hnormalized() - view.normalized);
    }
    const Eigen::Vector3d step = hessian.ldlt().solve(gradient);
    if (!step.allFinite()) {
      return false;
    }
    point -= step;
    if (step.norm() < 1e-9 * point.norm()) {
      break;
    }
  }
  return true;
}

}  // namespace

void TriangulationOptions::Validate() const {
  CheckPositive(min_depth_m, "triangulation.min_depth_m");
  CheckPositive(max_depth_m, "triangulation.max_depth_m");
  CheckPositive(min_parallax_px, "triangulation.min_parallax_px");
  CheckPositive(max_error_px, "triangulation.max_error_px");
}

std::optional<Eigen::Vector3d> Triangulate(std::span<const PosedObservation> views,
                                           const TriangulationOptions& options) {
  if (views.size() < 2) {
    return std::nullopt;
  }
  // In the first view's frame, where the numbers are small however far the world's origin is.
  std::vector<PosedObservation> local(views.begin(), views.end());
  const Rigid3 world_from_first = views[0].cam_from_world.Inverse();
  for (PosedObservation& view : local) {
    view.cam_from_world = view.cam_from_world * world_from_first;
  }
  const Eigen::Vector4d homogeneous = LinearTriangulation(local);
  if (!homogeneous.allFinite() || homogeneous.w() == 0.0) {
    return std::nullopt;
  }
  Eigen::Vector3d point = homogeneous.hnormalized();
  if (!Refine(local, point) || !point.allFinite()) {
    return std::nullopt;
  }
  for (const PosedObservation& view : local) {
    const Eigen::Vector3d in_cam = view.cam_from_world * point;
    if (!(in_cam.z() >= options.min_depth_m && in_cam.z() <= options.max_depth_m) ||
        !((in_cam.hnormalized() - view.normalized).norm() <=
          FromReferencePx(options.max_error_px))) {
      return std::nullopt;
    }
  }
  if (MinRayCosine(local, point) > std::cos(FromReferencePx(options.min_parallax_px))) {
    return std::nullopt;
  }
  return world_from_first * point;
}

}  // namespace gluevo::vo
