#pragma once

#include <Eigen/Core>
#include <vector>

#include "frame_intervals.h"
#include "gluevo/vo/inertial/initialisation.h"

namespace gluevo::vo {

/// What positions, velocities and forces say of the biases (six) and of gravity (three, or two of
/// its direction) once the frames' positions and velocities are eliminated: hessian x = gradient
/// minimises the sum of squares, which is `constant` at zero.
template <int kColumns>
struct MotionEquations {
  Eigen::Matrix<double, kColumns, kColumns> hessian;
  Eigen::Matrix<double, kColumns, 1> gradient;
  double constant = 0.0;
  Eigen::Index freedom = 0;  ///< Rows less unknowns, those of the frames among them.

  using State = Eigen::Matrix<double, kColumns, 1>;
  double Sum(const State& x) const { return x.dot(hessian * x) - 2.0 * gradient.dot(x) + constant; }
};
using FreeEquations = MotionEquations<9>;
using SphereEquations = MotionEquations<8>;

struct EliminatedFrames {
  FreeEquations equations;
  /// Corrections of the positions and velocities, six a frame, are offsets - by_shared x.
  Eigen::VectorXd offsets;
  Eigen::MatrixXd by_shared;

  /// One a frame, m/s.
  std::vector<Eigen::Vector3d> Velocities(const FreeEquations::State& state) const;
};

/// The equations of frames with vision's positions and of the intervals between them. The prior of
/// the biases, zero, is that of the options and, for the gyroscope, this covariance.
EliminatedFrames BuildMotionEquations(const Trajectory& frames,
                                      const std::vector<FrameInterval>& intervals,
                                      const Eigen::Matrix3d& gyroscope_bias_covariance,
                                      const InitialisationOptions& options);

/// Imposes gravity's length: three columns become two, around the direction that is known so far.
SphereEquations OnSphere(const FreeEquations& free, const Eigen::Vector3d& gravity);

}  // namespace gluevo::vo
