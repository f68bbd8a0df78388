#include "renderer.h"

#include <limits>
#include <optional>

namespace gluevo::simulation {
namespace {

constexpr int kSamplesPerSide = 2;

/// `a`: of the ray, see FaceView.
Texture::Sampler SamplerOf(const FaceView& face, float a, const RayGrid::Tile& tile) {
  return face.texture->At(Log2Footprint(face, a, tile));
}

/// The face that all four rays of a pixel meet, if there is one.
const FaceView* OfAllRays(const TileFaces& seen, const Eigen::Vector2f* rays) {
  if (seen.only != nullptr) return seen.only;
  const FaceView* const face = seen.Meet(rays[0]);
  for (int i = 1; i < kSamplesPerSide * kSamplesPerSide; ++i) {
    if (seen.Meet(rays[i]) != face) return nullptr;
  }
  return face;
}

/// The sum over the four rays of a pixel that all meet one face, by vectors: the same as ray by
/// ray.
float SumOfPixel(const FaceView& face, const Eigen::Vector2f* rays, const RayGrid::Tile& tile) {
  static_assert(kSamplesPerSide * kSamplesPerSide == 4);
  const Eigen::Array4f x(rays[0].x(), rays[1].x(), rays[2].x(), rays[3].x());
  const Eigen::Array4f y(rays[0].y(), rays[1].y(), rays[2].y(), rays[3].y());
  const auto values = [&](const FaceView::Form& form) -> Eigen::Array4f {
    return form[0] * x + form[1] * y + form[2];
  };
  const Eigen::Array4f a = values(face.across);
  const Eigen::Array4f inverse = 1.0F / a;
  const Eigen::Array4f samples =
      SamplerOf(face, a[0], tile)
          .Sample(values(face.along_u) * inverse, values(face.along_v) * inverse);
  return samples[0] + samples[1] + samples[2] + samples[3];
}

}  // namespace

Renderer::Renderer(const vo::StereoRig& rig, int threads)
    : rig_(rig),
      grids_{RayGrid(rig.cameras[0], kSamplesPerSide, threads),
             RayGrid(rig.cameras[1], kSamplesPerSide, threads)},
      centers_{RayGrid(rig.cameras[0], 1, threads), RayGrid(rig.cameras[1], 1, threads)} {}

void Renderer::AddSeen(const SimulatedWorld& world, int camera, const vo::Rigid3& world_from_body,
                       SeenParts* parts) const {
  parts->Add(FacesInView(world, world_from_body * rig_.body_from_cam[camera]), grids_[camera]);
}

void Renderer::Accumulate(const SimulatedWorld& world, int camera,
                          const vo::Rigid3& world_from_body, int first, int step,
                          cv::Mat* sums) const {
  const RayGrid& grid = grids_[camera];
  const std::vector<FaceView> faces =
      FacesInView(world, world_from_body * rig_.body_from_cam[camera]);
  TileFaces seen;
  for (const RayGrid::Tile& tile : grid.tiles) {
    seen.Find(faces, tile);
    for (int y = tile.top; y < tile.bottom; ++y) {
      float* const line = sums->ptr<float>(y);
      for (int x = tile.left; x < tile.right; ++x) {
        const Eigen::Vector2f* const rays = grid.RaysOf(x, y);
        if (const FaceView* const face = step == 1 ? OfAllRays(seen, rays) : nullptr; face) {
          line[x] += SumOfPixel(*face, rays, tile);
          continue;
        }
        const FaceView* last = nullptr;
        std::optional<Texture::Sampler> sampler;
        float sum = 0.0F;
        for (int sample = first; sample < grid.samples; sample += step) {
          const Eigen::Vector2f& ray = rays[sample];
          const FaceView* const face = seen.only != nullptr ? seen.only : seen.Meet(ray);
          if (face == nullptr) continue;
          const float a = ValueAt(face->across, ray.x(), ray.y());
          if (face != last) {
            sampler = SamplerOf(*face, a, tile);
            last = face;
          }
          const float inverse = 1.0F / a;
          sum += sampler->Sample(ValueAt(face->along_u, ray.x(), ray.y()) * inverse,
                                 ValueAt(face->along_v, ray.x(), ray.y()) * inverse);
        }
        line[x] += sum;
      }
    }
  }
}

cv::Mat Renderer::Render(const SimulatedWorld& world, int camera,
                         const std::vector<vo::Rigid3>& world_from_body) const {
  const vo::Camera& model = rig_.cameras[camera];
  constexpr int kSamples = kSamplesPerSide * kSamplesPerSide;
  cv::Mat sums(model.height, model.width, CV_32FC1, cv::Scalar(0.0));
  const int poses = static_cast<int>(world_from_body.size());
  for (int i = 0; i < poses; ++i) {
    // Many poses share the samples of a pixel out among themselves.
    Accumulate(world, camera, world_from_body[i], poses >= kSamples ? i % kSamples : 0,
               poses >= kSamples ? kSamples : 1, &sums);
  }
  sums.convertTo(sums, CV_32FC1, 1.0 / (poses >= kSamples ? poses : poses * kSamples));
  return sums;
}

template <typename Visitor>
void Renderer::ForEachCenter(const SimulatedWorld& world, int camera,
                             const vo::Rigid3& world_from_body, Visitor visit) const {
  const std::vector<FaceView> faces =
      FacesInView(world, world_from_body * rig_.body_from_cam[camera]);
  TileFaces seen;
  for (const RayGrid::Tile& tile : centers_[camera].tiles) {
    seen.Find(faces, tile);
    for (int y = tile.top; y < tile.bottom; ++y) {
      for (int x = tile.left; x < tile.right; ++x) {
        const Eigen::Vector2f& ray = *centers_[camera].RaysOf(x, y);
        if (const FaceView* const face = seen.Meet(ray); face != nullptr) {
          visit(x, y, ray, *face);
        }
      }
    }
  }
}

cv::Mat Renderer::Depth(const SimulatedWorld& world, int camera,
                        const vo::Rigid3& world_from_body) const {
  const vo::Camera& model = rig_.cameras[camera];
  cv::Mat depth(model.height, model.width, CV_32FC1,
                cv::Scalar(std::numeric_limits<double>::quiet_NaN()));
  ForEachCenter(world, camera, world_from_body,
                [&](int x, int y, const Eigen::Vector2f& ray, const FaceView& face) {
                  depth.at<float>(y, x) = face.distance / ValueAt(face.across, ray.x(), ray.y());
                });
  return depth;
}

cv::Mat Renderer::MaskOfBoxes(const SimulatedWorld& world, int camera,
                              const vo::Rigid3& world_from_body, int first_box) const {
  const vo::Camera& model = rig_.cameras[camera];
  cv::Mat mask(model.height, model.width, CV_8UC1, cv::Scalar(0));
  ForEachCenter(world, camera, world_from_body,
                [&](int x, int y, const Eigen::Vector2f&, const FaceView& face) {
                  mask.at<unsigned char>(y, x) = face.box >= first_box ? 255 : 0;
                });
  return mask;
}

Eye Renderer::At(const SimulatedWorld& world, int camera, const vo::Rigid3& world_from_body) const {
  return {world, rig_.cameras[camera], grids_[camera].widest,
          world_from_body * rig_.body_from_cam[camera]};
}

}  // namespace gluevo::simulation
