#include "view.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>

#include "parallel_for.h"

namespace gluevo::simulation {
namespace {

FaceView::Form ToForm(const Eigen::RowVector3d& row) {
  return {static_cast<float>(row.x()), static_cast<float>(row.y()), static_cast<float>(row.z())};
}

void AddFaces(const SimulatedBox& box, int index, const vo::Rigid3& world_from_cam,
              std::vector<FaceView>* faces) {
  const bool inward = index < 0;
  const Eigen::Vector3d eye = box.BoxFromWorld(world_from_cam.translation);
  const Eigen::Matrix3d box_from_cam = Eigen::AngleAxisd(-box.yaw, Eigen::Vector3d::UnitZ()) *
                                       world_from_cam.rotation.toRotationMatrix();
  for (int face = 0; face < 6; ++face) {
    const int axis = face / 2;
    const double side = face % 2 == 1 ? 1.0 : -1.0;
    // Towards the plane, from where its texture is seen.
    const double sign = inward ? side : -side;
    const double distance = sign * (side * box.half_size[axis] - eye[axis]);
    if (!(distance > 0.0)) continue;
    const int u_axis = axis == 0 ? 1 : 0;
    const int v_axis = axis == 2 ? 1 : 2;
    Eigen::Matrix3d homography;
    homography.row(2) = sign * box_from_cam.row(axis);
    homography.row(0) = (eye[u_axis] + box.half_size[u_axis]) * homography.row(2) +
                        distance * box_from_cam.row(u_axis);
    homography.row(1) = (eye[v_axis] + box.half_size[v_axis]) * homography.row(2) +
                        distance * box_from_cam.row(v_axis);
    FaceView view;
    view.across = ToForm(homography.row(2));
    view.along_u = ToForm(homography.row(0));
    view.along_v = ToForm(homography.row(1));
    view.distance = static_cast<float>(distance);
    const Eigen::Vector2f size = box.FaceSize(face).cast<float>();
    view.width = size.x();
    view.height = size.y();
    view.log2_scale = static_cast<float>(std::log2(distance * distance));
    view.texture = &box.faces[face];
    view.box = index;
    view.face = face;
    faces->push_back(view);
  }
}

/// Whether rays of the tile can meet the face: none where all corners of the tile's box (a convex
/// set) are on the wrong side of one of the planes through the eye and the face's edges. `all`: all
/// rays do.
bool CanMeet(const FaceView& face, const RayGrid::Tile& tile, bool* all) {
  std::array<int, 5> inside = {};
  for (const float x : {tile.low.x(), tile.high.x()}) {
    for (const float y : {tile.low.y(), tile.high.y()}) {
      const float a = ValueAt(face.across, x, y);
      const float u = ValueAt(face.along_u, x, y);
      const float v = ValueAt(face.along_v, x, y);
      inside[0] += a > 0.0F ? 1 : 0;
      inside[1] += u >= 0.0F ? 1 : 0;
      inside[2] += v >= 0.0F ? 1 : 0;
      inside[3] += u <= face.width * a ? 1 : 0;
      inside[4] += v <= face.height * a ? 1 : 0;
    }
  }
  const auto [least, most] = std::minmax_element(inside.begin(), inside.end());
  *all = *least == 4;
  return *least > 0;
}

}  // namespace

std::vector<FaceView> FacesInView(const SimulatedWorld& world, const vo::Rigid3& world_from_cam) {
  std::vector<FaceView> faces;
  AddFaces(world.room, -1, world_from_cam, &faces);
  // Inside, all six are in front of one another.
  if (faces.size() != 6) return {};
  for (std::size_t i = 0; i < world.boxes.size(); ++i) {
    AddFaces(world.boxes[i], static_cast<int>(i), world_from_cam, &faces);
  }
  return faces;
}

RayGrid::RayGrid(const vo::Camera& camera, int samples_per_side, int threads)
    : width(camera.width), samples(samples_per_side * samples_per_side) {
  rays.resize(static_cast<std::size_t>(camera.width) * camera.height * samples);
  ParallelFor(camera.height, threads, [&](int y) {
    Eigen::Vector2f* ray = &rays[static_cast<std::size_t>(y) * width * samples];
    for (int x = 0; x < width; ++x) {
      for (int sample = 0; sample < samples; ++sample) {
        const Eigen::Vector2d place((sample % samples_per_side + 0.5) / samples_per_side - 0.5,
                                    (sample / samples_per_side + 0.5) / samples_per_side - 0.5);
        *ray++ = camera.Undistort(Eigen::Vector2d(x, y) + place).cast<float>();
      }
    }
  });
  for (int top = 0; top < camera.height; top += kTile) {
    for (int left = 0; left < width; left += kTile) {
      Tile tile;
      tile.left = left;
      tile.top = top;
      tile.right = std::min(left + kTile, width);
      tile.bottom = std::min(top + kTile, camera.height);
      tile.low.setConstant(std::numeric_limits<float>::infinity());
      tile.high = -tile.low;
      for (int y = tile.top; y < tile.bottom; ++y) {
        const Eigen::Vector2f* const ray = RaysOf(tile.left, y);
        for (int i = 0; i < (tile.right - tile.left) * samples; ++i) {
          if (!ray[i].allFinite()) {
            tile.whole = false;
            continue;
          }
          tile.low = tile.low.cwiseMin(ray[i]);
          tile.high = tile.high.cwiseMax(ray[i]);
          // The outer half of the outermost pixels has no samples.
          widest = std::max(widest, 1.02 * static_cast<double>(ray[i].norm()));
        }
      }
      const Eigen::Vector2d middle(0.5 * (tile.left + tile.right - 1),
                                   0.5 * (tile.top + tile.bottom - 1));
      const Eigen::Vector2d ray = camera.Undistort(middle);
      const double pixels =
          ray.allFinite() ? camera.DistortJacobian(ray).determinant() : camera.fx * camera.fy;
      tile.log2_sample = static_cast<float>(-0.5 * std::log2(pixels * samples));
      tiles.push_back(tile);
    }
  }
}

void TileFaces::Find(const std::vector<FaceView>& faces, const RayGrid::Tile& tile) {
  room.clear();
  boxes.clear();
  only = nullptr;
  bool all_meet_one = false;
  for (const FaceView& face : faces) {
    bool all = false;
    if (!CanMeet(face, tile, &all)) continue;
    if (face.box < 0) {
      if (all) only = &face;
      room.push_back(&face);
    } else {
      all_meet_one = all;
      boxes.push_back(&face);
    }
  }
  if (boxes.size() == 1 && all_meet_one) {
    only = boxes[0];
  } else if (!boxes.empty()) {
    only = nullptr;
  }
  if (!tile.whole) only = nullptr;
}

const FaceView* TileFaces::Meet(const Eigen::Vector2f& ray) const {
  const FaceView* nearest = nullptr;
  // Depth is distance / across: the room's nearest plane is the one that is met, since from inside
  // a convex room no other test is needed (and rounding leaves no cracks).
  float depth = std::numeric_limits<float>::infinity();
  for (const FaceView* face : room) {
    const float a = ValueAt(face->across, ray.x(), ray.y());
    if (a > 0.0F && face->distance < depth * a) {
      depth = face->distance / a;
      nearest = face;
    }
  }
  for (const FaceView* face : boxes) {
    const float a = ValueAt(face->across, ray.x(), ray.y());
    if (!(a > 0.0F && face->distance < depth * a)) continue;
    const float u = ValueAt(face->along_u, ray.x(), ray.y());
    const float v = ValueAt(face->along_v, ray.x(), ray.y());
    if (u >= 0.0F && v >= 0.0F && u <= face->width * a && v <= face->height * a) {
      depth = face->distance / a;
      nearest = face;
    }
  }
  return nearest;
}

}  // namespace gluevo::simulation
