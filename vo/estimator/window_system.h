#pragma once

#include <Eigen/Core>
#include <algorithm>

#include "gluevo/vo/geometry/manifold.h"

namespace gluevo::vo {

/// Which columns of the normal equations are whose: frames in order, each with the tangent of its
/// pose, then the turn; then, with an inertial unit, its time offset where that is estimated,
/// frames in order, each with its velocity and biases, and gravity's turn.
struct WindowColumns {
  static constexpr int kFrame = kPoseTangentSize;
  static constexpr int kMotion = 9;
  static constexpr int kGravity = 2;

  int frames = 0;
  int fixed_frames = 0;   ///< 0 or 1: so many have no columns.
  bool has_turn = false;  ///< Whether the turn is estimated.
  bool has_inertia = false;
  bool has_time_offset = false;  ///< Whether it is estimated.

  /// The first of a frame, negative for a fixed one.
  int Of(int frame) const { return frame < fixed_frames ? -1 : kFrame * (frame - fixed_frames); }
  int Turn() const { return kFrame * (frames - fixed_frames); }
  /// Those of a fixed frame are there, too: the gauge is a pose.
  int Motion(int frame) const { return TimeOffset() + (has_time_offset ? 1 : 0) + kMotion * frame; }
  int TimeOffset() const { return Turn() + (has_turn ? 3 : 0); }
  int Gravity() const { return Motion(frames); }
  int Count() const { return has_inertia ? Gravity() + kGravity : Motion(0); }
};

/// Normal equations of frames and the turn, to which each kind of measurement adds its part.
struct WindowSystem {
  WindowColumns columns;
  Eigen::MatrixXd hessian;  ///< Lower triangle; blocks on the diagonal whole.
  Eigen::VectorXd gradient;
  double cost = 0.0;  ///< Half the sum of squares.

  /// All zero. Allocates only for more columns than ever before.
  void Reset(const WindowColumns& new_columns) {
    columns = new_columns;
    hessian.setZero(columns.Count(), columns.Count());
    gradient.setZero(columns.Count());
    cost = 0.0;
  }
};

/// What the method of Levenberg and Marquardt adds to an entry of the diagonal; the bounds are
/// those of Ceres.
inline double Damping(double diagonal, double damping) {
  constexpr double kLeast = 1e-6;
  constexpr double kLargest = 1e32;
  return damping * std::min(std::max(diagonal, kLeast), kLargest);
}

}  // namespace gluevo::vo
