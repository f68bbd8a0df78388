#pragma once

#include <Eigen/Core>
#include <array>
#include <vector>

#include "gluevo/vo/geometry/right_image_offset.h"
#include "window_problem.h"

namespace gluevo::vo {

/// The residual where a point lies behind its camera, in standard deviations: beyond any that a
/// point in front can have in an image. Its derivatives are zero: the solver rejects steps that
/// lead there, and a point that starts there is left alone.
inline constexpr double kBehindResidual = 1e3;

/// A view's residual and its derivatives, a column for each of its two rows (Qin et al. 2018, eq.
/// 25, with stereo as in VINS-Fusion).
///
/// Poses enter by where the anchor is from the frame: a small motion (dt, dr) of the anchor's left
/// camera in its own axes takes its point ray to ray + inverse depth * dt + dr x ray. What that is
/// by the poses' own tangents is the same for all points of two frames (WindowGeometry).
struct ReprojectionColumns {
  Eigen::Vector2d residual;
  bool is_in_front = false;
  Eigen::Matrix<double, 6, 2> by_relative;  ///< Not set where the frame is the anchor.
  Eigen::Matrix<double, 3, 2> by_point;
  Eigen::Matrix<double, 3, 2> by_turn;  ///< Set for the right camera.
};

/// How views of each frame and camera follow from points of each anchor: what residuals share at
/// one state of the problem.
class WindowGeometry {
 public:
  /// Of the problem's rig, at these poses and this turn. Allocates only for more frames than ever
  /// before.
  void Set(const WindowProblem& problem, const std::vector<Rigid3>& world_from_body,
           const Eigen::Vector3d& turn);

  /// The residual alone.
  Eigen::Vector2d Residual(const WindowProblem& problem, const WindowProblem::View& view,
                           int anchor, const Eigen::Vector3d& point) const;
  ReprojectionColumns Linearize(const WindowProblem& problem, const WindowProblem::View& view,
                                int anchor, const Eigen::Vector3d& point) const;

  /// The relative motion (see ReprojectionColumns) by the PoseTangent of the anchor, whatever the
  /// other frame, ...
  const Eigen::Matrix<double, 6, 6>& RelativeByAnchor(int anchor) const {
    return relative_by_anchor_[static_cast<std::size_t>(anchor)];
  }
  /// ... and by that of the frame that sees the points.
  Eigen::Matrix<double, 6, 6> RelativeByFrame(int anchor, int frame) const;

 private:
  /// A point [u, v, 1] of the anchor's left view, times its depth, in a camera: rotation * ray +
  /// inverse depth * translation.
  struct Pair {
    Eigen::Matrix3d rotation;
    Eigen::Vector3d translation;
  };
  const Pair& PairOf(int anchor, const WindowProblem::View& view) const {
    return pairs_[(static_cast<std::size_t>(anchor) * frames_ +
                   static_cast<std::size_t>(view.frame)) *
                      2 +
                  static_cast<std::size_t>(view.camera)];
  }

  std::size_t frames_ = 0;
  RightImageOffset correction_;
  Eigen::Matrix3d before_turn_;  ///< From the right camera's frame to that without its turn.
  std::vector<Eigen::Matrix3d> world_from_body_rotation_, world_from_left_rotation_;
  std::vector<Eigen::Vector3d> left_center_in_world_, body_center_in_world_;
  std::vector<Eigen::Matrix<double, 6, 6>> relative_by_anchor_;
  std::vector<Pair> pairs_;
};

}  // namespace gluevo::vo
