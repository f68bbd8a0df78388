#include "window_reprojection.h"

#include "gluevo/vo/geometry/manifold.h"
#include "gluevo/vo/geometry/projection.h"

namespace gluevo::vo {
namespace {

using Rows2x3 = Eigen::Matrix<double, 2, 3>;

/// Each row a becomes a^T [v]_x = (a x v)^T.
Rows2x3 TimesSkew(const Rows2x3& rows, const Eigen::Vector3d& v) {
  Rows2x3 result;
  result.col(0) = rows.col(1) * v.z() - rows.col(2) * v.y();
  result.col(1) = rows.col(2) * v.x() - rows.col(0) * v.z();
  result.col(2) = rows.col(0) * v.y() - rows.col(1) * v.x();
  return result;
}

Eigen::Vector3d Ray(const Eigen::Vector3d& point) { return {point.x(), point.y(), 1.0}; }

}  // namespace

void WindowGeometry::Set(const WindowProblem& problem, const std::vector<Rigid3>& world_from_body,
                         const Eigen::Vector3d& turn) {
  frames_ = world_from_body.size();
  for (std::size_t c = 0; c < 2; ++c) {
    const Rigid3 cam_from_body = problem.body_from_cam[c].Inverse();
    cameras_[c] = {cam_from_body.rotation.toRotationMatrix(), cam_from_body.translation,
                   Eigen::Matrix3d::Identity()};
  }
  cameras_[1].turn += Skew(turn);
  body_from_left_rotation_ = problem.body_from_cam[0].rotation.toRotationMatrix();
  left_center_in_body_ = problem.body_from_cam[0].translation;
  world_from_body_rotation_.resize(frames_);
  for (std::size_t i = 0; i < frames_; ++i) {
    world_from_body_rotation_[i] = world_from_body[i].rotation.toRotationMatrix();
  }
  pairs_.resize(frames_ * frames_ * 2);
  for (std::size_t anchor = 0; anchor < frames_; ++anchor) {
    for (std::size_t frame = 0; frame < frames_; ++frame) {
      const Eigen::Matrix3d body_from_world = world_from_body_rotation_[frame].transpose();
      const Eigen::Matrix3d frame_from_anchor = body_from_world * world_from_body_rotation_[anchor];
      const Eigen::Vector3d anchor_from_frame_translation =
          body_from_world *
          (world_from_body[anchor].translation - world_from_body[frame].translation);
      for (std::size_t c = 0; c < 2; ++c) {
        const Camera& camera = cameras_[c];
        pairs_[(anchor * frames_ + frame) * 2 + c] = {
            camera.cam_from_body_rotation * frame_from_anchor * body_from_left_rotation_,
            camera.cam_from_body_rotation *
                    (frame_from_anchor * left_center_in_body_ + anchor_from_frame_translation) +
                camera.cam_from_body_translation};
      }
    }
  }
}

Eigen::Vector2d WindowGeometry::Residual(const WindowProblem& problem,
                                         const WindowProblem::View& view, int anchor,
                                         const Eigen::Vector3d& point) const {
  const Pair& pair = PairOf(anchor, view);
  const Eigen::Vector3d in_cam = cameras_[static_cast<std::size_t>(view.camera)].turn *
                                 (pair.rotation * Ray(point) + point.z() * pair.translation);
  if (!IsInFront(in_cam)) {
    return Eigen::Vector2d::Constant(kBehindResidual);
  }
  return problem.weight * (in_cam.hnormalized() - view.seen);
}

ReprojectionRows WindowGeometry::Linearize(const WindowProblem& problem,
                                           const WindowProblem::View& view, int anchor,
                                           const Eigen::Vector3d& point) const {
  ReprojectionRows rows;
  const Pair& pair = PairOf(anchor, view);
  const Camera& camera = cameras_[static_cast<std::size_t>(view.camera)];
  const double inverse_depth = point.z();
  const Eigen::Vector3d ray = Ray(point);
  const Eigen::Vector3d before_turn = pair.rotation * ray + inverse_depth * pair.translation;
  const Eigen::Vector3d in_cam = camera.turn * before_turn;
  rows.is_in_front = IsInFront(in_cam);
  if (!rows.is_in_front) {
    rows.residual.setConstant(kBehindResidual);
    return rows;
  }
  rows.residual = problem.weight * (in_cam.hnormalized() - view.seen);
  const Rows2x3 by_turned = problem.weight * ProjectionJacobian(in_cam);
  const Rows2x3 by_cam = by_turned * camera.turn;
  rows.by_turn = -TimesSkew(by_turned, before_turn);
  rows.by_point.leftCols<2>() = by_cam * pair.rotation.leftCols<2>();
  rows.by_point.col(2) = by_cam * pair.translation;
  if (view.frame == anchor) {
    return rows;
  }
  const Eigen::Matrix3d& world_from_anchor =
      world_from_body_rotation_[static_cast<std::size_t>(anchor)];
  const Eigen::Matrix3d& world_from_frame =
      world_from_body_rotation_[static_cast<std::size_t>(view.frame)];
  // The point times its inverse depth, in the bodies of the anchor and of the frame.
  const Eigen::Vector3d in_anchor =
      body_from_left_rotation_ * ray + inverse_depth * left_center_in_body_;
  const Eigen::Vector3d in_frame = camera.cam_from_body_rotation.transpose() *
                                   (before_turn - inverse_depth * camera.cam_from_body_translation);
  const Rows2x3 by_frame_body = by_cam * camera.cam_from_body_rotation;
  const Rows2x3 by_world = by_frame_body * world_from_frame.transpose();
  rows.by_anchor.leftCols<3>() = inverse_depth * by_world;
  rows.by_anchor.rightCols<3>() = -TimesSkew(by_world * world_from_anchor, in_anchor);
  rows.by_frame.leftCols<3>() = -inverse_depth * by_world;
  rows.by_frame.rightCols<3>() = TimesSkew(by_frame_body, in_frame);
  return rows;
}

}  // namespace gluevo::vo
