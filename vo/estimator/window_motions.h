#pragma once

#include <Eigen/Core>
#include <vector>

#include "window_system.h"

namespace gluevo::vo {

/// Velocities and biases in the normal equations. Those of a frame are tied to those of the frames
/// before and behind it, to two poses and to gravity (the oldest one's by the prior to all poses):
/// they are eliminated one after the other, the newest first (Triggs et al. 2000, section 6), for a
/// fraction of what it costs to solve for all at once. Allocates only for problems larger than ever
/// before.
class WindowMotions {
 public:
  /// Takes them out of equations, of which the lower triangle is read: what is left, of poses, turn
  /// and gravity, holds for the best velocities and biases. False where the equations do not settle
  /// them.
  bool Eliminate(const WindowColumns& columns, Eigen::MatrixXd& hessian, Eigen::VectorXd& gradient);
  /// What is left, solved: `solution` comes as the eliminated right side, of which the parts of
  /// velocities and biases are not read, and becomes that of hessian x = gradient. False where it
  /// is not positive definite.
  bool Solve(const WindowColumns& columns, const Eigen::MatrixXd& hessian,
             Eigen::VectorXd& solution);

 private:
  static constexpr int kMotion = WindowColumns::kMotion;
  static constexpr int kGravity = WindowColumns::kGravity;

  /// A frame's block, L L^T, and the rest of its rows and right side behind L^-1.
  struct Block {
    Eigen::Matrix<double, kMotion, kMotion> lower;
    int first = 0;  ///< Of the columns of poses and turn to which it is tied; all from it on.
    Eigen::Matrix<double, kMotion, Eigen::Dynamic> with_poses;
    Eigen::Matrix<double, kMotion, kMotion> with_before;  ///< The frame before's.
    Eigen::Matrix<double, kMotion, kGravity> with_gravity;
    Eigen::Matrix<double, kMotion, 1> right;
  };

  std::vector<Block> blocks_;
  Eigen::MatrixXd rest_;  ///< Poses and turn, then gravity.
  Eigen::VectorXd of_rest_;
};

}  // namespace gluevo::vo
