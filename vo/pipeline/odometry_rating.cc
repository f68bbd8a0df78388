#include "gluevo/vo/estimator/sliding_window.h"
#include "gluevo/vo/pipeline/odometry.h"

// How good poses are.
namespace gluevo::vo {

void Odometry::Rate(bool is_linked, FrameResult& result) {
  if (!is_linked) {
    uncertainty_.Start();
    result.motion_from_ns = result.timestamp_ns;
  } else if (const auto motion = window_->MotionSinceKeyframe()) {
    result.keyframe_from_body = motion->keyframe_from_body;
    result.motion_from_ns = keyframe_ns_;
    result.motion_covariance = motion->covariance;
    result.path_covariance =
        uncertainty_.Add(motion->keyframe_from_body, motion->covariance, result.is_keyframe);
  } else {
    RateByMotionBefore(result);
  }
  if (const StereoCalibration& calibration = window_->calibration(); calibration.is_known) {
    result.stereo_calibration = {calibration.turn, calibration.turn_sigma, calibration.is_off,
                                 calibration.correction.bend == 1.0, rig_.cameras[1].fx};
  }
  if (result.is_keyframe) {
    keyframe_ns_ = result.timestamp_ns;
  }
}

void Odometry::RateByMotionBefore(FrameResult& result) const {
  const StampedPose& last = *history_.last();
  result.keyframe_from_body = last.world_from_body.Inverse() * result.world_from_body;
  result.motion_from_ns = last.timestamp_ns;
  result.motion_covariance =
      expected_ ? expected_->covariance : history_.PredictionCovariance(result.timestamp_ns);
  result.path_covariance = uncertainty_.After(result.keyframe_from_body, result.motion_covariance);
}

}  // namespace gluevo::vo
