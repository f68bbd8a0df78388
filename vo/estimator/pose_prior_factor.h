#pragma once

#include <ceres/cost_function.h>

#include <Eigen/Core>

#include "gluevo/vo/estimator/pose_prior.h"

namespace gluevo::vo {

/// The prior as a residual of bundle adjustment. Parameters: world_from_body of each of the prior's
/// frames (PoseParameters), then the turn on top of `turn_so_far`, which is that since the prior's
/// linearisation point.
class PosePriorFactor final : public ceres::CostFunction {
 public:
  /// Keeps a reference: `prior` must outlive the factor.
  PosePriorFactor(const PosePrior& prior);
  bool Evaluate(double const* const* parameters, double* residuals,
                double** jacobians) const override;

 private:
  const PosePrior& prior_;
};

}  // namespace gluevo::vo
