#pragma once

#include <ceres/ceres.h>

#include <Eigen/Core>
#include <array>
#include <optional>

#include "gluevo/vo/core/pose_covariance.h"
#include "gluevo/vo/core/rigid3.h"
#include "gluevo/vo/mapping/pose_graph.h"

/// Poses and measured motions as Ceres takes them.
namespace gluevo::vo::internal {

/// Position, and quaternion as Eigen stores it.
inline constexpr int kPoseSize = 7;
using PoseParameters = std::array<double, kPoseSize>;

Rigid3 PoseOf(const double* parameters);
PoseParameters ParametersOf(const Rigid3& pose);

/// W with W^T W the inverse of the edge's covariance. Throws Error where that is none.
Eigen::Matrix<double, 6, 6> Whitening(const PoseGraphEdge& edge);

/// The poses' error against a measured motion, whitened.
class EdgeCost : public ceres::SizedCostFunction<6, kPoseSize, kPoseSize> {
 public:
  explicit EdgeCost(const PoseGraphEdge& edge)
      : a_from_b_(edge.a_from_b), whitening_(Whitening(edge)) {}
  bool Evaluate(double const* const* poses, double* residuals, double** jacobians) const override;

 private:
  Rigid3 a_from_b_;
  Eigen::Matrix<double, 6, 6> whitening_;
};

/// Position in the world and turn in the body; with an axis turns about that only.
class PoseManifold : public ceres::Manifold {
 public:
  explicit PoseManifold(const std::optional<Eigen::Vector3d>& axis_in_world)
      : axis_in_world_(axis_in_world) {}

  int AmbientSize() const override { return kPoseSize; }
  int TangentSize() const override { return axis_in_world_ ? 4 : 6; }
  bool Plus(const double* x, const double* delta, double* sum) const override;
  bool PlusJacobian(const double* x, double* jacobian) const override;
  bool Minus(const double* y, const double* x, double* difference) const override;
  bool MinusJacobian(const double* x, double* jacobian) const override;

 private:
  using Jacobian = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
  using Turns = Eigen::Matrix<double, 3, Eigen::Dynamic, Eigen::ColMajor, 3, 3>;

  /// Columns: the turns in the body that are allowed, of unit length.
  Turns TurnsOf(const Eigen::Quaterniond& rotation) const;

  std::optional<Eigen::Vector3d> axis_in_world_;
};

}  // namespace gluevo::vo::internal
