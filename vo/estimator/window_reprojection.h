#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "window_problem.h"

namespace gluevo::vo {

/// The residual where a point lies behind its camera, in standard deviations: beyond any that a
/// point in front can have in an image. Its derivatives are zero: the solver rejects steps that
/// lead there, and a point that starts there is left alone.
inline constexpr double kBehindResidual = 1e3;

/// A view's residual and its derivatives (Qin et al. 2018, eq. 25, with stereo as in VINS-Fusion).
/// Poses move by PoseTangent. Where the view is the anchor's own frame, the poses' are not set.
struct ReprojectionRows {
  Eigen::Vector2d residual;
  bool is_in_front = false;
  Eigen::Matrix<double, 2, 6> by_anchor;
  Eigen::Matrix<double, 2, 6> by_frame;
  Eigen::Matrix<double, 2, 3> by_turn;
  Eigen::Matrix<double, 2, 3> by_point;
};

/// How views of each frame and camera follow from points of each anchor: what residuals share at
/// one state of the problem.
class WindowGeometry {
 public:
  /// Of the problem's rig, with other poses and another turn. Allocates only for more frames than
  /// ever before.
  void Set(const WindowProblem& problem, const std::vector<Rigid3>& world_from_body,
           const Eigen::Vector3d& turn);

  /// The residual alone.
  Eigen::Vector2d Residual(const WindowProblem& problem, const WindowProblem::View& view,
                           int anchor, const Eigen::Vector3d& point) const;
  ReprojectionRows Linearize(const WindowProblem& problem, const WindowProblem::View& view,
                             int anchor, const Eigen::Vector3d& point) const;

 private:
  /// A point [u, v, 1] of the anchor's left view, times its depth, in a camera before its turn:
  /// rotation * ray + inverse depth * translation.
  struct Pair {
    Eigen::Matrix3d rotation;
    Eigen::Vector3d translation;
  };
  struct Camera {
    Eigen::Matrix3d cam_from_body_rotation;
    Eigen::Vector3d cam_from_body_translation;
    Eigen::Matrix3d turn;
  };
  const Pair& PairOf(int anchor, const WindowProblem::View& view) const {
    return pairs_[(static_cast<std::size_t>(anchor) * frames_ +
                   static_cast<std::size_t>(view.frame)) *
                      2 +
                  static_cast<std::size_t>(view.camera)];
  }

  std::size_t frames_ = 0;
  std::array<Camera, 2> cameras_;
  Eigen::Matrix3d body_from_left_rotation_;
  Eigen::Vector3d left_center_in_body_;
  std::vector<Eigen::Matrix3d> world_from_body_rotation_;
  std::vector<Pair> pairs_;
};

}  // namespace gluevo::vo
