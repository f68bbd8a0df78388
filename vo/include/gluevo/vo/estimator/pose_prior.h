#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "gluevo/vo/core/rigid3.h"
#include "gluevo/vo/geometry/manifold.h"

namespace gluevo::vo {

/// What measurements that are gone say of some poses and of the right camera's orientation: a
/// Gaussian, kept as the residual r0 + J dx, where dx is the distance from the linearisation point
/// (Leutenegger et al. 2015, section 3.4; Qin et al. 2018, section VI-D). The columns of J are the
/// frames', a PoseTangent each, then the turn's (reprojection_factors.h).
///
/// The linearisation point of a pose is its estimate when it first came into a prior, and stays:
/// were derivatives of one pose taken at two places, their sum would claim to know where the rig
/// is in the world, of which nothing was ever measured (first-estimates Jacobians, Huang et al.
/// 2010).
struct PosePrior {
  static constexpr int kPose = kPoseTangentSize;
  static constexpr int kTurn = 3;

  std::vector<int64_t> frame_ids;  ///< Increasing.
  std::vector<Rigid3> world_from_body;
  Eigen::Quaterniond body_from_right = Eigen::Quaterniond::Identity();
  Eigen::MatrixXd jacobian;  ///< Rows x (6 * frames + 3); residuals have no unit.
  Eigen::VectorXd residual;  ///< r0.

  /// Index of a frame in frame_ids, nothing where it has no column.
  std::optional<std::size_t> Find(int64_t frame_id) const;
  /// dx: the given state's distance from the linearisation point.
  Eigen::VectorXd Delta(const std::vector<Rigid3>& world_from_body,
                        const Eigen::Quaterniond& body_from_right) const;
};

/// The prior on the other poses when one of its frames is eliminated.
PosePrior WithoutFrame(const PosePrior& prior, int64_t frame_id);

/// The distance of a right camera's orientation from another as a turn: the rotation vector of
/// right_from_right_before.
Eigen::Vector3d TurnBetween(const Eigen::Quaterniond& body_from_right_before,
                            const Eigen::Quaterniond& body_from_right);

/// Gathers linearised measurements of poses and the turn, and gives what they say once some of the
/// poses are eliminated.
class Marginalizer {
 public:
  /// All poses that measurements speak of (frame_ids, world_from_body) and the right camera's
  /// orientation, at the linearisation point. Rows that there are do not count.
  explicit Marginalizer(PosePrior linearization);
  const PosePrior& linearization() const { return state_; }

  /// A prior over some of the poses, with the same linearisation points.
  void AddPrior(const PosePrior& prior);

  /// Measurements by J^T J (its lower triangle) and J^T r: J in the columns of PosePrior, those of
  /// the turn perhaps left out, r at the present state, which is `delta` away from the
  /// linearisation point.
  void Add(const Eigen::MatrixXd& hessian, const Eigen::VectorXd& gradient,
           const Eigen::VectorXd& delta);

  /// The prior on the poses that remain when `frame_id` is eliminated.
  PosePrior Eliminate(int64_t frame_id) const;

 private:
  PosePrior state_;  // frames and linearisation points; no rows
  Eigen::MatrixXd hessian_;
  Eigen::VectorXd gradient_;  // J^T r0, at the linearisation point
};

}  // namespace gluevo::vo
