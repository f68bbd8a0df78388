#include "window_reprojection.h"

#include <Eigen/LU>

#include "gluevo/vo/geometry/manifold.h"
#include "gluevo/vo/geometry/projection.h"

namespace gluevo::vo {

void WindowGeometry::Set(const WindowProblem& problem, const std::vector<Rigid3>& world_from_body,
                         const Eigen::Vector3d& turn) {
  frames_ = world_from_body.size();
  const Eigen::Matrix3d body_from_left = problem.body_from_cam[0].rotation.toRotationMatrix();
  const Eigen::Vector3d& left_in_body = problem.body_from_cam[0].translation;
  world_from_body_rotation_.resize(frames_);
  world_from_left_rotation_.resize(frames_);
  body_center_in_world_.resize(frames_);
  left_center_in_world_.resize(frames_);
  relative_by_anchor_.resize(frames_);
  for (std::size_t i = 0; i < frames_; ++i) {
    const Eigen::Matrix3d rotation = world_from_body[i].rotation.toRotationMatrix();
    world_from_body_rotation_[i] = rotation;
    world_from_left_rotation_[i] = rotation * body_from_left;
    body_center_in_world_[i] = world_from_body[i].translation;
    left_center_in_world_[i] = rotation * left_in_body + world_from_body[i].translation;
    relative_by_anchor_[i] << world_from_left_rotation_[i].transpose(),
        -body_from_left.transpose() * Skew(left_in_body), Eigen::Matrix3d::Zero(),
        body_from_left.transpose();
  }

  correction_ = {turn, problem.bend};
  const Eigen::Matrix3d turned = correction_.Matrix();
  before_turn_ = turned.inverse();
  pairs_.resize(frames_ * frames_ * 2);
  for (std::size_t c = 0; c < 2; ++c) {
    const Rigid3 cam_from_body = problem.body_from_cam[c].Inverse();
    const Eigen::Matrix3d turn_of_cam = c == 0 ? Eigen::Matrix3d::Identity() : turned;
    const Eigen::Matrix3d rotation = turn_of_cam * cam_from_body.rotation.toRotationMatrix();
    const Eigen::Vector3d translation = turn_of_cam * cam_from_body.translation;
    for (std::size_t frame = 0; frame < frames_; ++frame) {
      const Eigen::Matrix3d cam_from_world =
          rotation * world_from_body_rotation_[frame].transpose();
      // A point is seen by its anchor and by frames behind that.
      for (std::size_t anchor = 0; anchor <= frame; ++anchor) {
        pairs_[(anchor * frames_ + frame) * 2 + c] = {
            cam_from_world * world_from_left_rotation_[anchor],
            cam_from_world * (left_center_in_world_[anchor] - body_center_in_world_[frame]) +
                translation};
      }
    }
  }
}

Eigen::Vector2d WindowGeometry::Residual(const WindowProblem& problem,
                                         const WindowProblem::View& view, int anchor,
                                         const Eigen::Vector3d& point) const {
  const Pair& pair = PairOf(anchor, view);
  const Eigen::Vector3d in_cam = pair.rotation.col(0) * point.x() +
                                 pair.rotation.col(1) * point.y() + pair.rotation.col(2) +
                                 pair.translation * point.z();
  if (!IsInFront(in_cam)) {
    return Eigen::Vector2d::Constant(kBehindResidual);
  }
  return problem.weight * (in_cam.head<2>() * (1.0 / in_cam.z()) - view.seen);
}

ReprojectionColumns WindowGeometry::Linearize(const WindowProblem& problem,
                                              const WindowProblem::View& view, int anchor,
                                              const Eigen::Vector3d& point) const {
  ReprojectionColumns columns;
  const Pair& pair = PairOf(anchor, view);
  const Eigen::Vector3d in_cam = pair.rotation.col(0) * point.x() +
                                 pair.rotation.col(1) * point.y() + pair.rotation.col(2) +
                                 pair.translation * point.z();
  columns.is_in_front = IsInFront(in_cam);
  if (!columns.is_in_front) {
    columns.residual.setConstant(kBehindResidual);
    return columns;
  }
  const double inverse_z = 1.0 / in_cam.z();
  const Eigen::Vector2d projected = in_cam.head<2>() * inverse_z;
  columns.residual = problem.weight * (projected - view.seen);
  const double scale = problem.weight * inverse_z;
  const Eigen::Matrix3d by_turn =
      view.camera == 1 ? correction_.ByTurn(before_turn_ * in_cam) : Eigen::Matrix3d::Zero();
  for (int row = 0; row < 2; ++row) {
    // d residual / d point in the anchor's axes.
    const Eigen::Vector3d by_ray =
        scale * (pair.rotation.row(row) - projected(row) * pair.rotation.row(2)).transpose();
    columns.by_point.col(row) << by_ray.head<2>(),
        scale * (pair.translation(row) - projected(row) * pair.translation.z());
    if (view.frame != anchor) {
      columns.by_relative.col(row) << point.z() * by_ray,
          point.y() * by_ray.z() - by_ray.y(),  // The ray x by_ray.
          by_ray.x() - point.x() * by_ray.z(), point.x() * by_ray.y() - point.y() * by_ray.x();
    }
    if (view.camera == 1) {
      columns.by_turn.col(row) =
          scale * (by_turn.row(row) - projected(row) * by_turn.row(2)).transpose();
    }
  }
  return columns;
}

Eigen::Matrix<double, 6, 6> WindowGeometry::RelativeByFrame(int anchor, int frame) const {
  const auto a = static_cast<std::size_t>(anchor);
  const auto f = static_cast<std::size_t>(frame);
  const Eigen::Matrix3d left_from_world = world_from_left_rotation_[a].transpose();
  const Eigen::Vector3d from_frame = left_center_in_world_[a] - body_center_in_world_[f];
  const Eigen::Matrix3d left_from_frame = left_from_world * world_from_body_rotation_[f];
  Eigen::Matrix<double, 6, 6> result;
  result << -left_from_world, left_from_world * Skew(from_frame) * world_from_body_rotation_[f],
      Eigen::Matrix3d::Zero(), -left_from_frame;
  return result;
}

}  // namespace gluevo::vo
