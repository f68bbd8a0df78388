#include "gluevo/vo/geometry/pose_uncertainty.h"

#include "gluevo/vo/geometry/manifold.h"

namespace gluevo::vo {

Eigen::Matrix<double, 6, 6> ErrorThrough(const Rigid3& b_from_c) {
  const Eigen::Matrix3d c_from_b = b_from_c.rotation.toRotationMatrix().transpose();
  Eigen::Matrix<double, 6, 6> through;
  through << c_from_b, -c_from_b * Skew(b_from_c.translation), Eigen::Matrix3d::Zero(), c_from_b;
  return through;
}

PoseCovariance Compose(const PoseCovariance& of_a_from_b, const Rigid3& b_from_c,
                       const PoseCovariance& of_b_from_c) {
  const Eigen::Matrix<double, 6, 6> through = ErrorThrough(b_from_c);
  return through * of_a_from_b * through.transpose() + of_b_from_c;
}

Eigen::Matrix<double, 6, 1> ErrorOfPose(const Rigid3& estimated_a_from_b,
                                        const Rigid3& true_a_from_b) {
  const Rigid3 error = estimated_a_from_b.Inverse() * true_a_from_b;
  Eigen::Matrix<double, 6, 1> vector;
  vector << error.translation, LogSo3(error.rotation);
  return vector;
}

}  // namespace gluevo::vo
