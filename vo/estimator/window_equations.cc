#include "window_equations.h"

#include <Eigen/LU>
#include <cmath>

#include "gluevo/vo/geometry/manifold.h"

namespace gluevo::vo {
namespace {

constexpr int kPose = kPoseTangentSize;

/// Columns of the frame's pose, -1 for the gauge.
int ColumnOf(int frame) { return frame == 0 ? -1 : kPose * (frame - 1); }

/// Huber's loss of a squared norm, halved, and the root of its derivative.
struct Robust {
  double cost;
  double root_weight;
};
Robust Huber(double squared_norm, double threshold) {
  if (squared_norm <= threshold * threshold) {
    return {0.5 * squared_norm, 1.0};
  }
  const double norm = std::sqrt(squared_norm);
  return {threshold * (norm - 0.5 * threshold), std::sqrt(threshold / norm)};
}

/// A diagonal entry of the damping, with the bounds that Ceres has.
double Damped(double diagonal, double damping) {
  return damping * std::min(std::max(diagonal, 1e-6), 1e32);
}

void PriorDelta(const WindowProblem& problem, const std::vector<Rigid3>& world_from_body,
                const Eigen::Vector3d& turn, Eigen::VectorXd& delta) {
  delta.resize(problem.prior->jacobian.cols());
  for (std::size_t i = 0; i < problem.prior_frames.size(); ++i) {
    delta.segment<kPose>(static_cast<Eigen::Index>(kPose * i)) =
        Minus(world_from_body[static_cast<std::size_t>(problem.prior_frames[i])],
              problem.prior->world_from_body[i]);
  }
  delta.tail<3>() = problem.prior_turn_so_far + turn;
}

double TurnCost(const WindowProblem& problem, const Eigen::Vector3d& turn) {
  return problem.turn_sigma > 0.0
             ? 0.5 * ((problem.turn_so_far + turn) / problem.turn_sigma).squaredNorm()
             : 0.0;
}

}  // namespace

double WindowCost(const WindowProblem& problem, const WindowGeometry& geometry,
                  const std::vector<Rigid3>& world_from_body, const Eigen::Vector3d& turn,
                  const std::vector<Eigen::Vector3d>& points) {
  double cost = TurnCost(problem, turn);
  if (problem.prior != nullptr) {
    Eigen::VectorXd delta;
    PriorDelta(problem, world_from_body, turn, delta);
    cost += 0.5 * (problem.prior->residual + problem.prior->jacobian * delta).squaredNorm();
  }
  for (std::size_t i = 0; i < points.size(); ++i) {
    const WindowProblem::Point& point = problem.points[i];
    for (int v = point.first_view; v < point.end_view; ++v) {
      const Eigen::Vector2d residual = geometry.Residual(
          problem, problem.views[static_cast<std::size_t>(v)], point.anchor, points[i]);
      cost += Huber(residual.squaredNorm(), problem.huber).cost;
    }
  }
  return cost;
}

void WindowEquations::Linearize(const WindowProblem& problem, const WindowGeometry& geometry,
                                const std::vector<Rigid3>& world_from_body,
                                const Eigen::Vector3d& turn,
                                const std::vector<Eigen::Vector3d>& points) {
  has_turn_ = problem.turn_sigma > 0.0;
  turn_column_ = kPose * (static_cast<int>(world_from_body.size()) - 1);
  const Eigen::Index columns = turn_column_ + (has_turn_ ? 3 : 0);
  hessian_.setZero(columns, columns);
  gradient_.setZero(columns);
  cost_ = 0.0;
  blocks_.clear();
  links_.clear();
  blocks_.reserve(points.size());
  links_.reserve(problem.views.size() + points.size());
  for (std::size_t i = 0; i < points.size(); ++i) {
    AddPoint(problem, geometry, problem.points[i], points[i]);
  }
  AddTurnPrior(problem, turn);
  if (problem.prior != nullptr) {
    AddPrior(problem, world_from_body, turn);
  }
}

void WindowEquations::AddPoint(const WindowProblem& problem, const WindowGeometry& geometry,
                               const WindowProblem::Point& point, const Eigen::Vector3d& position) {
  PointBlock& block = blocks_.emplace_back();
  block.hessian.setZero();
  block.gradient.setZero();
  block.with_turn.setZero();
  block.first_link = links_.size();
  const auto link = [&](int frame) {
    links_.push_back({ColumnOf(frame), Eigen::Matrix<double, 6, 3>::Zero()});
    return frame;
  };
  int last_frame = link(point.anchor);
  for (int v = point.first_view; v < point.end_view; ++v) {
    const WindowProblem::View& view = problem.views[static_cast<std::size_t>(v)];
    const ReprojectionRows rows = geometry.Linearize(problem, view, point.anchor, position);
    const Robust robust = Huber(rows.residual.squaredNorm(), problem.huber);
    cost_ += robust.cost;
    if (!rows.is_in_front) {
      continue;
    }
    const bool is_anchor = view.frame == point.anchor;
    if (!is_anchor && view.frame != last_frame) {
      last_frame = link(view.frame);
    }
    AddView(rows, robust.root_weight, has_turn_ && view.camera == 1, block,
            links_[block.first_link], is_anchor ? nullptr : &links_.back());
  }
  block.end_link = links_.size();
}

void WindowEquations::AddView(const ReprojectionRows& rows, double robust, bool sees_turn,
                              PointBlock& block, Link& anchor, Link* frame) {
  const Eigen::Vector2d residual = robust * rows.residual;
  const Eigen::Matrix<double, 2, 3> by_point = robust * rows.by_point;
  const Eigen::Matrix<double, 2, 3> by_turn = robust * rows.by_turn;
  block.hessian.noalias() += by_point.transpose() * by_point;
  block.gradient.noalias() += by_point.transpose() * residual;
  if (sees_turn) {
    hessian_.block<3, 3>(turn_column_, turn_column_).noalias() += by_turn.transpose() * by_turn;
    gradient_.segment<3>(turn_column_).noalias() += by_turn.transpose() * residual;
    block.with_turn.noalias() += by_turn.transpose() * by_point;
  }
  if (frame == nullptr) {
    return;
  }
  const auto add_pose = [&](Link& link, const Eigen::Matrix<double, 2, 6>& by_pose) {
    if (link.column < 0) {
      return;
    }
    hessian_.block<6, 6>(link.column, link.column).noalias() += by_pose.transpose() * by_pose;
    gradient_.segment<6>(link.column).noalias() += by_pose.transpose() * residual;
    link.hessian.noalias() += by_pose.transpose() * by_point;
    if (sees_turn) {
      hessian_.block<3, 6>(turn_column_, link.column).noalias() += by_turn.transpose() * by_pose;
    }
  };
  const Eigen::Matrix<double, 2, 6> by_anchor = robust * rows.by_anchor;
  const Eigen::Matrix<double, 2, 6> by_frame = robust * rows.by_frame;
  add_pose(anchor, by_anchor);
  add_pose(*frame, by_frame);
  if (anchor.column >= 0) {
    // Frames are in order, and the anchor is a point's first.
    hessian_.block<6, 6>(frame->column, anchor.column).noalias() +=
        by_frame.transpose() * by_anchor;
  }
}

void WindowEquations::AddTurnPrior(const WindowProblem& problem, const Eigen::Vector3d& turn) {
  if (!has_turn_) {
    return;
  }
  const double information = 1.0 / (problem.turn_sigma * problem.turn_sigma);
  hessian_.diagonal().tail<3>().array() += information;
  gradient_.tail<3>() += information * (problem.turn_so_far + turn);
  cost_ += TurnCost(problem, turn);
}

void WindowEquations::AddPrior(const WindowProblem& problem,
                               const std::vector<Rigid3>& world_from_body,
                               const Eigen::Vector3d& turn) {
  const PosePrior& prior = *problem.prior;
  PriorDelta(problem, world_from_body, turn, prior_delta_);
  prior_residual_ = prior.residual;
  prior_residual_.noalias() += prior.jacobian * prior_delta_;
  cost_ += 0.5 * prior_residual_.squaredNorm();
  // By the poses' tangents at the present state.
  prior_jacobian_ = prior.jacobian;
  for (std::size_t i = 0; i < problem.prior_frames.size(); ++i) {
    const auto column = static_cast<Eigen::Index>(kPose * i) + 3;
    const Eigen::Matrix3d by_step = InverseRightJacobian(prior_delta_.segment<3>(column));
    prior_jacobian_.middleCols<3>(column) = prior.jacobian.middleCols<3>(column) * by_step;
  }
  prior_hessian_.noalias() = prior_jacobian_.transpose() * prior_jacobian_;
  prior_gradient_.noalias() = prior_jacobian_.transpose() * prior_residual_;
  const auto turn_in_prior = prior_jacobian_.cols() - 3;
  for (std::size_t i = 0; i < problem.prior_frames.size(); ++i) {
    const int row = ColumnOf(problem.prior_frames[i]);
    const auto from_row = static_cast<Eigen::Index>(kPose * i);
    if (row < 0) {
      continue;
    }
    gradient_.segment<kPose>(row) += prior_gradient_.segment<kPose>(from_row);
    for (std::size_t j = 0; j <= i; ++j) {
      const int column = ColumnOf(problem.prior_frames[j]);
      if (column >= 0) {
        hessian_.block<kPose, kPose>(row, column) +=
            prior_hessian_.block<kPose, kPose>(from_row, static_cast<Eigen::Index>(kPose * j));
      }
    }
    if (has_turn_) {
      hessian_.block<3, kPose>(turn_column_, row) +=
          prior_hessian_.block<3, kPose>(turn_in_prior, from_row);
    }
  }
  if (has_turn_) {
    hessian_.block<3, 3>(turn_column_, turn_column_) += prior_hessian_.bottomRightCorner<3, 3>();
    gradient_.segment<3>(turn_column_) += prior_gradient_.tail<3>();
  }
}

void WindowEquations::EliminatePoint(double damping, PointBlock& block) {
  Eigen::Matrix3d damped = block.hessian;
  for (int k = 0; k < 3; ++k) {
    damped(k, k) += Damped(damped(k, k), damping);
  }
  block.inverse = damped.inverse();
  const Eigen::Vector3d solved = block.inverse * block.gradient;
  for (std::size_t a = block.first_link; a < block.end_link; ++a) {
    const Link& row = links_[a];
    if (row.column < 0) {
      continue;
    }
    const Eigen::Matrix<double, 6, 3> gain = row.hessian * block.inverse;
    step_.segment<6>(row.column).noalias() -= row.hessian * solved;
    for (std::size_t b = block.first_link; b <= a; ++b) {
      const Link& column = links_[b];
      if (column.column >= 0) {
        reduced_.block<6, 6>(row.column, column.column).noalias() -=
            gain * column.hessian.transpose();
      }
    }
    if (has_turn_) {
      reduced_.block<3, 6>(turn_column_, row.column).noalias() -=
          block.with_turn * gain.transpose();
    }
  }
  if (has_turn_) {
    reduced_.block<3, 3>(turn_column_, turn_column_).noalias() -=
        block.with_turn * block.inverse * block.with_turn.transpose();
    step_.segment<3>(turn_column_).noalias() -= block.with_turn * solved;
  }
}

bool WindowEquations::Solve(double damping) {
  reduced_ = hessian_;
  for (Eigen::Index i = 0; i < reduced_.rows(); ++i) {
    reduced_(i, i) += Damped(reduced_(i, i), damping);
  }
  // Until it is solved for, what the equations are to be: the gradient without the points' part.
  step_ = gradient_;
  for (PointBlock& block : blocks_) {
    EliminatePoint(damping, block);
  }
  step_ = -step_;
  const Eigen::LLT<Eigen::Ref<Eigen::MatrixXd>> factors(reduced_);
  if (factors.info() != Eigen::Success) {
    return false;
  }
  factors.solveInPlace(step_);
  // Half of -g^T d + d^T D d, by how the damped equations are solved.
  double twice_decrease = -gradient_.dot(step_);
  for (Eigen::Index i = 0; i < step_.size(); ++i) {
    twice_decrease += Damped(hessian_(i, i), damping) * step_(i) * step_(i);
  }
  point_steps_.resize(blocks_.size());
  for (std::size_t p = 0; p < blocks_.size(); ++p) {
    const PointBlock& block = blocks_[p];
    Eigen::Vector3d right = -block.gradient;
    for (std::size_t a = block.first_link; a < block.end_link; ++a) {
      if (links_[a].column >= 0) {
        right.noalias() -= links_[a].hessian.transpose() * step_.segment<6>(links_[a].column);
      }
    }
    if (has_turn_) {
      right.noalias() -= block.with_turn.transpose() * step_.segment<3>(turn_column_);
    }
    Eigen::Vector3d& step = point_steps_[p];
    step.noalias() = block.inverse * right;
    twice_decrease -= block.gradient.dot(step);
    for (int k = 0; k < 3; ++k) {
      twice_decrease += Damped(block.hessian(k, k), damping) * step(k) * step(k);
    }
  }
  predicted_decrease_ = 0.5 * twice_decrease;
  return step_.allFinite() && std::isfinite(predicted_decrease_);
}

}  // namespace gluevo::vo
