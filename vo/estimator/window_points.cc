#include "window_points.h"

#include <Eigen/LU>
#include <Eigen/QR>

#include "window_robust.h"

namespace gluevo::vo {

double ViewsCost(const WindowProblem& problem, const WindowGeometry& geometry,
                 const std::vector<Eigen::Vector3d>& points) {
  double cost = 0.0;
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

void WindowPoints::Linearize(const WindowProblem& problem, const WindowGeometry& residuals_at,
                             const WindowGeometry& derivatives_at,
                             const std::vector<Eigen::Vector3d>& points, WindowSystem& system) {
  has_turn_ = system.columns.has_turn;
  turn_column_ = system.columns.Turn();
  frames_ = static_cast<std::size_t>(system.columns.frames);
  relatives_.resize(frames_ * frames_);
  by_frame_.resize(frames_ * frames_);
  for (Relative& relative : relatives_) {
    relative.is_empty = true;
  }
  points_.clear();
  links_.clear();
  points_.reserve(points.size());
  links_.reserve(problem.views.size());
  for (std::size_t i = 0; i < points.size(); ++i) {
    AddPoint(problem, residuals_at, derivatives_at, problem.points[i], points[i], system);
  }
  for (int anchor = 0; anchor < system.columns.frames; ++anchor) {
    for (int frame = anchor + 1; frame < system.columns.frames; ++frame) {
      const std::size_t index = IndexOf(anchor, frame);
      if (!relatives_[index].is_empty) {
        AddRelative(relatives_[index], system.columns.Of(anchor), system.columns.Of(frame),
                    derivatives_at.RelativeByAnchor(anchor), by_frame_[index], system);
      }
    }
  }
}

void WindowPoints::AddPoint(const WindowProblem& problem, const WindowGeometry& residuals_at,
                            const WindowGeometry& derivatives_at, const WindowProblem::Point& point,
                            const Eigen::Vector3d& position, WindowSystem& system) {
  Point& block = points_.emplace_back();
  block.hessian.setZero();
  block.gradient.setZero();
  block.with_turn.setZero();
  block.first_link = links_.size();
  const int anchor_column = system.columns.Of(point.anchor);
  if (anchor_column >= 0) {
    links_.push_back({anchor_column, Block63::Zero()});
  }
  Block63 with_anchor = Block63::Zero();
  for (int v = point.first_view; v < point.end_view;) {
    const int frame = problem.views[static_cast<std::size_t>(v)].frame;
    const bool is_anchor = frame == point.anchor;
    const std::size_t index = IndexOf(point.anchor, frame);
    Relative& relative = relatives_[index];
    if (relative.is_empty && !is_anchor) {
      relative.Clear();
      by_frame_[index] = derivatives_at.RelativeByFrame(point.anchor, frame);
    }
    Block63 with_frame = Block63::Zero();
    for (; v < point.end_view && problem.views[static_cast<std::size_t>(v)].frame == frame; ++v) {
      const WindowProblem::View& view = problem.views[static_cast<std::size_t>(v)];
      ReprojectionColumns columns = derivatives_at.Linearize(problem, view, point.anchor, position);
      if (&residuals_at != &derivatives_at) {
        columns.residual = residuals_at.Residual(problem, view, point.anchor, position);
      }
      const Robust robust = Huber(columns.residual.squaredNorm(), problem.huber);
      system.cost += robust.cost;
      if (!columns.is_in_front) {
        continue;
      }
      const bool sees_turn = has_turn_ && view.camera == 1;
      AddView(columns, robust.weight, sees_turn, block, system);
      if (!is_anchor) {
        AddToRelative(columns, robust.weight, sees_turn, relative, with_frame);
      }
    }
    with_anchor += with_frame;
    if (const int column = system.columns.Of(frame); column >= 0 && !is_anchor) {
      links_.push_back({column, by_frame_[index].transpose() * with_frame});
    }
  }
  if (anchor_column >= 0) {
    links_[block.first_link].hessian.noalias() =
        derivatives_at.RelativeByAnchor(point.anchor).transpose() * with_anchor;
  }
  block.end_link = links_.size();
}

void WindowPoints::AddView(const ReprojectionColumns& columns, double weight, bool sees_turn,
                           Point& point, WindowSystem& system) const {
  const Eigen::Matrix<double, 3, 2> by_point = weight * columns.by_point;
  point.hessian.noalias() += by_point * columns.by_point.transpose();
  point.gradient.noalias() += by_point * columns.residual;
  if (sees_turn) {
    const Eigen::Matrix<double, 3, 2> by_turn = weight * columns.by_turn;
    system.hessian.block<3, 3>(turn_column_, turn_column_).noalias() +=
        by_turn * columns.by_turn.transpose();
    system.gradient.segment<3>(turn_column_).noalias() += by_turn * columns.residual;
    point.with_turn.noalias() += by_turn * columns.by_point.transpose();
  }
}

void WindowPoints::AddToRelative(const ReprojectionColumns& columns, double weight, bool sees_turn,
                                 Relative& relative, Block63& with_point) {
  const Eigen::Matrix<double, 6, 2> by_relative = weight * columns.by_relative;
  relative.hessian.noalias() += by_relative * columns.by_relative.transpose();
  relative.gradient.noalias() += by_relative * columns.residual;
  with_point.noalias() += by_relative * columns.by_point.transpose();
  if (sees_turn) {
    relative.with_turn.noalias() += by_relative * columns.by_turn.transpose();
  }
}

void WindowPoints::AddRelative(const Relative& relative, int anchor, int frame,
                               const Block66& by_anchor, const Block66& by_frame,
                               WindowSystem& system) {
  const int turn = system.columns.Turn();
  const auto add = [&](int column, const Block66& by_pose, const Block66& gain) {
    system.hessian.block<6, 6>(column, column).noalias() += gain * by_pose;
    system.gradient.segment<6>(column).noalias() += by_pose.transpose() * relative.gradient;
    if (system.columns.has_turn) {
      system.hessian.block<3, 6>(turn, column).noalias() +=
          relative.with_turn.transpose() * by_pose;
    }
  };
  const Block66 frame_gain = by_frame.transpose() * relative.hessian;
  add(frame, by_frame, frame_gain);
  if (anchor >= 0) {
    const Block66 anchor_gain = by_anchor.transpose() * relative.hessian;
    add(anchor, by_anchor, anchor_gain);
    system.hessian.block<6, 6>(frame, anchor).noalias() += frame_gain * by_anchor;
  }
}

void WindowPoints::Invert(double damping) {
  for (Point& point : points_) {
    Eigen::Matrix3d damped = point.hessian;
    for (int k = 0; k < 3; ++k) {
      damped(k, k) += Damping(damped(k, k), damping);
    }
    point.inverse = damped.inverse();
  }
}

void WindowPoints::Invert() {
  for (Point& point : points_) {
    point.inverse =
        Eigen::CompleteOrthogonalDecomposition<Eigen::Matrix3d>(point.hessian).pseudoInverse();
  }
}

void WindowPoints::Eliminate(Eigen::MatrixXd& hessian, Eigen::VectorXd& gradient) const {
  for (const Point& point : points_) {
    const Eigen::Vector3d solved = point.inverse * point.gradient;
    for (std::size_t a = point.first_link; a < point.end_link; ++a) {
      const Link& row = links_[a];
      const Block63 gain = row.hessian * point.inverse;
      gradient.segment<6>(row.column).noalias() -= row.hessian * solved;
      for (std::size_t b = point.first_link; b <= a; ++b) {  // In order of columns.
        hessian.block<6, 6>(row.column, links_[b].column).noalias() -=
            gain * links_[b].hessian.transpose();
      }
      if (has_turn_) {
        hessian.block<3, 6>(turn_column_, row.column).noalias() -=
            point.with_turn * gain.transpose();
      }
    }
    if (has_turn_) {
      const Eigen::Matrix3d gain = point.with_turn * point.inverse;
      hessian.block<3, 3>(turn_column_, turn_column_).noalias() -=
          gain * point.with_turn.transpose();
      gradient.segment<3>(turn_column_).noalias() -= point.with_turn * solved;
    }
  }
}

double WindowPoints::Solve(double damping, const Eigen::VectorXd& state_step) {
  steps_.resize(points_.size());
  double twice_decrease = 0.0;
  for (std::size_t p = 0; p < points_.size(); ++p) {
    const Point& point = points_[p];
    Eigen::Vector3d right = -point.gradient;
    for (std::size_t a = point.first_link; a < point.end_link; ++a) {
      right.noalias() -= links_[a].hessian.transpose() * state_step.segment<6>(links_[a].column);
    }
    if (has_turn_) {
      right.noalias() -= point.with_turn.transpose() * state_step.segment<3>(turn_column_);
    }
    Eigen::Vector3d& step = steps_[p];
    step.noalias() = point.inverse * right;
    twice_decrease -= point.gradient.dot(step);
    for (int k = 0; k < 3; ++k) {
      twice_decrease += Damping(point.hessian(k, k), damping) * step(k) * step(k);
    }
  }
  return twice_decrease;
}

}  // namespace gluevo::vo
