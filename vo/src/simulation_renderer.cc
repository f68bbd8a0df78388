#include "simulation_renderer.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "parallel_for.h"

namespace gluevo::vo {

Renderer::Renderer(const StereoRig& rig, const SimulatedWorld& world, double noise, int threads)
    : rig_(rig),
      world_(world),
      noise_(static_cast<float>(noise)),
      views_{MakeView(rig.cameras[0], threads), MakeView(rig.cameras[1], threads)} {}

Renderer::View Renderer::MakeView(const Camera& camera, int threads) {
  View view;
  view.rays.resize(static_cast<std::size_t>(camera.width) * camera.height * kSamples);
  ParallelFor(camera.height, threads, [&](int y) {
    Eigen::Vector2f* ray = &view.rays[static_cast<std::size_t>(y) * camera.width * kSamples];
    for (int x = 0; x < camera.width; ++x) {
      for (int sample = 0; sample < kSamples; ++sample) {
        const Eigen::Vector2d offset(sample % 2 == 0 ? -0.25 : 0.25, sample < 2 ? -0.25 : 0.25);
        *ray++ = camera.Undistort(Eigen::Vector2d(x, y) + offset).cast<float>();
      }
    }
  });
  for (int top = 0; top < camera.height; top += kTile) {
    for (int left = 0; left < camera.width; left += kTile) {
      Tile tile;
      tile.left = left;
      tile.top = top;
      tile.right = std::min(left + kTile, camera.width);
      tile.bottom = std::min(top + kTile, camera.height);
      const auto ray_at = [&](int x, int y, int sample) -> const Eigen::Vector2f& {
        return view.rays[(static_cast<std::size_t>(y) * camera.width + x) * kSamples + sample];
      };
      tile.axis_in_cam = ray_at((tile.left + tile.right) / 2, (tile.top + tile.bottom) / 2, 0)
                             .cast<double>()
                             .homogeneous()
                             .normalized();
      double least_cosine = 1.0;
      for (int y = tile.top; y < tile.bottom; ++y) {
        for (int x = tile.left; x < tile.right; ++x) {
          for (int sample = 0; sample < kSamples; ++sample) {
            const Eigen::Vector3d ray = ray_at(x, y, sample).cast<double>().homogeneous();
            least_cosine = std::min(least_cosine, tile.axis_in_cam.dot(ray) / ray.norm());
          }
        }
      }
      // Wider by 1e-6 rad than the arc cosine's rounding near 1 can cost.
      tile.half_angle = std::acos(std::clamp(least_cosine, -1.0, 1.0)) + 1e-6;
      view.tiles.push_back(tile);
    }
  }
  return view;
}

float Renderer::Shade(const WorldView& world, const Eigen::Vector3d& direction_in_world,
                      const std::vector<int>& boxes, double sample_angle) const {
  const std::optional<SurfaceHit> hit = world.Cast(direction_in_world, boxes);
  if (!hit) return 0.0F;
  // A ray's footprint is an ellipse, longer by 1 / cosine along the slope: the geometric mean is
  // where blur and aliasing balance.
  const double footprint = hit->distance * sample_angle / std::sqrt(std::max(hit->cosine, 0.02));
  return world.TextureOf(*hit).Sample(hit->u, hit->v, footprint);
}

cv::Mat Renderer::Render(int camera, const Rigid3& world_from_body, uint64_t noise_seed) const {
  const Camera& model = rig_.cameras[camera];
  const View& view = views_[camera];
  const Rigid3 world_from_cam = world_from_body * rig_.body_from_cam[camera];
  const Eigen::Matrix3d rotation = world_from_cam.rotation.toRotationMatrix();
  const WorldView world(world_, world_from_cam.translation);
  const double sample_angle = 0.5 / model.fx;
  cv::Mat image(model.height, model.width, CV_8UC1);
  std::vector<int> boxes;
  for (const Tile& tile : view.tiles) {
    world.BoxesInCone(rotation * tile.axis_in_cam, tile.half_angle, &boxes);
    for (int y = tile.top; y < tile.bottom; ++y) {
      for (int x = tile.left; x < tile.right; ++x) {
        const std::size_t pixel = static_cast<std::size_t>(y) * model.width + x;
        float sum = 0.0F;
        for (int sample = 0; sample < kSamples; ++sample) {
          const Eigen::Vector2f& ray = view.rays[pixel * kSamples + sample];
          const Eigen::Vector3d direction = rotation * Eigen::Vector3d(ray.x(), ray.y(), 1.0);
          sum += Shade(world, direction, boxes, sample_angle);
        }
        float value = sum / kSamples;
        if (noise_ > 0.0F) {
          constexpr float kDarkVariance = 1.0F / 9.0F;
          value += noise_ * std::sqrt(std::max(value / 255.0F, kDarkVariance)) *
                   normal_(Hash(noise_seed, pixel));
        }
        image.at<uint8_t>(y, x) = static_cast<uint8_t>(std::clamp(value + 0.5F, 0.0F, 255.0F));
      }
    }
  }
  return image;
}

std::optional<Eigen::Vector3d> Renderer::PointAt(int camera, const Rigid3& world_from_body,
                                                 const Eigen::Vector2d& pixel) const {
  const Rigid3 world_from_cam = world_from_body * rig_.body_from_cam[camera];
  const Eigen::Vector3d direction =
      world_from_cam.rotation * rig_.cameras[camera].Undistort(pixel).homogeneous();
  std::vector<int> boxes(world_.boxes.size());
  std::iota(boxes.begin(), boxes.end(), 0);
  const std::optional<SurfaceHit> hit =
      WorldView(world_, world_from_cam.translation).Cast(direction, boxes);
  if (!hit) return std::nullopt;
  return world_from_cam.translation + hit->distance * direction;
}

}  // namespace gluevo::vo
