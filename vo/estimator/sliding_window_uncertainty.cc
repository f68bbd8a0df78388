#include <algorithm>
#include <cmath>

#include "gluevo/vo/estimator/sliding_window.h"
#include "gluevo/vo/geometry/pose_uncertainty.h"
#include "sliding_window_workspace.h"

// How well the window knows where its newest frame is.
namespace gluevo::vo {
namespace {

// From a PoseTangent, whose position is in the world's axes, to the body's.
Eigen::Matrix<double, 6, 6> ToBodyAxes(const Rigid3& world_from_body) {
  Eigen::Matrix<double, 6, 6> to_body = Eigen::Matrix<double, 6, 6>::Identity();
  to_body.topLeftCorner<3, 3>() = world_from_body.rotation.toRotationMatrix().transpose();
  return to_body;
}

// The views' two rows each, less what is estimated.
double Freedom(const WindowProblem& problem) {
  const double unknowns = 3.0 * static_cast<double>(problem.points.size()) +
                          6.0 * static_cast<double>(problem.world_from_body.size() - 1);
  return 2.0 * static_cast<double>(problem.views.size()) - unknowns;
}

}  // namespace

std::optional<SlidingWindow::Motion> SlidingWindow::MotionSinceKeyframe() {
  const auto keyframe = std::find_if(frames_.rbegin() + (frames_.empty() ? 0 : 1), frames_.rend(),
                                     [](const Frame& frame) { return frame.is_keyframe; });
  if (keyframe == frames_.rend()) {
    return std::nullopt;
  }
  Workspace& workspace = *workspace_;
  WindowProblem& problem = workspace.problem;
  // Made up for or not, the calibration is not known any better.
  problem.turn_sigma = 1e-3 * options_.right_turn_sigma_mrad;
  workspace.state.Set(problem);
  workspace.equations.Set(problem);
  workspace.equations.Linearize(workspace.state);
  const auto both = workspace.equations.Covariance(static_cast<int>(FrameIndex(keyframe->id)),
                                                   static_cast<int>(frames_.size()) - 1);
  if (!both) {
    return std::nullopt;
  }
  const double freedom = Freedom(problem);
  // Of whitened residuals: 1 where they are as large as the noise that was assumed.
  const double scale = freedom > 0.0 ? 2.0 * workspace.equations.views_cost() / freedom : 1.0;
  views_noise_.Learn(scale, freedom);
  if (workspace.equations.columns().has_turn) {
    LearnCalibration(scale);
  }
  if (has_inertia()) {
    inertial_covariance_ =
        workspace.equations.CovarianceOfMotion(static_cast<int>(frames_.size()) - 1);
    if (inertial_covariance_) {
      *inertial_covariance_ *= views_noise_.Factor() * views_noise_.Factor();
    }
    if (time_offset_s_) {
      time_offset_sigma_s_ =
          views_noise_.Factor() * std::sqrt(workspace.equations.VarianceOfTimeOffset());
    }
  }
  const Rigid3& world_from_body = frames_.back().world_from_body;
  const Rigid3 keyframe_from_body = keyframe->world_from_body.Inverse() * world_from_body;
  // The error of the motion is the newest pose's less what it has of the key frame's.
  Eigen::Matrix<double, 6, 12> of_motion;
  of_motion << -ErrorThrough(keyframe_from_body) * ToBodyAxes(keyframe->world_from_body),
      ToBodyAxes(world_from_body);
  return Motion{keyframe_from_body, scale * of_motion * *both * of_motion.transpose()};
}

}  // namespace gluevo::vo
