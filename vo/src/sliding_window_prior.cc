#include <algorithm>
#include <vector>

#include "gluevo/vo/reprojection_factors.h"
#include "gluevo/vo/sliding_window.h"

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

}  // namespace

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
      AddToMarginalizer(landmark, marginalizer, linearization);
    }
    it = Erase(it);
  }
  prior_ = marginalizer.Eliminate(oldest_id);
}

void SlidingWindow::AddToMarginalizer(const Landmark& landmark, Marginalizer& marginalizer,
                                      const PosePrior& linearization) const {
  std::vector<PoseParameters> present, first_estimates;
  std::vector<Rigid3> present_poses;
  for (std::size_t i = 0; i < frames_.size(); ++i) {
    present_poses.push_back(frames_[i].world_from_body);
    present.push_back(ToParameters(present_poses.back()));
    first_estimates.push_back(ToParameters(linearization.world_from_body[i]));
  }
  const Eigen::Vector3d no_turn = Eigen::Vector3d::Zero();
  const double weight = 1.0 / options_.noise;
  const Rigid3 right_from_left = rig_.right_from_left();
  const std::size_t views = landmark.views.size();
  const auto columns = static_cast<Eigen::Index>(kPose * frames_.size() + kTurn);
  Eigen::MatrixXd by_state = Eigen::MatrixXd::Zero(static_cast<Eigen::Index>(4 * views), columns);
  Eigen::Matrix<double, Eigen::Dynamic, 3> by_landmark =
      Eigen::Matrix<double, Eigen::Dynamic, 3>::Zero(by_state.rows(), 3);
  Eigen::VectorXd residual = Eigen::VectorXd::Zero(by_state.rows());
  Eigen::Index row = 0;
  const auto add = [&](const Linearized& factor, Eigen::Matrix<double, 2, 3> by_point,
                       bool is_right, std::size_t turn_block) {
    // As the loss weighs it now.
    const double robust = std::sqrt(std::min(1.0, options_.huber / factor.residual().norm()));
    if (is_right && options_.right_turn_sigma > 0.0) {
      by_state.block<2, kTurn>(row, columns - kTurn) = factor.ByVector(turn_block);
    }
    by_landmark.middleRows<2>(row) = by_point;
    residual.segment<2>(row) = factor.residual();
    by_state.middleRows<2>(row) *= robust;
    by_landmark.middleRows<2>(row) *= robust;
    residual.segment<2>(row) *= robust;
    row += 2;
  };
  const LandmarkView& anchor = landmark.views.front();
  const std::size_t anchor_index = FrameIndex(anchor.frame_id);
  const auto add_same = [&](const Rigid3& cam_from_anchor, const Eigen::Vector2d& seen,
                            bool is_right) {
    const SameFrameReprojection factor(cam_from_anchor, seen, weight);
    const std::vector<const double*> parameters = {landmark.point->data(), no_turn.data()};
    const Linearized linearized(factor, parameters, parameters);
    add(linearized, linearized.ByVector(0), is_right, 1);
  };
  add_same({}, anchor.left, false);
  if (anchor.right) {
    add_same(right_from_left, *anchor.right, true);
  }
  const auto add_other = [&](std::size_t index, int camera, const Eigen::Vector2d& seen) {
    const OtherFrameReprojection factor(rig_.body_from_cam[0], rig_.body_from_cam[camera], seen,
                                        weight);
    const Linearized linearized(
        factor,
        {present[anchor_index].data(), present[index].data(), landmark.point->data(),
         no_turn.data()},
        {first_estimates[anchor_index].data(), first_estimates[index].data(),
         landmark.point->data(), no_turn.data()});
    by_state.block<2, kPose>(row, static_cast<Eigen::Index>(kPose * anchor_index)) =
        linearized.ByPose(0, first_estimates[anchor_index].data());
    by_state.block<2, kPose>(row, static_cast<Eigen::Index>(kPose * index)) =
        linearized.ByPose(1, first_estimates[index].data());
    add(linearized, linearized.ByVector(2), camera == 1, 3);
  };
  for (std::size_t i = 1; i < views; ++i) {
    const LandmarkView& view = landmark.views[i];
    add_other(FrameIndex(view.frame_id), 0, view.left);
    if (view.right) {
      add_other(FrameIndex(view.frame_id), 1, *view.right);
    }
  }
  marginalizer.AddLandmark(by_state.topRows(row), by_landmark.topRows(row), residual.head(row),
                           linearization.Delta(present_poses, rig_.body_from_cam[1].rotation));
}

}  // namespace gluevo::vo
