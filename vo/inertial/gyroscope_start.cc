#include "gyroscope_start.h"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "gluevo/vo/geometry/manifold.h"

namespace gluevo::vo {
namespace {

using inertial_block::kRotation;

/// Columns: turns of the frames, three each, the bias, and the time offset where it is estimated.
struct TurnEquations {
  Eigen::Index turns;  ///< So many columns are the frames'.
  bool has_offset;
  Eigen::MatrixXd hessian;
  Eigen::VectorXd gradient;
  double sum = 0.0;  ///< Of squares.
};

TurnEquations Priors(Eigen::Index turns, const Eigen::VectorXd& state, double offset_so_far,
                     const InitialisationOptions& options) {
  const double vision = 1.0 / (options.vision_rotation_sigma * options.vision_rotation_sigma);
  const double prior = 1.0 / (options.gyroscope_bias_sigma * options.gyroscope_bias_sigma);
  TurnEquations equations{
      turns, state.size() > turns + 3, Eigen::MatrixXd::Zero(state.size(), state.size()), {}};
  equations.hessian.diagonal().head(turns).setConstant(vision);
  equations.hessian.diagonal().segment<3>(turns).setConstant(prior);
  equations.gradient = equations.hessian.diagonal().cwiseProduct(state);
  if (equations.has_offset) {
    const Eigen::Index offset = turns + 3;
    const double information = 1.0 / (options.time_offset_sigma_s * options.time_offset_sigma_s);
    equations.hessian(offset, offset) = information;
    equations.gradient[offset] = information * (offset_so_far + state[offset]);
  }
  equations.sum = vision * state.head(turns).squaredNorm();
  return equations;
}

void AddInterval(const Trajectory& frames, const FrameInterval& interval,
                 const Eigen::VectorXd& state, TurnEquations& equations) {
  const auto at = static_cast<Eigen::Index>(3 * interval.first);
  const Eigen::Index turns = equations.turns;
  const Eigen::Index offset = turns + 3;
  const Preintegration& measured = interval.measured;
  const auto turned = [&](std::size_t i, Eigen::Index column) {
    return frames[i].world_from_body.rotation * ExpSo3(state.segment<3>(column));
  };
  const Eigen::Quaterniond second_from_first =
      turned(interval.first + 1, at + 3).conjugate() * turned(interval.first, at);
  const Eigen::Matrix3d by_bias = measured.by_bias.block<3, 3>(kRotation, 0);
  const Eigen::Vector3d by_offset = measured.by_time_offset.segment<3>(kRotation);
  Eigen::Vector3d correction = by_bias * state.segment<3>(turns);
  if (equations.has_offset) {
    correction += by_offset * state[offset];
  }
  const Eigen::Quaterniond rotation = measured.motion.rotation * ExpSo3(correction);
  const Eigen::Vector3d residual = LogSo3(rotation.conjugate() * second_from_first.conjugate());
  const Eigen::Matrix3d log_by_turn = InverseRightJacobian(residual);
  const Eigen::Matrix3d by_correction =
      -log_by_turn * ExpSo3(residual).conjugate().toRotationMatrix();
  Eigen::Matrix<double, 3, 9> jacobian;  // By both turns and the bias.
  jacobian << -log_by_turn * second_from_first.toRotationMatrix(), log_by_turn,
      by_correction * by_bias;
  const Eigen::Matrix3d information =
      measured.covariance.block<3, 3>(kRotation, kRotation).inverse();
  const Eigen::Matrix<double, 9, 9> block = jacobian.transpose() * information * jacobian;
  const Eigen::Matrix<double, 9, 1> slope = jacobian.transpose() * information * residual;
  Eigen::MatrixXd& hessian = equations.hessian;
  hessian.block<6, 6>(at, at) += block.topLeftCorner<6, 6>();
  hessian.block<6, 3>(at, turns) += block.topRightCorner<6, 3>();
  hessian.block<3, 6>(turns, at) += block.bottomLeftCorner<3, 6>();
  hessian.block<3, 3>(turns, turns) += block.bottomRightCorner<3, 3>();
  equations.gradient.segment<6>(at) += slope.head<6>();
  equations.gradient.segment<3>(turns) += slope.tail<3>();
  if (equations.has_offset) {
    const Eigen::Vector3d by_time = by_correction * by_offset;
    const Eigen::Vector3d weighted = information * by_time;
    const Eigen::Matrix<double, 9, 1> with_others = jacobian.transpose() * weighted;
    hessian.block<1, 6>(offset, at) += with_others.head<6>().transpose();
    hessian.block<1, 3>(offset, turns) += with_others.tail<3>().transpose();
    hessian(offset, offset) += by_time.dot(weighted);
    equations.gradient[offset] += weighted.dot(residual);
  }
  equations.sum += residual.dot(information * residual);
}

}  // namespace

GyroscopeStart EstimateGyroscopeBias(const Trajectory& frames,
                                     const std::vector<FrameInterval>& intervals,
                                     const InitialisationOptions& options,
                                     double time_offset_so_far_s) {
  const auto turns = static_cast<Eigen::Index>(3 * frames.size());
  const bool has_offset = options.time_offset_sigma_s > 0.0;
  const Eigen::Index size = turns + 3 + (has_offset ? 1 : 0);
  Eigen::VectorXd state = Eigen::VectorXd::Zero(size);
  GyroscopeStart start;
  constexpr int kIterations = 3;
  for (int iteration = 0; iteration < kIterations; ++iteration) {
    TurnEquations equations = Priors(turns, state, time_offset_so_far_s, options);
    for (const FrameInterval& interval : intervals) {
      AddInterval(frames, interval, state, equations);
    }
    // Of the lower triangle.
    const Eigen::LLT<Eigen::MatrixXd> solver(equations.hessian);
    state -= solver.solve(equations.gradient);
    // Each frame's turn is measured and estimated, and so is the bias.
    start.rms = Rms(equations.sum, static_cast<Eigen::Index>(3 * intervals.size()));
    const Eigen::MatrixXd shared =
        solver.solve(Eigen::MatrixXd::Identity(size, size).rightCols(size - turns));
    start.covariance = shared.block<3, 3>(turns, 0);
    if (has_offset) {
      start.time_offset_sigma_s = std::sqrt(std::max(0.0, shared(turns + 3, 3)));
    }
  }
  start.bias = state.segment<3>(turns);
  if (has_offset) {
    start.time_offset_s = state[turns + 3];
  }
  return start;
}

}  // namespace gluevo::vo
