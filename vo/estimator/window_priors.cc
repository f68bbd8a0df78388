#include "window_priors.h"

#include "gluevo/vo/geometry/manifold.h"

namespace gluevo::vo {
namespace {

constexpr int kPose = kPoseTangentSize;

Eigen::Index PoseInPrior(std::size_t i) { return static_cast<Eigen::Index>(kPose * i); }

}  // namespace

void WindowPriors::Set(const WindowProblem& problem) {
  problem_ = &problem;
  if (problem.prior != nullptr) {
    hessian_.noalias() = problem.prior->jacobian.transpose() * problem.prior->jacobian;
  }
}

double WindowPriors::TurnCost(const WindowState& state) const {
  return problem_->turn_sigma > 0.0
             ? 0.5 * ((problem_->turn_so_far + state.turn) / problem_->turn_sigma).squaredNorm()
             : 0.0;
}

void WindowPriors::SetResidual(const WindowState& state) {
  const PosePrior& prior = *problem_->prior;
  delta_.resize(prior.jacobian.cols());
  for (std::size_t i = 0; i < problem_->prior_frames.size(); ++i) {
    delta_.segment<kPose>(PoseInPrior(i)) =
        Minus(state.world_from_body[static_cast<std::size_t>(problem_->prior_frames[i])],
              prior.world_from_body[i]);
  }
  delta_.tail<3>() = problem_->prior_turn_so_far + state.turn;
  residual_ = prior.residual;
  residual_.noalias() += prior.jacobian * delta_;
}

double WindowPriors::Cost(const WindowState& state) {
  double cost = TurnCost(state);
  if (problem_->prior != nullptr) {
    SetResidual(state);
    cost += 0.5 * residual_.squaredNorm();
  }
  return cost;
}

void WindowPriors::AddTurnTo(const WindowState& state, WindowSystem& system) const {
  const double information = 1.0 / (problem_->turn_sigma * problem_->turn_sigma);
  system.hessian.diagonal().tail<3>().array() += information;
  system.gradient.tail<3>() += information * (problem_->turn_so_far + state.turn);
}

void WindowPriors::AddTo(const WindowState& state, WindowSystem& system) {
  system.cost += Cost(state);
  const WindowColumns& columns = system.columns;
  if (columns.has_turn) {
    AddTurnTo(state, system);
  }
  if (problem_->prior == nullptr) {
    return;
  }
  gradient_.noalias() = problem_->prior->jacobian.transpose() * residual_;
  const std::vector<int>& frames = problem_->prior_frames;
  by_step_.resize(frames.size());
  for (std::size_t i = 0; i < frames.size(); ++i) {
    by_step_[i].setIdentity();
    by_step_[i].bottomRightCorner<3, 3>() =
        InverseRightJacobian(delta_.segment<3>(PoseInPrior(i) + 3));
  }
  const int turn = columns.Turn();
  const Eigen::Index turn_in_prior = hessian_.cols() - 3;
  for (std::size_t i = 0; i < frames.size(); ++i) {
    const int row = columns.Of(frames[i]);
    if (row < 0) {
      continue;
    }
    system.gradient.segment<kPose>(row).noalias() +=
        by_step_[i].transpose() * gradient_.segment<kPose>(PoseInPrior(i));
    for (std::size_t j = 0; j <= i; ++j) {
      if (const int column = columns.Of(frames[j]); column >= 0) {
        const Eigen::Matrix<double, kPose, kPose> by_row =
            by_step_[i].transpose() * hessian_.block<kPose, kPose>(PoseInPrior(i), PoseInPrior(j));
        system.hessian.block<kPose, kPose>(row, column).noalias() += by_row * by_step_[j];
      }
    }
    if (columns.has_turn) {
      system.hessian.block<3, kPose>(turn, row).noalias() +=
          hessian_.block<3, kPose>(turn_in_prior, PoseInPrior(i)) * by_step_[i];
    }
  }
  if (columns.has_turn) {
    system.hessian.block<3, 3>(turn, turn) += hessian_.bottomRightCorner<3, 3>();
    system.gradient.segment<3>(turn) += gradient_.tail<3>();
  }
}

}  // namespace gluevo::vo
