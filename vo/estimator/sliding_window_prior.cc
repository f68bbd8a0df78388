#include <algorithm>
#include <cmath>
#include <vector>

#include "gluevo/vo/core/reference_focal.h"
#include "gluevo/vo/estimator/sliding_window.h"
#include "pose_manifold.h"
#include "reprojection_factors.h"

namespace gluevo::vo {
namespace {

constexpr int kPose = PosePrior::kPose;
constexpr int kTurn = PosePrior::kTurn;

// A factor's residual at one state and its derivatives at another, by the tangents of its poses.
class Linearized {
 public:
  Linearized(const ceres::CostFunction& factor, const std::vector<const double*>& at,
             const std::vector<const double*>& derivatives_at) {
    std::vector<double*> pointers;
    for (const int32_t size : factor.parameter_block_sizes()) {
      ambient_.emplace_back(2, size);
      pointers.push_back(ambient_.back().data());
    }
    Eigen::Vector2d unused;
    factor.Evaluate(at.data(), residual_.data(), nullptr);
    factor.Evaluate(derivatives_at.data(), unused.data(), pointers.data());
  }

  const Eigen::Vector2d& residual() const { return residual_; }
  Eigen::Matrix<double, 2, 3> ByVector(std::size_t block) const { return ambient_[block]; }
  Eigen::Matrix<double, 2, kPose> ByPose(std::size_t block, const double* pose) const {
    Eigen::Matrix<double, PoseManifold::kAmbientSize, kPose, Eigen::RowMajor> plus;
    PoseManifold().PlusJacobian(pose, plus.data());
    return ambient_[block] * plus;
  }

 private:
  using RowMajor = Eigen::Matrix<double, 2, Eigen::Dynamic, Eigen::RowMajor>;
  Eigen::Vector2d residual_;
  std::vector<RowMajor> ambient_;
};

// All residuals of a landmark, two rows each, weighted as the loss weighs them now.
class LandmarkRows {
 public:
  LandmarkRows(std::size_t views, std::size_t frames, double huber)
      : by_state_(Eigen::MatrixXd::Zero(static_cast<Eigen::Index>(4 * views),
                                        static_cast<Eigen::Index>(kPose * frames) + kTurn)),
        by_landmark_(Eigen::MatrixXd::Zero(by_state_.rows(), 3)),
        residual_(Eigen::VectorXd::Zero(by_state_.rows())),
        huber_(huber) {}

  void SetPose(std::size_t frame, const Eigen::Matrix<double, 2, kPose>& derivative) {
    by_state_.block<2, kPose>(row_, static_cast<Eigen::Index>(kPose * frame)) = derivative;
  }
  void SetTurn(const Eigen::Matrix<double, 2, kTurn>& derivative) {
    by_state_.block<2, kTurn>(row_, by_state_.cols() - kTurn) = derivative;
  }
  // Ends the rows whose other derivatives have been set.
  void Finish(const Eigen::Vector2d& residual, const Eigen::Matrix<double, 2, 3>& by_landmark) {
    const double robust = std::sqrt(std::min(1.0, huber_ / residual.norm()));
    by_state_.middleRows<2>(row_) *= robust;
    by_landmark_.middleRows<2>(row_) = robust * by_landmark;
    residual_.segment<2>(row_) = robust * residual;
    row_ += 2;
  }
  void AddTo(Marginalizer& marginalizer, const Eigen::VectorXd& delta) const {
    marginalizer.AddLandmark(by_state_.topRows(row_), by_landmark_.topRows(row_),
                             residual_.head(row_), delta);
  }

