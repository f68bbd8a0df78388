#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "gluevo/vo/core/reference_focal.h"
#include "gluevo/vo/estimator/sliding_window.h"
#include "gluevo/vo/geometry/projection.h"

// Landmarks: how they get a depth, how well they fit, and what becomes of them where a frame goes.
namespace gluevo::vo {
namespace {

// u, v, inverse depth of a point of the camera's frame; nothing for one that is not in front.
std::optional<Eigen::Vector3d> ToInverseDepth(const Eigen::Vector3d& point_in_cam) {
  if (!IsInFront(point_in_cam)) {
    return std::nullopt;
  }
  return Eigen::Vector3d(point_in_cam.x(), point_in_cam.y(), 1.0) / point_in_cam.z();
}

}  // namespace

template <typename Visitor>
void SlidingWindow::ForEachView(const Landmark& landmark, Visitor visit) const {
  const RightImageUndo undo(calibration_.correction);
  const Rigid3 anchor_from_world =
      (FrameOf(landmark.views.front()).world_from_body * calibrated_rig_.body_from_cam[0])
          .Inverse();
  for (const LandmarkView& view : landmark.views) {
    const Rigid3 anchor_from_body = anchor_from_world * FrameOf(view).world_from_body;
    visit((anchor_from_body * calibrated_rig_.body_from_cam[0]).Inverse(), view.left);
    if (view.right) {
      visit((anchor_from_body * calibrated_rig_.body_from_cam[1]).Inverse(), undo(*view.right));
    }
  }
}

double SlidingWindow::InverseDepthSigma(const Landmark& landmark, double noise) const {
  // The information of all views on (u, v, inverse depth), the poses taken as known.
  Eigen::Matrix3d information = Eigen::Matrix3d::Zero();
  ForEachView(landmark, [&](const Rigid3& cam_from_anchor, const Eigen::Vector2d&) {
    const Eigen::Vector3d in_cam =
        cam_from_anchor.rotation * landmark.point->head<2>().homogeneous() +
        landmark.point->z() * cam_from_anchor.translation;
    if (IsInFront(in_cam)) {
      Eigen::Matrix3d by_point = cam_from_anchor.rotation.toRotationMatrix();
      by_point.col(2) = cam_from_anchor.translation;
      const Eigen::Matrix<double, 2, 3> jacobian = ProjectionJacobian(in_cam) * by_point;
      information += jacobian.transpose() * jacobian;
    }
  });
  const double variance = noise * noise * information.inverse()(2, 2);
  return std::isfinite(variance) && variance > 0.0 ? std::sqrt(variance) : landmark.point->z();
}

void SlidingWindow::Triangulate() {
  const int64_t newest_id = frames_.back().id;
  for (auto& [id, landmark] : landmarks_) {
    if (landmark.point) {
      continue;
    }
    landmark.point = TriangulateViews(landmark.views);
    // One wrong view must not keep a point from ever getting a depth: the newest counts.
    if (!landmark.point && landmark.views.size() > 1 &&
        landmark.views.back().frame_id == newest_id) {
      const std::vector<LandmarkView> newest = {landmark.views.back()};
      if (const auto point = TriangulateViews(newest)) {
        landmark.views = newest;
        landmark.observations = 1;
        landmark.point = point;
      }
    }
  }
}

std::optional<Eigen::Vector3d> SlidingWindow::TriangulateViews(
    const std::vector<LandmarkView>& landmark_views) const {
  const RightImageUndo undo(calibration_.correction);
  std::vector<PosedObservation> views;
  for (const LandmarkView& view : landmark_views) {
    const Rigid3& world_from_body = FrameOf(view).world_from_body;
    views.push_back({(world_from_body * calibrated_rig_.body_from_cam[0]).Inverse(), view.left});
    if (view.right) {
      views.push_back(
          {(world_from_body * calibrated_rig_.body_from_cam[1]).Inverse(), undo(*view.right)});
    }
  }
  const auto point_in_world = vo::Triangulate(views, options_.triangulation);
  if (!point_in_world) {
    return std::nullopt;
  }
  return ToInverseDepth(views.front().cam_from_world * *point_in_world);
}

std::optional<double> SlidingWindow::MeanReprojectionError(const Landmark& landmark) const {
  double sum = 0.0;
  int count = 0;
  bool in_front = true;
  ForEachView(landmark, [&](const Rigid3& cam_from_anchor, const Eigen::Vector2d& seen) {
    const Eigen::Vector3d in_cam =
        cam_from_anchor.rotation * landmark.point->head<2>().homogeneous() +
        landmark.point->z() * cam_from_anchor.translation;
    in_front = in_front && IsInFront(in_cam);
    sum += (in_cam.hnormalized() - seen).norm();
    ++count;
  });
  if (!in_front) {
    return std::nullopt;
  }
  return sum / count;
}

void SlidingWindow::RemoveOutliers() {
  for (auto it = landmarks_.begin(); it != landmarks_.end();) {
    const Landmark& landmark = it->second;
    if (!landmark.point) {
      ++it;
      continue;
    }
    const bool in_front = landmark.point->z() > 0.0;
    const auto error = in_front ? MeanReprojectionError(landmark) : std::nullopt;
    if (error && *error <= FromReferencePx(options_.max_mean_error_px)) {
      ++it;
    } else if (landmark.views.back().frame_id == frames_.back().id) {
      // The track goes on: what the newest frame sees may be right.
      it->second.views = {landmark.views.back()};
      it->second.observations = 1;
      it->second.point = TriangulateViews(landmark.views);
      ++it;
    } else {
      it = Erase(it);
    }
  }
}

std::optional<Eigen::Vector3d> SlidingWindow::PointIn(const LandmarkView& anchor,
                                                      const Eigen::Vector3d& point_in_world) const {
  const Rigid3 world_from_cam = FrameOf(anchor).world_from_body * calibrated_rig_.body_from_cam[0];
  return ToInverseDepth(world_from_cam.Inverse() * point_in_world);
}

void SlidingWindow::DropFrame(std::size_t index) {
  const int64_t frame_id = frames_[index].id;
  for (auto it = landmarks_.begin(); it != landmarks_.end();) {
    Landmark& landmark = it->second;
    const auto view = std::find_if(landmark.views.begin(), landmark.views.end(),
                                   [&](const LandmarkView& v) { return v.frame_id == frame_id; });
    if (view == landmark.views.end()) {
      ++it;
      continue;
    }
    const bool is_anchor = view == landmark.views.begin();
    std::optional<Eigen::Vector3d> point_in_world;
    if (is_anchor && landmark.point) {
      point_in_world = ToAnchoredPoint(landmark).InWorld();
    }
    landmark.views.erase(view);
    if (landmark.views.empty()) {
      it = Erase(it);
      continue;
    }
    if (point_in_world) {
      landmark.point = PointIn(landmark.views.front(), *point_in_world);
    }
    ++it;
  }
  frames_.erase(frames_.begin() + static_cast<std::ptrdiff_t>(index));
}

}  // namespace gluevo::vo
