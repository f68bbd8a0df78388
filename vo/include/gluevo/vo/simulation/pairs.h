#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>

namespace gluevo::simulation {

struct PairOptions {
  int rooms = 1000;
  /// Makes everything.
  uint64_t seed = 1;
  /// Of the images, pixels.
  int width = 376;
  int height = 240;
  /// Adds depth maps.
  bool depth = false;
  /// 0: as many as the machine has. The files are the same bytes for any number.
  int threads = 0;
  /// Called often, from several threads at once, also before the first progress is made: what it
  /// throws ends the work and is thrown by it. Empty: nothing is called.
  std::function<void()> checkpoint;

  /// Throws Error naming the option.
  void Validate() const;
};

/// Renders training data for matchers: many small rooms, of which each is seen in 8 views. Every
/// second view is the right image of the stereo pair that the one before begins; the pairs take
/// small steps and jumps of up to 45 degrees and 1.5 m. Focal length, distortion and baseline
/// change from file to file, exposure, contrast, blur, vignetting and noise from view to view.
///
/// The folder is filled with rooms_00000.h5, rooms_00001.h5, ... of 64 rooms each (HDF5), a group
/// room_000000, ... a room:
///  - `images`: views x height x width, 8-bit.
///  - `world_from_cam`: views x 7, double: x y z in metres, quaternion qx qy qz qw.
///  - `camera`: views x 8, double: fx fy cx cy in pixels (pixel centres are whole numbers), k1 k2
///    p1 p2 of the radial-tangential distortion.
///  - `boxes`: N x 7, double: center x y z, half size x y z, metres, turn about the vertical,
///    radians. The first is the room, seen from inside. With these a ray from any keypoint finds
///    its exact point, and whether another view sees it.
///  - `pairs`: P x 2, int32: two views (first, second) of which each sees at least a tenth of the
///    other; both orders are listed.
///  - `overlap`: P: the share of the first view's grid points that the second sees.
///  - `grid`: G x 2: the pixels (x y) of a grid, every 8th in x and y.
///  - `correspondences`: P x G x 2: where the second view sees the surface that the first view has
///    at each grid pixel; -1 -1 where it is outside the image or hidden.
///  - with `depth`, `depth`: views x height x width, float: metres along the optical axis.
///
/// The folder is made under the name "DIRECTORY.part" and renamed when whole. `progress` is called
/// with the rooms done and all rooms, from one thread at a time. Throws Error as Simulate does.
void SimulatePairs(const PairOptions& options, const std::filesystem::path& directory,
                   const std::function<void(int, int)>& progress = {});

}  // namespace gluevo::simulation
