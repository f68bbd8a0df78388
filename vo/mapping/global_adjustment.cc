#include "gluevo/vo/mapping/global_adjustment.h"

#include <ceres/ceres.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>

#include "global_tracks.h"
#include "gluevo/vo/core/options_check.h"
#include "gluevo/vo/core/reference_focal.h"
#include "pose_graph_cost.h"

namespace gluevo::vo {
namespace {

using internal::GlobalTrack;
using internal::KeyframeView;

constexpr double kHuber = 2.0;       // Standard deviations.
constexpr double kMotionLoss = 4.0;  // As in the pose graph.
constexpr int kMostIterations = 30;
constexpr double kLargestErrorPx = 10.0;  // That a view held out counts for.

// Of one camera's view of a point, in standard deviations.
class ViewResidual {
 public:
  ViewResidual(const Rigid3& cam_from_body, Eigen::Vector2d seen, double noise)
      : cam_from_body_(cam_from_body), seen_(std::move(seen)), noise_(noise) {}

  template <typename T>
  bool operator()(const T* pose, const T* point, T* residual) const {
    using Vector = Eigen::Matrix<T, 3, 1>;
    const Eigen::Map<const Eigen::Quaternion<T>> world_from_body(pose + 3);
    const Vector in_body = world_from_body.conjugate() *
                           (Eigen::Map<const Vector>(point) - Eigen::Map<const Vector>(pose));
    const Vector in_cam =
        cam_from_body_.rotation.cast<T>() * in_body + cam_from_body_.translation.cast<T>();
    const T depth = in_cam.z() > T(kNearest) ? in_cam.z() : T(kNearest);
    residual[0] = (in_cam.x() / depth - T(seen_.x())) / T(noise_);
    residual[1] = (in_cam.y() / depth - T(seen_.y())) / T(noise_);
    return true;
  }

 private:
  static constexpr double kNearest = 0.05;  // Metres.

  Rigid3 cam_from_body_;
  Eigen::Vector2d seen_;
  double noise_;
};

struct HeldOut {
  KeyframeView view;
  std::size_t point = 0;
};

class Adjustment {
 public:
  Adjustment(const LoopCloser& closer, const std::vector<Rigid3>& world_from_body,
             const std::vector<GlobalTrack>& tracks, const GlobalAdjustmentOptions& options)
      : closer_(closer), options_(options) {
    poses_.reserve(world_from_body.size());
    for (const Rigid3& pose : world_from_body) {
      poses_.push_back(internal::ParametersOf(pose));
    }
    points_.resize(tracks.size());
    ceres::Problem::Options problem_options;
    problem_options.loss_function_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
    problem_.emplace(problem_options);
    std::size_t countdown = 0;
    for (std::size_t i = 0; i < tracks.size(); ++i) {
      const bool is_judge = tracks[i].size() > 2 &&
                            countdown++ % static_cast<std::size_t>(options.held_out_every) == 0;
      GlobalTrack known = tracks[i];
      if (is_judge) {
        known.erase(known.begin() + static_cast<std::ptrdiff_t>(known.size() / 2));
      }
      known = Start(known, world_from_body, points_[i]);
      if (known.size() < 2) {
        continue;
      }
      ++landmarks_;
      for (const KeyframeView& view : known) {
        Add(view, i);
      }
      if (is_judge) {
        held_out_.push_back({tracks[i][tracks[i].size() / 2], i});
      }
    }
    AddOdometry();
  }

  void SolvePoints() {
    for (internal::PoseParameters& pose : poses_) {
      if (problem_->HasParameterBlock(pose.data())) {
        problem_->SetParameterBlockConstant(pose.data());
      }
    }
    Solve();
  }

  void SolveAll() {
    const std::vector<PoseGraphNode> nodes = closer_.Graph().nodes;
    for (std::size_t i = 0; i < poses_.size(); ++i) {
      if (problem_->HasParameterBlock(poses_[i].data()) && !nodes[i].is_fixed) {
        problem_->SetParameterBlockVariable(poses_[i].data());
        problem_->SetManifold(poses_[i].data(), new internal::PoseManifold(nodes[i].up_in_world));
      }
    }
    Solve();
  }

  double HeldOutErrorPx() const {
    double sum = 0.0;
    for (const HeldOut& held_out : held_out_) {
      sum +=
          ErrorsPx(held_out.view, points_[held_out.point].data()).cwiseMin(kLargestErrorPx).mean();
    }
    return sum / static_cast<double>(std::max<std::size_t>(1, held_out_.size()));
  }

  std::vector<Rigid3> Poses() const {
    std::vector<Rigid3> poses;
    poses.reserve(poses_.size());
    for (const internal::PoseParameters& pose : poses_) {
      poses.push_back(internal::PoseOf(pose.data()));
    }
    return poses;
  }
  std::size_t observations() const { return observations_; }
  std::size_t landmarks() const { return landmarks_; }
  std::size_t held_out() const { return held_out_.size(); }

 private:
  const StereoKeypoint& KeypointOf(const KeyframeView& view) const {
    return closer_.keyframes()[view.keyframe].keypoints[view.keypoint];
  }

