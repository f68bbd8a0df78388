#include "world.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>

namespace gluevo::simulation {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

/// The slab method (Kay and Kajiya 1986): the span of the ray inside the box and the axes whose
/// slabs bound it.
struct Span {
  double enter = -kInfinity;
  double leave = kInfinity;
  int enter_axis = 0;
  int leave_axis = 0;
};

Span Intersect(const Eigen::Vector3d& eye, const Eigen::Vector3d& direction,
               const Eigen::Vector3d& half_size) {
  Span span;
  for (int axis = 0; axis < 3; ++axis) {
    if (direction[axis] == 0.0) {
      if (std::abs(eye[axis]) > half_size[axis]) span.leave = -kInfinity;
      continue;
    }
    const double inverse = 1.0 / direction[axis];
    const double middle = -eye[axis] * inverse;
    const double reach = half_size[axis] * std::abs(inverse);
    if (middle - reach > span.enter) {
      span.enter = middle - reach;
      span.enter_axis = axis;
    }
    if (middle + reach < span.leave) {
      span.leave = middle + reach;
      span.leave_axis = axis;
    }
  }
  return span;
}

}  // namespace

Eigen::Vector2d SimulatedBox::FaceSize(int face) const {
  const int axis = face / 2;
  return 2.0 * Eigen::Vector2d(half_size[axis == 0 ? 1 : 0], half_size[axis == 2 ? 1 : 2]);
}

Eigen::Vector3d SimulatedBox::BoxFromWorld(const Eigen::Vector3d& point_in_world) const {
  return Eigen::AngleAxisd(-yaw, Eigen::Vector3d::UnitZ()) * (point_in_world - center);
}

Eigen::Vector3d SimulatedBox::WorldFromBox(const Eigen::Vector3d& point_in_box) const {
  return Eigen::AngleAxisd(yaw, Eigen::Vector3d::UnitZ()) * point_in_box + center;
}

double SimulatedBox::Distance(const Eigen::Vector3d& point_in_world) const {
  const Eigen::Vector3d point = BoxFromWorld(point_in_world);
  return (point.cwiseAbs() - half_size).cwiseMax(0.0).norm();
}

WorldView::Placed WorldView::Place(const SimulatedBox& box, const Eigen::Vector3d& eye_in_world) {
  Placed placed;
  placed.eye = box.BoxFromWorld(eye_in_world);
  placed.half_size = box.half_size;
  placed.cosine = std::cos(box.yaw);
  placed.sine = std::sin(box.yaw);
  return placed;
}

WorldView::WorldView(const SimulatedWorld& world, const Eigen::Vector3d& eye_in_world)
    : room_(Place(world.room, eye_in_world)) {
  for (const SimulatedBox& box : world.boxes) boxes_.push_back(Place(box, eye_in_world));
}

std::optional<SurfaceHit> WorldView::Cast(const Eigen::Vector3d& direction_in_world) const {
  if (!direction_in_world.allFinite()) return std::nullopt;
  const auto rotate = [&](const Placed& placed) {
    return Eigen::Vector3d(
        placed.cosine * direction_in_world.x() + placed.sine * direction_in_world.y(),
        placed.cosine * direction_in_world.y() - placed.sine * direction_in_world.x(),
        direction_in_world.z());
  };
  Eigen::Vector3d direction = rotate(room_);
  const Span room = Intersect(room_.eye, direction, room_.half_size);
  if (!(room.enter <= 0.0 && room.leave >= 0.0)) return std::nullopt;
  SurfaceHit hit;
  hit.distance = room.leave;
  int axis = room.leave_axis;
  bool positive = direction[axis] > 0.0;
  const Placed* nearest = &room_;
  for (std::size_t i = 0; i < boxes_.size(); ++i) {
    const Eigen::Vector3d turned = rotate(boxes_[i]);
    const Span span = Intersect(boxes_[i].eye, turned, boxes_[i].half_size);
    if (span.enter > 0.0 && span.enter <= span.leave && span.enter < hit.distance) {
      hit.distance = span.enter;
      hit.box = static_cast<int>(i);
      axis = span.enter_axis;
      positive = turned[axis] < 0.0;
      nearest = &boxes_[i];
      direction = turned;
    }
  }
  hit.face = 2 * axis + (positive ? 1 : 0);
  const int u_axis = axis == 0 ? 1 : 0;
  const int v_axis = axis == 2 ? 1 : 2;
  hit.u = nearest->eye[u_axis] + hit.distance * direction[u_axis] + nearest->half_size[u_axis];
  hit.v = nearest->eye[v_axis] + hit.distance * direction[v_axis] + nearest->half_size[v_axis];
  return hit;
}

}  // namespace gluevo::simulation