 private:
  Eigen::MatrixXd by_state_;
  Eigen::Matrix<double, Eigen::Dynamic, 3> by_landmark_;
  Eigen::VectorXd residual_;
  double huber_;
  Eigen::Index row_ = 0;
};

}  // namespace

// Where residuals are taken and where their derivatives are, one pose a frame, and what lies
// between the two, by the tangents of the whole state.
struct SlidingWindow::Linearization {
  std::vector<PoseParameters> present, first_estimates;
  Eigen::VectorXd delta;
};

void SlidingWindow::MarginalizeOldest() {
  PosePrior linearization;
  linearization.body_from_right = prior_ ? prior_->body_from_right : rig_.body_from_cam[1].rotation;
  for (const Frame& frame : frames_) {
    const auto in_prior = prior_ ? prior_->Find(frame.id) : std::nullopt;
    linearization.frame_ids.push_back(frame.id);
    linearization.world_from_body.push_back(in_prior ? prior_->world_from_body[*in_prior]
                                                     : frame.world_from_body);
  }
  Marginalizer marginalizer(linearization.frame_ids, linearization.world_from_body,
                            linearization.body_from_right);
  if (prior_) {
    marginalizer.AddPrior(*prior_);
  }
  const Linearization at = LinearizeAt(linearization);
  const int64_t oldest_id = frames_.front().id;
  const int64_t newest_id = frames_.back().id;
  for (auto it = landmarks_.begin(); it != landmarks_.end();) {
    const Landmark& landmark = it->second;
    if (landmark.views.front().frame_id != oldest_id || !landmark.point ||
        landmark.views.back().frame_id == newest_id) {
      ++it;
      continue;
    }
    if (landmark.views.size() > 1) {
      AddToMarginalizer(landmark, at, marginalizer);
    }
    it = Erase(it);
  }
  prior_ = marginalizer.Eliminate(oldest_id);
}

SlidingWindow::Linearization SlidingWindow::LinearizeAt(const PosePrior& prior) const {
  Linearization at;
  std::vector<Rigid3> present;
  for (std::size_t i = 0; i < frames_.size(); ++i) {
    present.push_back(frames_[i].world_from_body);
    at.present.push_back(ToParameters(present.back()));
    at.first_estimates.push_back(ToParameters(prior.world_from_body[i]));
  }
  at.delta = prior.Delta(present, rig_.body_from_cam[1].rotation);
  return at;
}

void SlidingWindow::AddToMarginalizer(const Landmark& landmark, const Linearization& at,
                                      Marginalizer& marginalizer) const {
  const bool is_turn_known = options_.right_turn_sigma_mrad == 0.0;
  const Eigen::Vector3d no_turn = Eigen::Vector3d::Zero();
  const double* const point = landmark.point->data();
  const double weight = 1.0 / FromReferencePx(options_.noise_px);
  const std::size_t anchor = FrameIndex(landmark.views.front().frame_id);
  LandmarkRows rows(landmark.views.size(), frames_.size(), options_.huber);

  const auto add_same_frame = [&](int camera, const Eigen::Vector2d& seen) {
    const Rigid3 cam_from_anchor = camera == 0 ? Rigid3{} : rig_.right_from_left();
    const SameFrameReprojection factor(cam_from_anchor, seen, weight);
    const Linearized linearized(factor, {point, no_turn.data()}, {point, no_turn.data()});
    if (camera == 1 && !is_turn_known) {
      rows.SetTurn(linearized.ByVector(1));
    }
    rows.Finish(linearized.residual(), linearized.ByVector(0));
  };
  const auto add_other_frame = [&](std::size_t frame, int camera, const Eigen::Vector2d& seen) {
    const OtherFrameReprojection factor(rig_.body_from_cam[0], rig_.body_from_cam[camera], seen,
                                        weight);
    const Linearized linearized(
        factor, {at.present[anchor].data(), at.present[frame].data(), point, no_turn.data()},
        {at.first_estimates[anchor].data(), at.first_estimates[frame].data(), point,
         no_turn.data()});
    rows.SetPose(anchor, linearized.ByPose(0, at.first_estimates[anchor].data()));
    rows.SetPose(frame, linearized.ByPose(1, at.first_estimates[frame].data()));
    if (camera == 1 && !is_turn_known) {
      rows.SetTurn(linearized.ByVector(3));
    }
    rows.Finish(linearized.residual(), linearized.ByVector(2));
  };
  for (const LandmarkView& view : landmark.views) {
    const std::size_t frame = FrameIndex(view.frame_id);
    const auto add = [&](int camera, const Eigen::Vector2d& seen) {
      frame == anchor ? add_same_frame(camera, seen) : add_other_frame(frame, camera, seen);
    };
    add(0, view.left);
    if (view.right) {
      add(1, *view.right);
    }
  }
  rows.AddTo(marginalizer, at.delta);
}

}  // namespace gluevo::vo
