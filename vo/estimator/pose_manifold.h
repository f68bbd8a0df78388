#pragma once

#include <ceres/manifold.h>

#include <array>

#include "gluevo/vo/core/rigid3.h"
#include "gluevo/vo/geometry/manifold.h"

namespace gluevo::vo {

/// A pose as the solver sees it: position (metres), then the quaternion x, y, z, w.
using PoseParameters = std::array<double, 7>;

PoseParameters ToParameters(const Rigid3& pose);
Rigid3 ToRigid3(const double* parameters);

/// Poses [p, q] with PoseTangent, by Plus and Minus of manifold.h.
class PoseManifold final : public ceres::Manifold {
 public:
  static constexpr int kAmbientSize = 7;

  int AmbientSize() const override { return kAmbientSize; }
  int TangentSize() const override { return kPoseTangentSize; }
  bool Plus(const double* x, const double* delta, double* x_plus_delta) const override;
  bool PlusJacobian(const double* x, double* jacobian) const override;
  bool Minus(const double* y, const double* x, double* y_minus_x) const override;
  bool MinusJacobian(const double* x, double* jacobian) const override;
};

}  // namespace gluevo::vo
