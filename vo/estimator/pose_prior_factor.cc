#include "pose_prior_factor.h"

#include "pose_manifold.h"

namespace gluevo::vo {
namespace {

constexpr int kPose = PosePrior::kPose;
constexpr int kTurn = PosePrior::kTurn;

}  // namespace

PosePriorFactor::PosePriorFactor(const PosePrior& prior) : prior_(prior) {
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
  delta.tail<kTurn>() = Eigen::Map<const Eigen::Vector3d>(parameters[frames]) - prior_.turn;
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
