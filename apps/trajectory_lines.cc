#include "trajectory_lines.h"

#include <algorithm>
#include <array>

namespace gluevo::apps {
namespace {

std::vector<Eigen::Vector3d> Positions(const vo::Trajectory& trajectory) {
  std::vector<Eigen::Vector3d> positions;
  for (const vo::StampedPose& pose : trajectory) {
    positions.push_back(pose.world_from_body.translation);
  }
  return positions;
}

}  // namespace

TrajectoryLines AlignWhole(const vo::Trajectory& estimate, const vo::Trajectory& groundtruth,
                           const vo::Evaluation& evaluation) {
  TrajectoryLines lines = {.groundtruth = Positions(groundtruth), .estimate = {{}}};
  for (const Eigen::Vector3d& position : Positions(estimate)) {
    lines.estimate.front().push_back(evaluation.groundtruth_world_from_estimate_world * position);
  }
  return lines;
}

TrajectoryLines AlignSegments(const vo::Trajectory& estimate,
                              const std::vector<int>& segment_of_pose,
                              const vo::Trajectory& groundtruth,
                              const vo::SegmentedEvaluation& evaluation) {
  TrajectoryLines lines = {.groundtruth = Positions(groundtruth), .estimate = {}};
  for (const vo::SegmentedEvaluation::Segment& segment : evaluation.segments) {
    if (!segment.evaluation) {
      continue;
    }
    lines.estimate.emplace_back();
    for (std::size_t i = 0; i < estimate.size(); ++i) {
      if (segment_of_pose[i] == segment.number) {
        lines.estimate.back().push_back(segment.evaluation->groundtruth_world_from_estimate_world *
                                        estimate[i].world_from_body.translation);
      }
    }
  }
  return lines;
}

double PlanView::Extent() const {
  constexpr double kLeast = 1e-6;
  return box.isEmpty() ? kLeast : std::max({box.sizes()[across], box.sizes()[up], kLeast});
}

PlanView ChooseView(const TrajectoryLines& lines) {
  PlanView view;
  for (const Eigen::Vector3d& point : lines.groundtruth) {
    view.box.extend(point);
  }
  Eigen::AlignedBox3d shape = view.box;
  for (const std::vector<Eigen::Vector3d>& line : lines.estimate) {
    for (const Eigen::Vector3d& point : line) {
      view.box.extend(point);
    }
  }
  if (shape.isEmpty()) {
    shape = view.box;
  }
  if (shape.isEmpty()) {
    return view;
  }
  std::array<int, 3> axes = {0, 1, 2};
  std::stable_sort(axes.begin(), axes.end(),
                   [&](int a, int b) { return shape.sizes()[a] > shape.sizes()[b]; });
  view.across = std::min(axes[0], axes[1]);
  view.up = std::max(axes[0], axes[1]);
  return view;
}

}  // namespace gluevo::apps
