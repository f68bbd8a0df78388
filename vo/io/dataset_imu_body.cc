#include "gluevo/vo/io/dataset.h"

namespace gluevo::vo {

void PutBodyAtImu(Dataset& dataset) {
  if (!dataset.imu || dataset.imu->imu_in_body.isZero()) {
    return;
  }
  const Rigid3 body_from_imu = {Eigen::Quaterniond::Identity(), dataset.imu->imu_in_body};
  for (Rigid3& body_from_cam : dataset.rig.body_from_cam) {
    body_from_cam = body_from_imu.Inverse() * body_from_cam;
  }
  if (dataset.groundtruth) {
    for (StampedPose& pose : *dataset.groundtruth) {
      pose.world_from_body = pose.world_from_body * body_from_imu;
    }
  }
  dataset.rig.body_frame = "imu, along the axes of the " + dataset.rig.body_frame;
  dataset.imu->imu_in_body.setZero();
}

}  // namespace gluevo::vo
