#include "gluevo/vo/estimator/pose_prior.h"

// Priors know nothing of where the world is and how it is turned: in another world they say the
// same.
namespace gluevo::vo {

TurnedGravityEstimate InTurnedWorld(const GravityEstimate& gravity,
                                    const Eigen::Quaterniond& new_from_old_world) {
  TurnedGravityEstimate turned;
  turned.gravity.first_in_world = new_from_old_world * gravity.first_in_world;
  // Both tangents are of the same plane, but their axes need not be the same.
  turned.by_turn =
      GravityTangent(turned.gravity.first_in_world).transpose() *
      (new_from_old_world.toRotationMatrix() * GravityTangent(gravity.first_in_world)) /
      gravity.first_in_world.squaredNorm();
  turned.gravity.turn = turned.by_turn * gravity.turn;
  return turned;
}

PosePrior InTurnedWorld(const PosePrior& prior, const Eigen::Quaterniond& new_from_old_world,
                        const Eigen::Vector3d& center, const GravityEstimate& gravity) {
  PosePrior turned = prior;
  const Eigen::Matrix3d old_from_new = new_from_old_world.conjugate().toRotationMatrix();
  for (std::size_t i = 0; i < prior.world_from_body.size(); ++i) {
    const Rigid3& pose = prior.world_from_body[i];
    turned.world_from_body[i] = {(new_from_old_world * pose.rotation).normalized(),
                                 center + new_from_old_world * (pose.translation - center)};
    const auto position = static_cast<Eigen::Index>(PosePrior::kPose * i);
    turned.jacobian.middleCols<3>(position) = prior.jacobian.middleCols<3>(position) * old_from_new;
  }
  for (std::size_t i = 0; i < prior.motions.size(); ++i) {
    turned.motions[i].velocity_in_world = new_from_old_world * prior.motions[i].velocity_in_world;
    turned.jacobian.middleCols<3>(prior.MotionColumn(i)) =
        prior.jacobian.middleCols<3>(prior.MotionColumn(i)) * old_from_new;
  }
  if (prior.gravity_turn) {
    const Eigen::Matrix2d by_turn = InTurnedWorld(gravity, new_from_old_world).by_turn;
    turned.gravity_turn = by_turn * *prior.gravity_turn;
    turned.jacobian.middleCols<PosePrior::kGravity>(prior.GravityColumn()) =
        prior.jacobian.middleCols<PosePrior::kGravity>(prior.GravityColumn()) * by_turn.transpose();
  }
  return turned;
}

}  // namespace gluevo::vo
