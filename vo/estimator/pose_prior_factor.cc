#include "pose_prior_factor.h"

#include <cmath>

#include "pose_manifold.h"

namespace gluevo::vo {
namespace {

constexpr int kPose = PosePrior::kPose;
constexpr int kTurn = PosePrior::kTurn;

// d Log(exp(v) exp(d)) / d d at d = 0: the inverse of the right Jacobian of SO(3) (Forster et al.
// 2017, eq. 8 and following).
Eigen::Matrix3d InverseRightJacobian(const Eigen::Vector3d& v) {
  const double angle = v.norm();
  const Eigen::Matrix3d cross = Skew(v);
  // (1 - (a / 2) cot(a / 2)) / a^2, by its series near 0.
  const double quadratic = angle < 1e-3
                               ? 1.0 / 12.0 + angle * angle / 720.0
                               : (1.0 - 0.5 * angle / std::tan(0.5 * angle)) / (angle * angle);
  return Eigen::Matrix3d::Identity() + 0.5 * cross + quadratic * cross * cross;
}

}  // namespace

PosePriorFactor::PosePriorFactor(const PosePrior& prior, const Eigen::Quaterniond& body_from_right)
    : prior_(prior), turn_so_far_(TurnBetween(prior.body_from_right, body_from_right)) {
  for (std::size_t i = 0; i < prior.frame_ids.size(); ++i) {
    mutable_parameter_block_sizes()->push_back(PoseManifold::kAmbientSize);
  }
  mutable_parameter_block_sizes()->push_back(kTurn);
  set_num_residuals(static_cast<int>(prior.residual.size()));
}

bool PosePriorFactor::Evaluate(double const* const* parameters, double* residuals,
                               double** jacobians) const {
  using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
  const std::size_t frames = prior_.frame_ids.size();
  Eigen::VectorXd delta(prior_.jacobian.cols());
  for (std::size_t i = 0; i < frames; ++i) {
    delta.segment<kPose>(kPose * i) = Minus(ToRigid3(parameters[i]), prior_.world_from_body[i]);
  }
  delta.tail<kTurn>() = turn_so_far_ + Eigen::Map<const Eigen::Vector3d>(parameters[frames]);
  Eigen::Map<Eigen::VectorXd> residual(residuals, num_residuals());
  residual = prior_.residual + prior_.jacobian * delta;
  if (jacobians == nullptr) {
    return true;
  }
  for (std::size_t i = 0; i < frames; ++i) {
    if (jacobians[i] == nullptr) {
      continue;
    }
    Eigen::Matrix<double, kPose, PoseManifold::kAmbientSize, Eigen::RowMajor> minus;
    PoseManifold().MinusJacobian(parameters[i], minus.data());
    Eigen::Matrix<double, kPose, kPose> by_step = Eigen::Matrix<double, kPose, kPose>::Identity();
    by_step.bottomRightCorner<3, 3>() = InverseRightJacobian(delta.segment<3>(kPose * i + 3));
    Eigen::Map<RowMajor> jacobian(jacobians[i], num_residuals(), PoseManifold::kAmbientSize);
    jacobian = prior_.jacobian.middleCols<kPose>(kPose * i) * by_step * minus;
  }
  if (jacobians[frames] != nullptr) {
    Eigen::Map<RowMajor> jacobian(jacobians[frames], num_residuals(), kTurn);
    jacobian = prior_.jacobian.rightCols<kTurn>();
  }
  return true;
}

}  // namespace gluevo::vo
