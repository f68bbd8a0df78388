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
  return problem_->turn_sigma > 0.0 ? 0.5 * (state.turn / problem_->turn_sigma).squaredNorm() : 0.0;
}

void WindowPriors::SetResidual(const WindowState& state) {
  const PosePrior& prior = *problem_->prior;
  delta_.resize(prior.jacobian.cols());
  for (std::size_t i = 0; i < problem_->prior_frames.size(); ++i) {
    delta_.segment<kPose>(PoseInPrior(i)) =
        Minus(state.world_from_body[static_cast<std::size_t>(problem_->prior_frames[i])],
              prior.world_from_body[i]);
  }
  delta_.segment<3>(prior.TurnColumn()) = state.turn - prior.turn;
  for (std::size_t i = 0; i < prior.motions.size(); ++i) {
    const VelocityAndBias& motion =
        state.motions[static_cast<std::size_t>(problem_->prior_frames[i])];
    delta_.segment<PosePrior::kMotion>(prior.MotionColumn(i))
        << motion.velocity_in_world - prior.motions[i].velocity_in_world,
        motion.bias.gyroscope - prior.motions[i].bias.gyroscope,
        motion.bias.accelerometer - prior.motions[i].bias.accelerometer;
  }
  if (prior.gravity_turn) {
    delta_.segment<PosePrior::kGravity>(prior.GravityColumn()) =
        state.gravity_turn - *prior.gravity_turn;
  }
  if (prior.time_offset_s) {
    delta_[prior.TimeOffsetColumn()] = *state.time_offset_s - *prior.time_offset_s;
  }
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
  const int turn = system.columns.Turn();
  system.hessian.diagonal().segment<3>(turn).array() += information;
  system.gradient.segment<3>(turn) += information * state.turn;
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
  const Eigen::Index turn_in_prior = problem_->prior->TurnColumn();
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
    system.hessian.block<3, 3>(turn, turn) += hessian_.block<3, 3>(turn_in_prior, turn_in_prior);
    system.gradient.segment<3>(turn) += gradient_.segment<3>(turn_in_prior);
  }
  if (problem_->prior->gravity_turn) {
    AddInertiaTo(system);
  }
  if (problem_->prior->time_offset_s) {
    AddTimeOffsetTo(system);
  }
}

// Its column stands before those of motions and gravity: below the diagonal are their rows.
void WindowPriors::AddTimeOffsetTo(WindowSystem& system) const {
  const PosePrior& prior = *problem_->prior;
  const WindowColumns& columns = system.columns;
  const std::vector<int>& frames = problem_->prior_frames;
  const int offset = columns.TimeOffset();
  const Eigen::Index in_prior = prior.TimeOffsetColumn();
  system.gradient[offset] += gradient_[in_prior];
  system.hessian(offset, offset) += hessian_(in_prior, in_prior);
  for (std::size_t i = 0; i < frames.size(); ++i) {
    if (const int column = columns.Of(frames[i]); column >= 0) {
      system.hessian.block<1, kPose>(offset, column).noalias() +=
          hessian_.block<1, kPose>(in_prior, PoseInPrior(i)) * by_step_[i];
    }
  }
  if (columns.has_turn) {
    system.hessian.block<1, 3>(offset, columns.Turn()) +=
        hessian_.block<1, 3>(in_prior, prior.TurnColumn());
  }
  for (std::size_t i = 0; i < prior.motions.size(); ++i) {
    system.hessian.block<PosePrior::kMotion, 1>(columns.Motion(frames[i]), offset) +=
        hessian_.block<PosePrior::kMotion, 1>(prior.MotionColumn(i), in_prior);
  }
  system.hessian.block<PosePrior::kGravity, 1>(columns.Gravity(), offset) +=
      hessian_.block<PosePrior::kGravity, 1>(prior.GravityColumn(), in_prior);
}

void WindowPriors::AddInertiaTo(WindowSystem& system) const {
  const PosePrior& prior = *problem_->prior;
  const WindowColumns& columns = system.columns;
  const std::vector<int>& frames = problem_->prior_frames;
  struct Block {
    Eigen::Index in_prior;
    int column;
    int size;
  };
  const std::size_t motions = prior.motions.size();
  const auto block_at = [&](std::size_t i) {
    return i < motions ? Block{prior.MotionColumn(i), columns.Motion(frames[i]), PosePrior::kMotion}
                       : Block{prior.GravityColumn(), columns.Gravity(), PosePrior::kGravity};
  };
  for (std::size_t i = 0; i <= motions; ++i) {
    const Block row = block_at(i);
    system.gradient.segment(row.column, row.size) += gradient_.segment(row.in_prior, row.size);
    for (std::size_t j = 0; j < frames.size(); ++j) {
      if (const int column = columns.Of(frames[j]); column >= 0) {
        system.hessian.block(row.column, column, row.size, kPose).noalias() +=
            hessian_.block(row.in_prior, PoseInPrior(j), row.size, kPose) * by_step_[j];
      }
    }
    if (columns.has_turn) {
      system.hessian.block(row.column, columns.Turn(), row.size, 3) +=
          hessian_.block(row.in_prior, prior.TurnColumn(), row.size, 3);
    }
    for (std::size_t j = 0; j <= i; ++j) {
      const Block column = block_at(j);
      system.hessian.block(row.column, column.column, row.size, column.size) +=
          hessian_.block(row.in_prior, column.in_prior, row.size, column.size);
    }
  }
}

}  // namespace gluevo::vo
