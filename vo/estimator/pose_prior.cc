#include "gluevo/vo/estimator/pose_prior.h"

#include <algorithm>
#include <utility>

#include "gluevo/vo/geometry/eigen_solvers.h"

namespace gluevo::vo {
namespace {

constexpr int kPose = PosePrior::kPose;
constexpr int kTurn = PosePrior::kTurn;

// Directions that are known less well than this share of the best known one are not known at all:
// their values are rounding errors.
constexpr double kLeastShare = 1e-10;

}  // namespace

Eigen::Vector3d TurnBetween(const Eigen::Quaterniond& body_from_right_before,
                            const Eigen::Quaterniond& body_from_right) {
  return LogSo3(body_from_right.conjugate() * body_from_right_before);
}

std::optional<std::size_t> PosePrior::Find(int64_t frame_id) const {
  const auto found = std::lower_bound(frame_ids.begin(), frame_ids.end(), frame_id);
  if (found == frame_ids.end() || *found != frame_id) {
    return std::nullopt;
  }
  return static_cast<std::size_t>(found - frame_ids.begin());
}

Eigen::VectorXd PosePrior::Delta(const std::vector<Rigid3>& present,
                                 const Eigen::Quaterniond& present_body_from_right) const {
  Eigen::VectorXd delta(kPose * present.size() + kTurn);
  for (std::size_t i = 0; i < present.size(); ++i) {
    delta.segment<kPose>(kPose * i) = Minus(present[i], world_from_body[i]);
  }
  delta.tail<kTurn>() = TurnBetween(body_from_right, present_body_from_right);
  return delta;
}

Marginalizer::Marginalizer(PosePrior linearization)
    : state_(std::move(linearization)),
      hessian_(Eigen::MatrixXd::Zero(kPose * state_.frame_ids.size() + kTurn,
                                     kPose * state_.frame_ids.size() + kTurn)),
      gradient_(Eigen::VectorXd::Zero(hessian_.rows())) {}

void Marginalizer::AddPrior(const PosePrior& prior) {
  Eigen::MatrixXd by_state = Eigen::MatrixXd::Zero(prior.jacobian.rows(), hessian_.cols());
  for (std::size_t i = 0; i < prior.frame_ids.size(); ++i) {
    by_state.middleCols<kPose>(kPose * *state_.Find(prior.frame_ids[i])) =
        prior.jacobian.middleCols<kPose>(kPose * i);
  }
  by_state.rightCols<kTurn>() = prior.jacobian.rightCols<kTurn>();
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

PosePrior Marginalizer::Eliminate(int64_t frame_id) const {
  const std::size_t index = *state_.Find(frame_id);
  PosePrior prior = state_;
  prior.frame_ids.erase(prior.frame_ids.begin() + static_cast<std::ptrdiff_t>(index));
  prior.world_from_body.erase(prior.world_from_body.begin() + static_cast<std::ptrdiff_t>(index));

  const auto first = static_cast<Eigen::Index>(kPose * index);
  const Eigen::Index behind = hessian_.rows() - first - kPose;
  std::vector<Eigen::Index> kept, dropped;
  for (Eigen::Index i = 0; i < hessian_.rows(); ++i) {
    (i >= first && i < hessian_.rows() - behind ? dropped : kept).push_back(i);
  }
  // Schur complement, by the pseudo-inverse: what was dropped may itself be known only in part.
  const SymmetricEigen of_dropped = SolveSymmetricEigen(hessian_(dropped, dropped));
  const double least = kLeastShare * hessian_.diagonal().maxCoeff();
  const Eigen::VectorXd inverse_values =
      (of_dropped.values.array() > least)
          .select(of_dropped.values.cwiseInverse(), Eigen::VectorXd::Zero(kPose));
  const Eigen::MatrixXd inverse =
      of_dropped.vectors * inverse_values.asDiagonal() * of_dropped.vectors.transpose();
  const Eigen::MatrixXd gain = hessian_(kept, dropped) * inverse;
  const Eigen::MatrixXd hessian = hessian_(kept, kept) - gain * hessian_(dropped, kept);
  const Eigen::VectorXd gradient = gradient_(kept) - gain * gradient_(dropped);

  // J = S^1/2 V^T and r0 = S^-1/2 V^T gradient, so that J^T J and J^T r0 are these again. (A
  // pivoted L D L^T is faster, but its small pivots are no eigenvalues: the newest pose got 9 %
  // worse.)
  const SymmetricEigen of_kept = SolveSymmetricEigen(hessian);
  const Eigen::Index rows = (of_kept.values.array() > least).count();
  const Eigen::VectorXd roots = of_kept.values.tail(rows).cwiseSqrt();
  const auto vectors = of_kept.vectors.rightCols(rows);
  prior.jacobian = roots.asDiagonal() * vectors.transpose();
  prior.residual = roots.cwiseInverse().asDiagonal() * (vectors.transpose() * gradient);
  return prior;
}

}  // namespace gluevo::vo
