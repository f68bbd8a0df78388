#include "motion_equations.h"

#include <Eigen/Cholesky>
#include <Eigen/LU>

#include "gluevo/vo/geometry/manifold.h"
#include "gluevo/vo/inertial/gravity.h"

namespace gluevo::vo {
namespace {

using inertial_block::kPosition;
using inertial_block::kVelocity;

using MotionCovariance = Eigen::Matrix<double, 6, 6>;  ///< Of position, then velocity.

/// The unit's own noise, and what a wrong attitude makes of forces that are integrated along it.
MotionCovariance CovarianceOf(const Preintegration& measured, double rotation_sigma) {
  MotionCovariance covariance;
  covariance << measured.covariance.block<3, 3>(kPosition, kPosition),
      measured.covariance.block<3, 3>(kPosition, kVelocity),
      measured.covariance.block<3, 3>(kVelocity, kPosition),
      measured.covariance.block<3, 3>(kVelocity, kVelocity);
  Eigen::Matrix<double, 6, 3> by_turn;
  by_turn << Skew(measured.motion.position), Skew(measured.motion.velocity);
  return covariance + rotation_sigma * rotation_sigma * by_turn * by_turn.transpose();
}

constexpr Eigen::Index kFrame = 6;   // Position and velocity.
constexpr Eigen::Index kShared = 9;  // Biases and gravity.

/// Those of all frames, then the shared ones.
struct WholeEquations {
  Eigen::MatrixXd hessian;
  Eigen::VectorXd gradient;
  double constant = 0.0;
};

/// The rows of one interval, in the body frame of its first frame (Qin et al. 2018, eq. 18 and 19).
void AddInterval(const Trajectory& frames, const FrameInterval& interval, double rotation_sigma,
                 WholeEquations& equations) {
  const Preintegration& measured = interval.measured;
  const double dt = measured.duration_s;
  const Rigid3& first = frames[interval.first].world_from_body;
  const Rigid3& second = frames[interval.first + 1].world_from_body;
  const Eigen::Matrix3d body_from_world = first.rotation.conjugate().toRotationMatrix();
  constexpr Eigen::Index kFrames = 2 * kFrame;
  constexpr Eigen::Index kColumns = kFrames + kShared;
  Eigen::Matrix<double, 6, kColumns> jacobian = Eigen::Matrix<double, 6, kColumns>::Zero();
  jacobian.block<3, 3>(0, 0) = -body_from_world;
  jacobian.block<3, 3>(0, 3) = -dt * body_from_world;
  jacobian.block<3, 3>(0, 6) = body_from_world;
  jacobian.block<3, 3>(3, 3) = -body_from_world;
  jacobian.block<3, 3>(3, 9) = body_from_world;
  jacobian.block<3, 6>(0, 12) = -measured.by_bias.middleRows<3>(kPosition);
  jacobian.block<3, 6>(3, 12) = -measured.by_bias.middleRows<3>(kVelocity);
  jacobian.block<3, 3>(0, 18) = -0.5 * dt * dt * body_from_world;
  jacobian.block<3, 3>(3, 18) = -dt * body_from_world;
  Eigen::Matrix<double, 6, 1> residual;
  residual << body_from_world * (second.translation - first.translation) - measured.motion.position,
      -measured.motion.velocity;

  const Eigen::LLT<MotionCovariance> covariance(CovarianceOf(measured, rotation_sigma));
  covariance.matrixL().solveInPlace(jacobian);
  covariance.matrixL().solveInPlace(residual);
  const Eigen::Matrix<double, kColumns, kColumns> block = jacobian.transpose() * jacobian;
  const Eigen::Matrix<double, kColumns, 1> slope = jacobian.transpose() * residual;
  const auto at = kFrame * static_cast<Eigen::Index>(interval.first);
  const Eigen::Index shared = equations.hessian.cols() - kShared;
  equations.hessian.block<kFrames, kFrames>(at, at) += block.topLeftCorner<kFrames, kFrames>();
  equations.hessian.block<kFrames, kShared>(at, shared) += block.topRightCorner<kFrames, kShared>();
  equations.hessian.block<kShared, kFrames>(shared, at) +=
      block.bottomLeftCorner<kShared, kFrames>();
  equations.hessian.bottomRightCorner<kShared, kShared>() +=
      block.bottomRightCorner<kShared, kShared>();
  equations.gradient.segment<kFrames>(at) -= slope.head<kFrames>();
  equations.gradient.tail<kShared>() -= slope.tail<kShared>();
  equations.constant += residual.squaredNorm();
}

}  // namespace

std::vector<Eigen::Vector3d> EliminatedFrames::Velocities(const FreeEquations::State& state) const {
  const Eigen::VectorXd corrections = offsets - by_shared * state;
  std::vector<Eigen::Vector3d> velocities;
  velocities.reserve(static_cast<std::size_t>(corrections.size() / kFrame));
  for (Eigen::Index column = 3; column < corrections.size(); column += kFrame) {
    velocities.emplace_back(corrections.segment<3>(column));
  }
  return velocities;
}

EliminatedFrames BuildMotionEquations(const Trajectory& frames,
                                      const std::vector<FrameInterval>& intervals,
                                      const Eigen::Matrix3d& gyroscope_bias_covariance,
                                      const InitialisationOptions& options) {
  const Eigen::Index size = kFrame * static_cast<Eigen::Index>(frames.size());
  WholeEquations whole;
  whole.hessian = Eigen::MatrixXd::Zero(size + kShared, size + kShared);
  whole.gradient = Eigen::VectorXd::Zero(size + kShared);
  // Velocities and gravity that nothing speaks of must not make the equations singular.
  constexpr double kWeak = 1e-6;
  whole.hessian.diagonal().setConstant(kWeak);
  const double vision = 1.0 / (options.vision_position_sigma * options.vision_position_sigma);
  for (Eigen::Index column = 0; column < size; column += kFrame) {
    whole.hessian.diagonal().segment<3>(column).array() += vision;
  }
  whole.hessian.block<3, 3>(size, size) += gyroscope_bias_covariance.inverse();
  whole.hessian.diagonal().segment<3>(size + 3).array() +=
      1.0 / (options.accelerometer_bias_sigma * options.accelerometer_bias_sigma);
  for (const FrameInterval& interval : intervals) {
    AddInterval(frames, interval, options.vision_rotation_sigma, whole);
  }

  const Eigen::LLT<Eigen::MatrixXd> of_frames(whole.hessian.topLeftCorner(size, size));
  const Eigen::MatrixXd across = whole.hessian.topRightCorner(size, kShared);
  EliminatedFrames eliminated;
  eliminated.offsets = of_frames.solve(whole.gradient.head(size));
  eliminated.by_shared = of_frames.solve(across);
  FreeEquations& equations = eliminated.equations;
  equations.hessian = whole.hessian.bottomRightCorner<kShared, kShared>() -
                      across.transpose() * eliminated.by_shared;
  equations.gradient = whole.gradient.tail<kShared>() - across.transpose() * eliminated.offsets;
  equations.constant = whole.constant - whole.gradient.head(size).dot(eliminated.offsets);
  // Six rows an interval, three of vision a frame and six of the biases' prior, less six unknowns a
  // frame, the biases and gravity's direction.
  const auto rows = static_cast<Eigen::Index>(6 * intervals.size());
  equations.freedom = rows - size / 2 - 2;
  return eliminated;
}

SphereEquations OnSphere(const FreeEquations& free, const Eigen::Vector3d& gravity) {
  Eigen::Matrix<double, 9, 8> free_by_sphere = Eigen::Matrix<double, 9, 8>::Zero();
  free_by_sphere.topLeftCorner<6, 6>().setIdentity();
  free_by_sphere.bottomRightCorner<3, 2>() = GravityTangent(gravity);
  FreeEquations::State offset = FreeEquations::State::Zero();
  offset.tail<3>() = gravity;
  return {free_by_sphere.transpose() * free.hessian * free_by_sphere,
          free_by_sphere.transpose() * (free.gradient - free.hessian * offset), free.Sum(offset),
          free.freedom};
}

}  // namespace gluevo::vo
