#include "gluevo/vo/estimator/pose_prior.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "gluevo/vo/geometry/eigen_solvers.h"

namespace gluevo::vo {
namespace {

constexpr int kPose = PosePrior::kPose;
constexpr int kTurn = PosePrior::kTurn;
constexpr int kMotion = PosePrior::kMotion;
constexpr int kGravity = PosePrior::kGravity;

// Directions that are known less well than this share of the best known one are not known at all:
// their values are rounding errors.
constexpr double kLeastShare = 1e-10;

Eigen::Matrix<double, kMotion, 1> Difference(const VelocityAndBias& a, const VelocityAndBias& b) {
  Eigen::Matrix<double, kMotion, 1> difference;
  difference << a.velocity_in_world - b.velocity_in_world, a.bias.gyroscope - b.bias.gyroscope,
      a.bias.accelerometer - b.bias.accelerometer;
  return difference;
}

// Gives the prior the rows J = S^1/2 V^T and r0 = S^-1/2 V^T gradient, so that J^T J and J^T r0 are
// these again; `scales` are of the columns. (A pivoted L D L^T is faster, but its small pivots are
// no eigenvalues: the newest pose got 9 % worse.)
void SetRows(const Eigen::MatrixXd& scaled_hessian, const Eigen::VectorXd& scaled_gradient,
             const Eigen::VectorXd& scales, double least, PosePrior& prior) {
  const SymmetricEigen eigen = SolveSymmetricEigen(scaled_hessian);
  const Eigen::Index rows = (eigen.values.array() > least).count();
  const Eigen::VectorXd roots = eigen.values.tail(rows).cwiseSqrt();
  const auto vectors = eigen.vectors.rightCols(rows);
  prior.jacobian = roots.asDiagonal() * vectors.transpose() * scales.cwiseInverse().asDiagonal();
  prior.residual = roots.cwiseInverse().asDiagonal() * (vectors.transpose() * scaled_gradient);
}

}  // namespace

std::optional<std::size_t> PosePrior::Find(int64_t frame_id) const {
  const auto found = std::lower_bound(frame_ids.begin(), frame_ids.end(), frame_id);
  if (found == frame_ids.end() || *found != frame_id) {
    return std::nullopt;
  }
  return static_cast<std::size_t>(found - frame_ids.begin());
}

Eigen::VectorXd PosePrior::Delta(const std::vector<Rigid3>& present,
                                 const Eigen::Vector3d& present_turn,
                                 const std::vector<VelocityAndBias>& present_motions,
                                 const Eigen::Vector2d& present_gravity_turn,
                                 const std::optional<double>& present_time_offset_s) const {
  Eigen::VectorXd delta(Columns());
  for (std::size_t i = 0; i < present.size(); ++i) {
    delta.segment<kPose>(kPose * i) = Minus(present[i], world_from_body[i]);
  }
  delta.segment<kTurn>(TurnColumn()) = present_turn - turn;
  for (std::size_t i = 0; i < motions.size(); ++i) {
    delta.segment<kMotion>(MotionColumn(i)) = Difference(present_motions[i], motions[i]);
  }
  if (gravity_turn) {
    delta.segment<kGravity>(GravityColumn()) = present_gravity_turn - *gravity_turn;
  }
  if (time_offset_s) {
    delta[TimeOffsetColumn()] = *present_time_offset_s - *time_offset_s;
  }
  return delta;
}

Marginalizer::Marginalizer(PosePrior linearization)
    : state_(std::move(linearization)),
      hessian_(Eigen::MatrixXd::Zero(state_.Columns(), state_.Columns())),
      gradient_(Eigen::VectorXd::Zero(hessian_.rows())) {}

void Marginalizer::AddPrior(const PosePrior& prior) {
  Eigen::MatrixXd by_state = Eigen::MatrixXd::Zero(prior.jacobian.rows(), hessian_.cols());
  for (std::size_t i = 0; i < prior.frame_ids.size(); ++i) {
    by_state.middleCols<kPose>(kPose * *state_.Find(prior.frame_ids[i])) =
        prior.jacobian.middleCols<kPose>(kPose * i);
  }
  by_state.middleCols<kTurn>(state_.TurnColumn()) =
      prior.jacobian.middleCols<kTurn>(prior.TurnColumn());
  for (std::size_t i = 0; i < prior.motions.size(); ++i) {
    by_state.middleCols<kMotion>(state_.MotionColumn(*state_.Find(prior.frame_ids[i]))) =
        prior.jacobian.middleCols<kMotion>(prior.MotionColumn(i));
  }
  if (prior.gravity_turn) {
    by_state.middleCols<kGravity>(state_.GravityColumn()) =
        prior.jacobian.middleCols<kGravity>(prior.GravityColumn());
  }
  if (prior.time_offset_s) {
    by_state.col(state_.TimeOffsetColumn()) = prior.jacobian.col(prior.TimeOffsetColumn());
  }
  hessian_ += by_state.transpose() * by_state;
  gradient_ += by_state.transpose() * prior.residual;
}

void Marginalizer::Add(const Eigen::MatrixXd& hessian, const Eigen::VectorXd& gradient,
                       const Eigen::VectorXd& delta) {
  const Eigen::Index columns = hessian.rows();
  const Eigen::MatrixXd whole = hessian.selfadjointView<Eigen::Lower>();
  hessian_.topLeftCorner(columns, columns) += whole;
  gradient_.head(columns) += gradient;
  gradient_.head(columns).noalias() -= whole * delta.head(columns);
}

PosePrior WithoutFrame(const PosePrior& prior, int64_t frame_id) {
  Marginalizer marginalizer(prior);
  marginalizer.AddPrior(prior);
  return marginalizer.Eliminate(frame_id);
}

Eigen::VectorXd Marginalizer::Scales() const {
  Eigen::VectorXd scales = Eigen::VectorXd::Ones(hessian_.rows());
  const Eigen::Index first = state_.MotionColumn(0);
  const double largest = hessian_.diagonal().head(first).maxCoeff();
  for (Eigen::Index i = first; i < scales.size(); ++i) {
    if (hessian_(i, i) > 0.0 && largest > 0.0) {
      scales[i] = std::sqrt(largest / hessian_(i, i));
    }
  }
  return scales;
}

PosePrior Marginalizer::Keep() const {
  const Eigen::VectorXd scales = Scales();
  const Eigen::MatrixXd scaled = scales.asDiagonal() * hessian_ * scales.asDiagonal();
  PosePrior prior = state_;
  SetRows(scaled, scales.cwiseProduct(gradient_), scales,
          kLeastShare * scaled.diagonal().maxCoeff(), prior);
  return prior;
}

PosePrior Marginalizer::Eliminate(int64_t frame_id) const {
  const std::size_t index = *state_.Find(frame_id);
  PosePrior rest = state_;
  rest.frame_ids.erase(rest.frame_ids.begin() + static_cast<std::ptrdiff_t>(index));
  rest.world_from_body.erase(rest.world_from_body.begin() + static_cast<std::ptrdiff_t>(index));
  const bool has_motion = index < state_.motions.size();
  if (has_motion) {
    rest.motions.erase(rest.motions.begin() + static_cast<std::ptrdiff_t>(index));
  }
  const auto first = static_cast<Eigen::Index>(kPose * index);
  const Eigen::Index first_of_motion = has_motion ? state_.MotionColumn(index) : hessian_.rows();
  return EliminateColumns(
      [&](Eigen::Index i) {
        return (i >= first && i < first + kPose) ||
               (i >= first_of_motion && i < first_of_motion + kMotion);
      },
      std::move(rest));
}

PosePrior Marginalizer::EliminateInertia() const {
  PosePrior rest = state_;
  rest.motions.clear();
  rest.gravity_turn.reset();
  rest.time_offset_s.reset();
  return EliminateColumns([&](Eigen::Index i) { return i >= rest.Columns(); }, rest);
}

PosePrior Marginalizer::EliminateColumns(const std::function<bool(Eigen::Index)>& is_dropped,
                                         PosePrior rest) const {
  std::vector<Eigen::Index> kept, dropped;
  for (Eigen::Index i = 0; i < hessian_.rows(); ++i) {
    (is_dropped(i) ? dropped : kept).push_back(i);
  }
  const Eigen::VectorXd scales = Scales();
  const Eigen::MatrixXd scaled = scales.asDiagonal() * hessian_ * scales.asDiagonal();
  const Eigen::VectorXd scaled_gradient = scales.cwiseProduct(gradient_);
  // Schur complement, by the pseudo-inverse: what was dropped may itself be known only in part.
  const SymmetricEigen of_dropped = SolveSymmetricEigen(scaled(dropped, dropped));
  const double least = kLeastShare * scaled.diagonal().maxCoeff();
  const Eigen::VectorXd inverse_values =
      (of_dropped.values.array() > least)
          .select(of_dropped.values.cwiseInverse(),
                  Eigen::VectorXd::Zero(of_dropped.values.size()));
  const Eigen::MatrixXd inverse =
      of_dropped.vectors * inverse_values.asDiagonal() * of_dropped.vectors.transpose();
  const Eigen::MatrixXd gain = scaled(kept, dropped) * inverse;
  SetRows(scaled(kept, kept) - gain * scaled(dropped, kept),
          scaled_gradient(kept) - gain * scaled_gradient(dropped), scales(kept), least, rest);
  return rest;
}

}  // namespace gluevo::vo
