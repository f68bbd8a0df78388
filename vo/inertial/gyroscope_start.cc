#include "gyroscope_start.h"

#include <Eigen/Cholesky>
#include <Eigen/LU>

#include "gluevo/vo/geometry/manifold.h"

namespace gluevo::vo {

using inertial_block::kRotation;

GyroscopeStart EstimateGyroscopeBias(const Trajectory& frames,
                                     const std::vector<FrameInterval>& intervals,
                                     const InitialisationOptions& options) {
  const auto turns = static_cast<Eigen::Index>(3 * frames.size());
  const Eigen::Index size = turns + 3;
  const double vision = 1.0 / (options.vision_rotation_sigma * options.vision_rotation_sigma);
  const double prior = 1.0 / (options.gyroscope_bias_sigma * options.gyroscope_bias_sigma);
  Eigen::VectorXd state = Eigen::VectorXd::Zero(size);  // Turns of the frames, then the bias.
  GyroscopeStart start;
  constexpr int kIterations = 3;
  for (int iteration = 0; iteration < kIterations; ++iteration) {
    Eigen::MatrixXd hessian = Eigen::MatrixXd::Zero(size, size);
    hessian.diagonal().head(turns).setConstant(vision);
    hessian.diagonal().tail<3>().setConstant(prior);
    Eigen::VectorXd gradient = hessian.diagonal().cwiseProduct(state);
    double sum = vision * state.head(turns).squaredNorm();
    for (const FrameInterval& interval : intervals) {
      const auto at = static_cast<Eigen::Index>(3 * interval.first);
      const Preintegration& measured = interval.measured;
      const auto turned = [&](std::size_t i, Eigen::Index column) {
        return frames[i].world_from_body.rotation * ExpSo3(state.segment<3>(column));
      };
      const Eigen::Quaterniond second_from_first =
          turned(interval.first + 1, at + 3).conjugate() * turned(interval.first, at);
      const Eigen::Matrix3d by_bias = measured.by_bias.block<3, 3>(kRotation, 0);
      const Eigen::Quaterniond rotation =
          measured.motion.rotation * ExpSo3(by_bias * state.tail<3>());
      const Eigen::Vector3d residual = LogSo3(rotation.conjugate() * second_from_first.conjugate());
      const Eigen::Matrix3d log_by_turn = InverseRightJacobian(residual);
      Eigen::Matrix<double, 3, 9> jacobian;  // By both turns and the bias.
      jacobian << -log_by_turn * second_from_first.toRotationMatrix(), log_by_turn,
          -log_by_turn * ExpSo3(residual).conjugate().toRotationMatrix() * by_bias;
      const Eigen::Matrix3d information =
          measured.covariance.block<3, 3>(kRotation, kRotation).inverse();
      const Eigen::Matrix<double, 9, 9> block = jacobian.transpose() * information * jacobian;
      const Eigen::Matrix<double, 9, 1> slope = jacobian.transpose() * information * residual;
      hessian.block<6, 6>(at, at) += block.topLeftCorner<6, 6>();
      hessian.block<6, 3>(at, turns) += block.topRightCorner<6, 3>();
      hessian.block<3, 6>(turns, at) += block.bottomLeftCorner<3, 6>();
      hessian.bottomRightCorner<3, 3>() += block.bottomRightCorner<3, 3>();
      gradient.segment<6>(at) += slope.head<6>();
      gradient.tail<3>() += slope.tail<3>();
      sum += residual.dot(information * residual);
    }
    const Eigen::LLT<Eigen::MatrixXd> solver(hessian);
    state -= solver.solve(gradient);
    // Each frame's turn is measured and estimated, and so is the bias.
    start.rms = Rms(sum, static_cast<Eigen::Index>(3 * intervals.size()));
    start.covariance =
        solver.solve(Eigen::MatrixXd::Identity(size, size).rightCols<3>()).bottomRows<3>();
  }
  start.bias = state.tail<3>();
  return start;
}

}  // namespace gluevo::vo
