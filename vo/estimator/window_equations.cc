#include "window_equations.h"

#include <Eigen/Cholesky>
#include <array>
#include <cmath>

#include "window_inertial.h"

namespace gluevo::vo {

void WindowEquations::Set(const WindowProblem& problem) {
  problem_ = &problem;
  priors_.Set(problem);
}

double WindowEquations::Cost(const WindowState& state) {
  geometry_.Set(*problem_, state.world_from_body, state.turn);
  return ViewsCost(*problem_, geometry_, state.points) + priors_.Cost(state) +
         InertialCost(*problem_, state);
}

void WindowEquations::Linearize(const WindowState& state) {
  geometry_.Set(*problem_, state.world_from_body, state.turn);
  system_.Reset({.frames = static_cast<int>(state.world_from_body.size()),
                 .fixed_frames = 1,
                 .has_turn = problem_->turn_sigma > 0.0,
                 .has_inertia = problem_->has_inertia(),
                 .has_time_offset = problem_->time_offset_s.has_value()});
  points_.Linearize(*problem_, geometry_, geometry_, state.points, system_);
  views_cost_ = system_.cost;
  priors_.AddTo(state, system_);
  AddInertial(*problem_, state, system_);
}

bool WindowEquations::Solve(double damping) {
  reduced_ = system_.hessian;
  for (Eigen::Index i = 0; i < reduced_.rows(); ++i) {
    reduced_(i, i) += Damping(reduced_(i, i), damping);
  }
  // Until it is solved for: what the equations are to be, with the other sign.
  step_ = system_.gradient;
  points_.Invert(damping);
  points_.Eliminate(reduced_, step_);
  if (!SolveReduced()) {
    return false;
  }
  step_ = -step_;
  // Half of -g^T d + d^T D d, by how the damped equations are solved.
  double twice_decrease = -system_.gradient.dot(step_);
  for (Eigen::Index i = 0; i < step_.size(); ++i) {
    twice_decrease += Damping(system_.hessian(i, i), damping) * step_(i) * step_(i);
  }
  twice_decrease += points_.Solve(damping, step_);
  predicted_decrease_ = 0.5 * twice_decrease;
  return step_.allFinite() && std::isfinite(predicted_decrease_);
}

bool WindowEquations::SolveReduced() {
  if (system_.columns.has_inertia) {
    return motions_.Eliminate(system_.columns, reduced_, step_) &&
           motions_.Solve(system_.columns, reduced_, step_);
  }
  const Eigen::LLT<Eigen::Ref<Eigen::MatrixXd>> factors(reduced_);
  if (factors.info() != Eigen::Success) {
    return false;
  }
  factors.solveInPlace(step_);
  return true;
}

std::optional<Eigen::Matrix<double, 12, 12>> WindowEquations::Covariance(int first, int second) {
  // So that a point without a depth of its own has a block that can be inverted.
  constexpr double kDamping = 1e-6;
  reduced_ = system_.hessian;
  step_ = system_.gradient;
  points_.Invert(kDamping);
  points_.Eliminate(reduced_, step_);
  const Eigen::LLT<Eigen::Ref<Eigen::MatrixXd>> factors(reduced_);
  if (factors.info() != Eigen::Success) {
    return std::nullopt;
  }
  const std::array<int, 2> columns = {system_.columns.Of(first), system_.columns.Of(second)};
  columns_.setZero(reduced_.rows(), 12);
  for (int i = 0; i < 2; ++i) {
    if (columns[i] >= 0) {
      columns_.block<6, 6>(columns[i], 6 * i).setIdentity();
    }
  }
  factors.solveInPlace(columns_);
  Eigen::Matrix<double, 12, 12> covariance = Eigen::Matrix<double, 12, 12>::Zero();
  for (int i = 0; i < 2; ++i) {
    if (columns[i] >= 0) {
      covariance.middleRows<6>(6 * i) = columns_.middleRows<6>(columns[i]);
    }
  }
  return covariance.allFinite() ? std::optional(covariance) : std::nullopt;
}

std::optional<WindowEquations::MotionCovariance> WindowEquations::CovarianceOfMotion(int frame) {
  constexpr int kMotion = WindowColumns::kMotion;
  constexpr int kGravity = WindowColumns::kGravity;
  const int motion = system_.columns.Motion(frame);
  const int gravity = system_.columns.Gravity();
  columns_.setZero(reduced_.rows(), kMotion + kGravity);
  columns_.block<kMotion, kMotion>(motion, 0).setIdentity();
  columns_.block<kGravity, kGravity>(gravity, kMotion).setIdentity();
  SolveColumns();
  MotionCovariance covariance;
  covariance << columns_.middleRows<kMotion>(motion), columns_.middleRows<kGravity>(gravity);
  return covariance.allFinite() ? std::optional(covariance) : std::nullopt;
}

double WindowEquations::VarianceOfTimeOffset() {
  return VarianceOfColumn(system_.columns.TimeOffset());
}

Eigen::Vector3d WindowEquations::VarianceOfTurn() {
  const int turn = system_.columns.Turn();
  return {VarianceOfColumn(turn), VarianceOfColumn(turn + 1), VarianceOfColumn(turn + 2)};
}

Eigen::Vector3d WindowEquations::StepOfTurn() {
  columns_ = step_;
  SolveColumns();
  return -columns_.block<3, 1>(system_.columns.Turn(), 0);
}

void WindowEquations::SolveColumns() {
  reduced_.triangularView<Eigen::Lower>().solveInPlace(columns_);
  reduced_.transpose().triangularView<Eigen::Upper>().solveInPlace(columns_);
}

double WindowEquations::VarianceOfColumn(int column) {
  columns_.setZero(reduced_.rows(), 1);
  columns_(column, 0) = 1.0;
  reduced_.triangularView<Eigen::Lower>().solveInPlace(columns_);
  // The inverse is L^-T L^-1.
  return columns_.squaredNorm();
}

}  // namespace gluevo::vo
