#pragma once

#include <string>
#include <vector>

#include "gluevo/vo/core/trajectory.h"
#include "path.h"

namespace gluevo::simulation {

/// A smooth path through a recorded trajectory: a uniform B-spline of degree 5 (four times
/// continuously differentiable), its knots 0.1 s apart, over the position and the unit quaternion
/// (whose spline is normalised), fitted by penalised least squares (P-splines, Eilers and Marx
/// 1996, third differences): it follows motions up to about 4 Hz and smooths what is faster, such
/// as the jumps in EuRoC's ground truth of the machine hall. Gaps are bridged smoothly.
class TrajectorySpline {
 public:
  /// Throws Error naming `what` for less than two poses or 0.5 s, more than 2 hours, and where the
  /// body turns so much between poses that its way is unknown.
  TrajectorySpline(const vo::Trajectory& trajectory, const std::string& what);

  /// From the first to the last pose.
  double duration_s() const { return duration_s_; }
  /// world_from_body at `time_s` after the first pose; beyond both ends by extrapolation, which is
  /// good for the milliseconds that derivatives and exposures need.
  vo::Rigid3 At(double time_s) const;

 private:
  static constexpr int kDegree = 5;
  using Values = Eigen::Matrix<double, 1, 7>;  ///< x y z, then the quaternion's x y z w.

  /// The spline before the quaternion is normalised.
  Values Blend(double time_s) const;

  double duration_s_ = 0.0;
  int pieces_ = 0;
  Eigen::Matrix<double, Eigen::Dynamic, 7, Eigen::RowMajor> controls_;
};

/// When the flight begins, in seconds after the first pose: the end of the first rest (2 s or more
/// within 2 cm) from which the body gets more than 1 m away before it rests again, so that waiting
/// and being shaken by hand are left out. Throws Error naming `what` where there is none.
double TakeOffSeconds(const vo::Trajectory& trajectory, const std::string& what);

}  // namespace gluevo::simulation
