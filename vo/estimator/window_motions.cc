#include "window_motions.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cstddef>

namespace gluevo::vo {

bool WindowMotions::Eliminate(const WindowColumns& columns, Eigen::MatrixXd& hessian,
                              Eigen::VectorXd& gradient) {
  const int poses = columns.Motion(0);  // And the turn.
  const int gravity = columns.Gravity();
  blocks_.resize(static_cast<std::size_t>(columns.frames));
  for (int frame = columns.frames - 1; frame >= 0; --frame) {
    Block& block = blocks_[static_cast<std::size_t>(frame)];
    const int at = columns.Motion(frame);
    const Eigen::LLT<Eigen::Matrix<double, kMotion, kMotion>> factors(
        hessian.block<kMotion, kMotion>(at, at));
    if (factors.info() != Eigen::Success) {
      return false;
    }
    block.lower = factors.matrixL();
    const auto lower = block.lower.triangularView<Eigen::Lower>();
    block.first = frame == 0 ? 0 : std::max(0, columns.Of(frame - 1));
    const int width = poses - block.first;
    block.with_poses = hessian.block(at, block.first, kMotion, width);
    block.with_gravity = hessian.block<kGravity, kMotion>(gravity, at).transpose();
    block.right = gradient.segment<kMotion>(at);
    lower.solveInPlace(block.with_poses);
    lower.solveInPlace(block.with_gravity);
    lower.solveInPlace(block.right);

    hessian.block(block.first, block.first, width, width)
        .selfadjointView<Eigen::Lower>()
        .rankUpdate(block.with_poses.transpose(), -1.0);
    hessian.block(gravity, block.first, kGravity, width).noalias() -=
        block.with_gravity.transpose() * block.with_poses;
    hessian.block<kGravity, kGravity>(gravity, gravity).noalias() -=
        block.with_gravity.transpose() * block.with_gravity;
    gradient.segment(block.first, width).noalias() -= block.with_poses.transpose() * block.right;
    gradient.segment<kGravity>(gravity).noalias() -= block.with_gravity.transpose() * block.right;
    if (frame > 0) {
      const int before = columns.Motion(frame - 1);
      block.with_before = hessian.block<kMotion, kMotion>(at, before);
      lower.solveInPlace(block.with_before);
      hessian.block(before, block.first, kMotion, width).noalias() -=
          block.with_before.transpose() * block.with_poses;
      hessian.block<kMotion, kMotion>(before, before).noalias() -=
          block.with_before.transpose() * block.with_before;
      hessian.block<kGravity, kMotion>(gravity, before).noalias() -=
          block.with_gravity.transpose() * block.with_before;
      gradient.segment<kMotion>(before).noalias() -= block.with_before.transpose() * block.right;
    }
  }
  return true;
}

bool WindowMotions::Solve(const WindowColumns& columns, const Eigen::MatrixXd& hessian,
                          Eigen::VectorXd& solution) {
  const int poses = columns.Motion(0);
  const int gravity = columns.Gravity();
  rest_.resize(poses + kGravity, poses + kGravity);
  rest_.topLeftCorner(poses, poses) = hessian.topLeftCorner(poses, poses);
  rest_.bottomLeftCorner(kGravity, poses) = hessian.block(gravity, 0, kGravity, poses);
  rest_.bottomRightCorner<kGravity, kGravity>() =
      hessian.block<kGravity, kGravity>(gravity, gravity);
  of_rest_.resize(poses + kGravity);
  of_rest_ << solution.head(poses), solution.segment<kGravity>(gravity);
  const Eigen::LLT<Eigen::Ref<Eigen::MatrixXd>> factors(rest_);
  if (factors.info() != Eigen::Success) {
    return false;
  }
  factors.solveInPlace(of_rest_);
  solution.head(poses) = of_rest_.head(poses);
  solution.segment<kGravity>(gravity) = of_rest_.tail<kGravity>();
  for (int frame = 0; frame < columns.frames; ++frame) {
    const Block& block = blocks_[static_cast<std::size_t>(frame)];
    Eigen::Matrix<double, kMotion, 1> right = block.right;
    right.noalias() -= block.with_poses * solution.segment(block.first, poses - block.first);
    right.noalias() -= block.with_gravity * solution.segment<kGravity>(gravity);
    if (frame > 0) {
      right.noalias() -= block.with_before * solution.segment<kMotion>(columns.Motion(frame - 1));
    }
    block.lower.transpose().triangularView<Eigen::Upper>().solveInPlace(right);
    solution.segment<kMotion>(columns.Motion(frame)) = right;
  }
  return true;
}

}  // namespace gluevo::vo
