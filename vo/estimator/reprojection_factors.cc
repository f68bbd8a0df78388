#include "reprojection_factors.h"

#include "gluevo/vo/geometry/projection.h"
#include "gluevo/vo/geometry/right_image_offset.h"
#include "pose_manifold.h"

namespace gluevo::vo {
namespace {

using Row2x3 = Eigen::Matrix<double, 2, 3, Eigen::RowMajor>;
using Row2x7 = Eigen::Matrix<double, 2, 7, Eigen::RowMajor>;

// The residual where a point lies behind its camera, in standard deviations: beyond any that a
// point in front can have in an image.
constexpr double kBehindResidual = 1e3;

// From the derivative by the tangent [dp, dtheta] to that by [p, q]: the one that agrees with the
// manifold's and is zero along q (a function of q / |q|).
Row2x7 AmbientJacobian(const Eigen::Matrix<double, 2, 6>& tangent_jacobian, const double* pose) {
  Eigen::Matrix<double, 6, 7, Eigen::RowMajor> minus;
  PoseManifold().MinusJacobian(pose, minus.data());
  return tangent_jacobian * minus;
}

RightImageOffset Correction(const double* turn, double bend) {
  return {Eigen::Map<const Eigen::Vector3d>(turn), bend};
}

bool FillBehind(double* residuals, double** jacobians, const std::vector<int>& sizes) {
  residuals[0] = residuals[1] = kBehindResidual;
  if (jacobians != nullptr) {
    for (std::size_t i = 0; i < sizes.size(); ++i) {
      if (jacobians[i] != nullptr) {
        std::fill_n(jacobians[i], 2 * sizes[i], 0.0);
      }
    }
  }
  return true;
}

}  // namespace

OtherFrameReprojection::OtherFrameReprojection(const Rigid3& body_from_anchor_cam,
                                               const Rigid3& body_from_cam,
                                               const Eigen::Vector2d& observed, double weight,
                                               double bend)
    : body_from_anchor_rotation_(body_from_anchor_cam.rotation.toRotationMatrix()),
      anchor_center_in_body_(body_from_anchor_cam.translation),
      cam_from_body_rotation_(body_from_cam.Inverse().rotation.toRotationMatrix()),
      cam_from_body_translation_(body_from_cam.Inverse().translation),
      observed_(observed),
      weight_(weight),
      bend_(bend) {}

bool OtherFrameReprojection::Evaluate(double const* const* parameters, double* residuals,
                                      double** jacobians) const {
  const Rigid3 world_from_i = ToRigid3(parameters[0]);
  const Rigid3 world_from_j = ToRigid3(parameters[1]);
  const Eigen::Vector3d ray(parameters[2][0], parameters[2][1], 1.0);
  const double lambda = parameters[2][2];
  const Eigen::Matrix3d rotation_i = world_from_i.rotation.toRotationMatrix();
  const Eigen::Matrix3d j_from_world_rotation =
      world_from_j.rotation.toRotationMatrix().transpose();

  // The point times lambda, in the bodies i and j and in the camera.
  const Eigen::Vector3d in_i = body_from_anchor_rotation_ * ray + lambda * anchor_center_in_body_;
  const Eigen::Vector3d i_from_j = world_from_i.translation - world_from_j.translation;
  const Eigen::Vector3d in_j = j_from_world_rotation * (rotation_i * in_i + lambda * i_from_j);
  const RightImageOffset correction = Correction(parameters[3], bend_);
  const Eigen::Matrix3d turn = correction.Matrix();
  const Eigen::Vector3d before_turn =
      cam_from_body_rotation_ * in_j + lambda * cam_from_body_translation_;
  const Eigen::Vector3d in_cam = turn * before_turn;
  if (!IsInFront(in_cam)) {
    return FillBehind(residuals, jacobians, parameter_block_sizes());
  }
  Eigen::Map<Eigen::Vector2d> residual(residuals);
  residual = weight_ * (in_cam.hnormalized() - observed_);
  if (jacobians == nullptr) {
    return true;
  }

  const Eigen::Matrix<double, 2, 3> by_turned = weight_ * ProjectionJacobian(in_cam);
  const Eigen::Matrix<double, 2, 3> by_cam = by_turned * turn;
  const Eigen::Matrix<double, 2, 3> by_j = by_cam * cam_from_body_rotation_;
  const Eigen::Matrix<double, 2, 3> by_world = by_j * j_from_world_rotation;
  const Eigen::Matrix<double, 2, 3> by_i = by_world * rotation_i;
  if (jacobians[0] != nullptr) {
    Eigen::Matrix<double, 2, 6> by_pose;
    by_pose << lambda * by_world, -by_i * Skew(in_i);
    Eigen::Map<Row2x7> jacobian(jacobians[0]);
    jacobian = AmbientJacobian(by_pose, parameters[0]);
  }
  if (jacobians[1] != nullptr) {
    Eigen::Matrix<double, 2, 6> by_pose;
    by_pose << -lambda * by_world, by_j * Skew(in_j);
    Eigen::Map<Row2x7> jacobian(jacobians[1]);
    jacobian = AmbientJacobian(by_pose, parameters[1]);
  }
  if (jacobians[2] != nullptr) {
    Eigen::Map<Row2x3> jacobian(jacobians[2]);
    jacobian << by_i * body_from_anchor_rotation_.leftCols<2>(),
        by_i * anchor_center_in_body_ + by_world * i_from_j + by_cam * cam_from_body_translation_;
  }
  if (jacobians[3] != nullptr) {
    Eigen::Map<Row2x3> jacobian(jacobians[3]);
    jacobian = by_turned * correction.ByTurn(before_turn);
  }
  return true;
}

SameFrameReprojection::SameFrameReprojection(const Rigid3& cam_from_anchor_cam,
                                             const Eigen::Vector2d& observed, double weight,
                                             double bend)
    : cam_from_anchor_rotation_(cam_from_anchor_cam.rotation.toRotationMatrix()),
      anchor_center_in_cam_(cam_from_anchor_cam.translation),
      observed_(observed),
      weight_(weight),
      bend_(bend) {}

bool SameFrameReprojection::Evaluate(double const* const* parameters, double* residuals,
                                     double** jacobians) const {
  const Eigen::Vector3d ray(parameters[0][0], parameters[0][1], 1.0);
  const RightImageOffset correction = Correction(parameters[1], bend_);
  const Eigen::Matrix3d turn = correction.Matrix();
  const Eigen::Vector3d before_turn =
      cam_from_anchor_rotation_ * ray + parameters[0][2] * anchor_center_in_cam_;
  const Eigen::Vector3d in_cam = turn * before_turn;
  if (!IsInFront(in_cam)) {
    return FillBehind(residuals, jacobians, parameter_block_sizes());
  }
  Eigen::Map<Eigen::Vector2d> residual(residuals);
  residual = weight_ * (in_cam.hnormalized() - observed_);
  if (jacobians == nullptr) {
    return true;
  }
  const Eigen::Matrix<double, 2, 3> by_turned = weight_ * ProjectionJacobian(in_cam);
  const Eigen::Matrix<double, 2, 3> by_cam = by_turned * turn;
  if (jacobians[0] != nullptr) {
    Eigen::Map<Row2x3> jacobian(jacobians[0]);
    jacobian << by_cam * cam_from_anchor_rotation_.leftCols<2>(), by_cam * anchor_center_in_cam_;
  }
  if (jacobians[1] != nullptr) {
    Eigen::Map<Row2x3> jacobian(jacobians[1]);
    jacobian = by_turned * correction.ByTurn(before_turn);
  }
  return true;
}

}  // namespace gluevo::vo
