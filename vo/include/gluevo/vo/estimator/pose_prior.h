#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <vector>

#include "gluevo/vo/core/rigid3.h"
#include "gluevo/vo/geometry/manifold.h"
#include "gluevo/vo/inertial/gravity.h"
#include "gluevo/vo/inertial/inertial_residual.h"

namespace gluevo::vo {

/// What measurements that are gone say of some poses and of the right camera's orientation: a
/// Gaussian, kept as the residual r0 + J dx, where dx is the distance from the linearisation point
/// (Leutenegger et al. 2015, section 3.4; Qin et al. 2018, section VI-D). The columns of J are the
/// frames', a PoseTangent each, then the turn's (reprojection_factors.h); with an inertial unit
/// then those of motions, of gravity's turn and of the time offset.
///
/// The linearisation point of a pose is its estimate when it first came into a prior, and stays:
/// were derivatives of one pose taken at two places, their sum would claim to know where the rig
/// is in the world, of which nothing was ever measured (first-estimates Jacobians, Huang et al.
/// 2010).
struct PosePrior {
  static constexpr int kPose = kPoseTangentSize;
  static constexpr int kTurn = 3;
  static constexpr int kMotion = 9;
  static constexpr int kGravity = 2;

  std::vector<int64_t> frame_ids;  ///< Increasing.
  std::vector<Rigid3> world_from_body;
  Eigen::Vector3d turn = Eigen::Vector3d::Zero();  ///< Of RightImageOffset.
  Eigen::MatrixXd jacobian;                        ///< Rows x Columns(); residuals have no unit.
  Eigen::VectorXd residual;                        ///< r0.
  /// With an inertial unit, of the first frames, as many as there are: of the oldest alone once it
  /// is the frame that measurements lead to. Velocity, then biases (VelocityAndBias).
  std::vector<VelocityAndBias> motions = {};
  /// GravityEstimate::turn, radians; nothing without an inertial unit.
  std::optional<Eigen::Vector2d> gravity_turn = std::nullopt;
  /// That of ImuReadings, seconds; nothing where it is not estimated.
  std::optional<double> time_offset_s = std::nullopt;

  Eigen::Index TurnColumn() const { return kPose * static_cast<Eigen::Index>(frame_ids.size()); }
  Eigen::Index MotionColumn(std::size_t motion) const {
    return TurnColumn() + kTurn + kMotion * static_cast<Eigen::Index>(motion);
  }
  Eigen::Index GravityColumn() const { return MotionColumn(motions.size()); }
  Eigen::Index TimeOffsetColumn() const { return GravityColumn() + (gravity_turn ? kGravity : 0); }
  Eigen::Index Columns() const { return TimeOffsetColumn() + (time_offset_s ? 1 : 0); }

  /// Index of a frame in frame_ids, nothing where it has no column.
  std::optional<std::size_t> Find(int64_t frame_id) const;
  /// dx: the given state's distance from the linearisation point. Of more motions than the prior
  /// has the first ones count.
  Eigen::VectorXd Delta(const std::vector<Rigid3>& world_from_body, const Eigen::Vector3d& turn,
                        const std::vector<VelocityAndBias>& motions = {},
                        const Eigen::Vector2d& gravity_turn = Eigen::Vector2d::Zero(),
                        const std::optional<double>& time_offset_s = std::nullopt) const;
};

/// The prior on the other poses when one of its frames is eliminated.
PosePrior WithoutFrame(const PosePrior& prior, int64_t frame_id);

/// Gathers linearised measurements of poses and the turn, and gives what they say once some of the
/// poses are eliminated.
class Marginalizer {
 public:
  /// All that measurements speak of (poses, the right camera's orientation, motions, gravity, time
  /// offset), at
  /// the linearisation point. Rows that there are do not count.
  explicit Marginalizer(PosePrior linearization);
  const PosePrior& linearization() const { return state_; }

  /// A prior over some of that, with the same linearisation points.
  void AddPrior(const PosePrior& prior);

  /// Measurements by J^T J (its lower triangle) and J^T r: J in the columns of PosePrior, the last
  /// of which (the turn's and those behind it) may be left out, r at the present state, which is
  /// `delta` away from the linearisation point.
  void Add(const Eigen::MatrixXd& hessian, const Eigen::VectorXd& gradient,
           const Eigen::VectorXd& delta);

  /// The prior on what remains when `frame_id` is eliminated, with its motion.
  PosePrior Eliminate(int64_t frame_id) const;
  /// Likewise when all motions, gravity and the time offset are.
  PosePrior EliminateInertia() const;
  /// The prior on all.
  PosePrior Keep() const;

 private:
  /// `rest`: what has the other columns.
  PosePrior EliminateColumns(const std::function<bool(Eigen::Index)>& is_dropped,
                             PosePrior rest) const;
  /// What brings the columns of inertia, which are of all sizes, to that of the poses'.
  Eigen::VectorXd Scales() const;

  PosePrior state_;  // frames and linearisation points; no rows
  Eigen::MatrixXd hessian_;
  Eigen::VectorXd gradient_;  // J^T r0, at the linearisation point
};

}  // namespace gluevo::vo
