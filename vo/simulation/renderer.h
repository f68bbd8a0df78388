#pragma once

#include <array>
#include <opencv2/core/mat.hpp>
#include <vector>

#include "eye.h"
#include "gluevo/vo/geometry/stereo_rig.h"
#include "seen.h"
#include "view.h"
#include "world.h"

namespace gluevo::simulation {

/// Ray casts what the cameras of a rig see, with four rays a pixel through the exact inverse of
/// the cameras' distortion (kept as a table) and trilinear textures.
class Renderer {
 public:
  /// `threads` are used here only; rendering is for one thread an image.
  Renderer(const vo::StereoRig& rig, int threads);

  /// CV_32FC1: brightness, 0 to 255, of what a camera sees while the body takes all the given
  /// poses for equal times (one pose: a sharp image). Black where the camera has no ray.
  cv::Mat Render(const SimulatedWorld& world, int camera,
                 const std::vector<vo::Rigid3>& world_from_body) const;

  /// Adds the parts of the world that a sharp image reads.
  void AddSeen(const SimulatedWorld& world, int camera, const vo::Rigid3& world_from_body,
               SeenParts* parts) const;

  /// CV_32FC1: depth along the optical axis, metres, of what is seen at the centre of each pixel;
  /// NaN where the camera has no ray.
  cv::Mat Depth(const SimulatedWorld& world, int camera, const vo::Rigid3& world_from_body) const;

  /// CV_8UC1: 255 where the centre of a pixel shows a box of the world from `first_box` on, else 0.
  cv::Mat MaskOfBoxes(const SimulatedWorld& world, int camera, const vo::Rigid3& world_from_body,
                      int first_box) const;

  /// Exact correspondences of a camera of the body at a pose. The world must outlive it.
  Eye At(const SimulatedWorld& world, int camera, const vo::Rigid3& world_from_body) const;

  const vo::StereoRig& rig() const { return rig_; }

 private:
  /// Calls visit(x, y, ray, face) for each pixel whose centre has a ray that meets a face.
  template <typename Visitor>
  void ForEachCenter(const SimulatedWorld& world, int camera, const vo::Rigid3& world_from_body,
                     Visitor visit) const;
  /// Adds what the samples `first`, `first` + `step`, ... of each pixel see to the sums.
  void Accumulate(const SimulatedWorld& world, int camera, const vo::Rigid3& world_from_body,
                  int first, int step, cv::Mat* sums) const;

  vo::StereoRig rig_;
  std::array<RayGrid, 2> grids_;
  std::array<RayGrid, 2> centers_;
};

}  // namespace gluevo::simulation
