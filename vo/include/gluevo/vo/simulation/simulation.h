#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "gluevo/vo/geometry/stereo_rig.h"

namespace gluevo::simulation {

/// What a camera makes of the light that falls on it.
struct ImageOptions {
  /// Standard deviation of the sensor noise at full white, gray levels; it falls with the square
  /// root of the brightness (shot noise) to a third in the dark. 0 for none.
  double noise = 2.0;
  /// Exposures wander smoothly over seconds by up to this many stops (factors of two) either way,
  /// in both cameras alike.
  double exposure_change = 0.0;
  /// Share of the light that is lost in the corners, growing with the square of the distance from
  /// the centre.
  double vignetting = 0.0;
  /// Exposure time, milliseconds, centred on the image's time stamp: what moves meanwhile is
  /// blurred. 0 for sharp images.
  double motion_blur_ms = 0.0;
  /// The room's light: 1 is bright, 0.1 dusk. The camera makes up the square root of what is
  /// missing by its gain, which amplifies the noise by as much.
  double light = 1.0;

  /// Throws Error naming the option.
  void Validate() const;
};

struct SimulationOptions {
  /// Name of the path that the body flies, one of SimulationPaths().
  std::string path = "hall_loop";
  /// In place of a named path: a TUM or EuRoC file of world_from_body, which a spline follows (see
  /// below); the data set then has the file's times.
  std::filesystem::path trajectory;
  /// Begins this many seconds after the first pose, or after the take-off, or into the named path.
  double start_s = 0.0;
  /// Begins the trajectory where the body, after 2 s or more at rest, leaves for a place more than
  /// 1 m away, so that waiting and being shaken by hand before the flight are left out.
  bool from_takeoff = false;
  /// Makes the room, its textures and all noise.
  uint64_t seed = 1;
  /// Nothing: to the end of the trajectory, 20 s of a named path.
  std::optional<double> duration_s;
  /// In place of a duration: so many laps of a named path that has laps, from its start; 0: none.
  int laps = 0;
  /// Stereo pairs a second.
  double rate_hz = 10.0;
  /// Size of the images in pixels; the cameras' focal lengths follow the width.
  int width = 752;
  int height = 480;
  ImageOptions image;
  /// Writes cam0/depth and cam1/depth: TIMESTAMP.tiff, 32-bit float, metres along the optical axis
  /// at each pixel's centre.
  bool depth = false;
  /// Writes correspondences.h5 beside cam0: a group for each left image, named by its time stamp,
  /// with rows for the pixels of a grid (every 8th in x and y): `pixel` (N x 2, x y), `point` (N x
  /// 3, in the world, metres), `right` (N x 2, where the right image shows the point) and `next`
  /// (N x 2, where the next left image does), in pixels, -1 -1 where it is outside the image or
  /// hidden.
  bool correspondences = false;
  /// The data set's calibration has the right camera turned by so many milliradians about its own y
  /// axis against what is rendered: what wears off a calibration.
  double calibration_error_mrad = 0.0;
  /// Every six metres along x the room looks the same, but for its two end walls: places that look
  /// alike and are others.
  bool twins = false;
  /// Boxes that drive or fly through the scene. Writes cam0/movers: TIMESTAMP.png, a mask of each
  /// left image, 255 where the centre of a pixel shows one of them, else 0.
  int movers = 0;
  /// Share of the left image that each of them fills when it is nearest, above 0 and at most 0.5.
  double movers_cover = 0.25;
  /// 0: as many as the machine has. The files are the same bytes for any number.
  int threads = 0;
  /// Called often, from several threads at once, also before the first progress is made: what it
  /// throws ends the work and is thrown by it. Empty: nothing is called.
  std::function<void()> checkpoint;

  /// Throws Error naming the option.
  void Validate() const;
};

/// The names of the paths that can be flown.
std::vector<std::string> SimulationPaths();

/// The rig with its right camera turned about its own y axis, radians.
vo::StereoRig WithRightTurned(const vo::StereoRig& rig, double angle);

/// The stereo rig of EuRoC's recordings (Burri et al. 2016: intrinsics, radial-tangential
/// distortion and extrinsics of the Vicon rooms), scaled to images of width x height pixels: focal
/// lengths by width / 752, principal points keeping their offset from the centre. Throws Error
/// where the distortion cannot be undone over such an image.
vo::StereoRig SimulationRig(int width, int height);

/// Renders a stereo sequence through a textured room as an EuRoC ASL folder: directory/mav0 with
/// cam0, cam1 (png), imu0 (200 Hz, with EuRoC's noise and biases) and the ground truth of the body
/// at every image's and every IMU sample's time. The room is fitted around the path, whose world's
/// z points up.
///
/// A trajectory's poses are taken as EuRoC's ground truth gives them: world from the IMU (x up, y
/// right, z forward in the flights with the rig of SimulationRig). It is flown by a spline with
/// four continuous derivatives, fitted with a bandwidth of about 4 Hz: it stays within millimetres
/// of smooth recordings and turns their jumps into fast motions. Ground truth and inertial samples
/// are the spline's.
///
/// The folder is made under the name "DIRECTORY.part" and renamed when whole; what a killed run
/// left under that name is replaced. `progress` is called with the images done and all images, from
/// one thread at a time; what it throws ends the work and is thrown here. Throws Error where the
/// directory exists or cannot be written, and where the trajectory cannot be read or flown.
void Simulate(const SimulationOptions& options, const std::filesystem::path& directory,
              const std::function<void(int, int)>& progress = {});

}  // namespace gluevo::simulation