  // Where that of its views has it with which the others agree best; the answer is those that do.
  GlobalTrack Start(const GlobalTrack& track, const std::vector<Rigid3>& world_from_body,
                    std::array<double, 3>& point) const {
    GlobalTrack fitting;
    double least = std::numeric_limits<double>::infinity();
    for (const KeyframeView& anchor : track) {
      if (KeypointOf(anchor).inverse_depth <= 0.0) {
        continue;
      }
      const Eigen::Vector3d start = internal::PointInWorld(closer_, world_from_body, anchor);
      GlobalTrack agree;
      double sum = 0.0;
      for (const KeyframeView& view : track) {
        const double error = ErrorsPx(view, start.data()).maxCoeff();
        sum += std::min(error, options_.max_error_px);
        if (error < options_.max_error_px) {
          agree.push_back(view);
        }
      }
      if (sum < least) {
        least = sum;
        fitting = std::move(agree);
        std::copy(start.begin(), start.end(), point.begin());
      }
    }
    return fitting;
  }

  // In the left and, where it is seen there, the right image; else twice in the left one.
  Eigen::Vector2d ErrorsPx(const KeyframeView& view, const double* point) const {
    const StereoKeypoint& keypoint = KeypointOf(view);
    Eigen::Vector2d errors;
    for (const std::size_t side : {std::size_t{0}, std::size_t{1}}) {
      const bool is_right = side == 1 && keypoint.has_right;
      std::array<double, 2> error{};
      ViewResidual(closer_.rig().body_from_cam[is_right ? 1 : 0].Inverse(),
                   is_right ? keypoint.right : keypoint.left,
                   FromReferencePx(1.0))(poses_[view.keyframe].data(), point, error.data());
      errors[static_cast<Eigen::Index>(side)] = std::hypot(error[0], error[1]);
    }
    return errors;
  }

  void Add(const KeyframeView& view, std::size_t point) {
    using Cost = ceres::AutoDiffCostFunction<ViewResidual, 2, internal::kPoseSize, 3>;
    const StereoKeypoint& keypoint = KeypointOf(view);
    const double noise = FromReferencePx(options_.noise_px);
    for (const std::size_t side : {std::size_t{0}, std::size_t{1}}) {
      if (side == 0 || keypoint.has_right) {
        problem_->AddResidualBlock(
            new Cost(new ViewResidual(closer_.rig().body_from_cam[side].Inverse(),
                                      side == 0 ? keypoint.left : keypoint.right, noise)),
            &view_loss_, poses_[view.keyframe].data(), points_[point].data());
      }
    }
    ++observations_;
  }

  void AddOdometry() {
    for (const PoseGraphEdge& edge : closer_.Graph().edges) {
      if (edge.b == edge.a + 1 &&
          closer_.keyframes()[edge.a].segment == closer_.keyframes()[edge.b].segment) {
        problem_->AddResidualBlock(new internal::EdgeCost(edge), &odometry_loss_,
                                   poses_[edge.a].data(), poses_[edge.b].data());
      }
    }
  }

  void Solve() {
    ceres::Solver::Options options;
    options.linear_solver_type = ceres::SPARSE_SCHUR;
    options.max_num_iterations = kMostIterations;
    options.num_threads = 1;
    options.logging_type = ceres::SILENT;
    ceres::Solver::Summary summary;
    ceres::Solve(options, &*problem_, &summary);
  }

  const LoopCloser& closer_;
  const GlobalAdjustmentOptions& options_;
  std::vector<internal::PoseParameters> poses_;
  std::vector<std::array<double, 3>> points_;
  std::vector<HeldOut> held_out_;
  std::size_t landmarks_ = 0;
  std::size_t observations_ = 0;
  ceres::HuberLoss view_loss_{kHuber};
  ceres::CauchyLoss odometry_loss_{kMotionLoss};
  std::optional<ceres::Problem> problem_;  // After what it points to.
};

}  // namespace

void GlobalAdjustmentOptions::Validate() const {
  CheckWithin(match_threshold, 0.0, 1.0, "final_adjustment.match_threshold");
  CheckPositive(max_error_px, "final_adjustment.max_error_px");
  CheckPositive(noise_px, "final_adjustment.noise_px");
  CheckAtLeast(held_out_every, 1, "final_adjustment.held_out_every");
}

GlobalAdjustment AdjustGlobally(const LoopCloser& closer,
                                const std::vector<Rigid3>& world_from_body, Matcher& matcher,
                                const GlobalAdjustmentOptions& options) {
  options.Validate();
  const std::vector<GlobalTrack> tracks =
      internal::FindTracks(closer, world_from_body, matcher, options);
  GlobalAdjustment result{.world_from_body = world_from_body};
  Adjustment adjustment(closer, world_from_body, tracks, options);
  result.landmarks = adjustment.landmarks();
  result.observations = adjustment.observations();
  result.held_out = adjustment.held_out();
  if (result.held_out == 0) {
    return result;
  }
  adjustment.SolvePoints();
  result.error_before_px = adjustment.HeldOutErrorPx();
  adjustment.SolveAll();
  result.error_after_px = adjustment.HeldOutErrorPx();
  if (result.error_after_px < result.error_before_px) {
    result.is_kept = true;
    result.world_from_body = adjustment.Poses();
  }
  return result;
}

}  // namespace gluevo::vo
