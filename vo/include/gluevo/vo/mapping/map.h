#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <string>
#include <unordered_map>
#include <vector>

#include "gluevo/vo/core/frame_result.h"
#include "gluevo/vo/core/map_point.h"
#include "gluevo/vo/core/stereo_frame.h"
#include "gluevo/vo/geometry/stereo_rig.h"

namespace gluevo::vo {

struct MapOptions {
  /// A view of a point that is farther than this from where the point projects is left out, pixels:
  /// a wrong match, or a track that jumped to another point.
  double max_reprojection_error_px = 4.0;
  /// Points with fewer views left (of both cameras in all key frames) are left out; at least 2.
  int min_views = 3;

  /// Throws Error naming the option.
  void Validate() const;
};

/// Key frames and the points that they see.
struct Map {
  /// Where a camera of a key frame sees a point.
  struct View {
    std::size_t point = 0;  ///< Index into points.
    Eigen::Vector2d pixel = Eigen::Vector2d::Zero();
  };
  struct Keyframe {
    int64_t timestamp_ns = 0;
    int segment = 0;  ///< As FrameResult::segment: key frames of different ones are not linked.
    std::array<Rigid3, 2> world_from_cam;  ///< Left and right.
    std::array<std::string, 2> images;     ///< Their names.
    std::array<std::vector<View>, 2> views;
  };
  struct Point {
    Eigen::Vector3d point_in_world = Eigen::Vector3d::Zero();  ///< Metres.
    int segment = 0;
    uint8_t gray = 0;            ///< Intensity in the left image that saw it first.
    double mean_error_px = 0.0;  ///< Mean reprojection error of its views.
  };

  std::array<Camera, 2> cameras;
  std::vector<Keyframe> keyframes;  ///< In order of time.
  std::vector<Point> points;
};

/// Gives key frames and points another world that is turned against theirs.
void TurnWorld(const Eigen::Quaterniond& new_from_old_world, Map& map);

/// Throws Error where a name has blanks, which COLMAP's text files cannot hold: MapRecorder would.
void CheckImageNames(const std::array<std::string, 2>& names);

/// Gathers the map over a run: poses as they were estimated when the frame came (never revised),
/// each point as the window knew it last. Grows with the number of key frames, by some 30 bytes an
/// observation.
class MapRecorder {
 public:
  /// Throws Error for options out of their range.
  MapRecorder(const std::array<Camera, 2>& cameras, const MapOptions& options);

  /// To be called after every frame. `image_names` are what the files shall call the images;
  /// `rig` and `window_points` are Odometry's. Throws Error where a name has blanks, which COLMAP's
  /// text files cannot hold.
  void Add(const StereoFrame& frame, const std::array<std::string, 2>& image_names,
           const FrameResult& result, const StereoRig& rig,
           const std::vector<MapPoint>& window_points);

  Map Build() const;

 private:
  struct Sighting {
    int64_t track_id = 0;
    Eigen::Vector2f left_pixel, right_pixel;
    bool has_right = false;
  };
  struct Keyframe {
    Map::Keyframe frame;
    std::vector<Sighting> sightings;
  };
  struct Track {
    Eigen::Vector3d point_in_world = Eigen::Vector3d::Zero();
    bool has_point = false;
    uint8_t gray = 0;
  };

  void AddKeyframe(const StereoFrame& frame, const std::array<std::string, 2>& image_names,
                   const FrameResult& result, const StereoRig& rig);

  std::array<Camera, 2> cameras_;
  MapOptions options_;
  std::vector<Keyframe> keyframes_;
  /// By segment: a track that goes on past a break has a point in each.
  std::vector<std::unordered_map<int64_t, Track>> tracks_;
};

/// Writes directory/points.ply and directory/keyframes.ply (binary, little endian), in the world
/// frame, metres:
/// - points: x y z (float), red green blue (uchar; the gray value thrice), segment (int);
/// - key frames: vertices x y z (float; the left camera's centre), nx ny nz (float; its viewing
///   direction), time (double, seconds), segment (int); edges vertex1 vertex2 (int) from each to
///   the next of its segment.
/// Makes the directory. Throws Error where a file cannot be written.
void WritePly(const std::filesystem::path& directory, const Map& map);

/// Writes each segment that has points as a text model of COLMAP's: directory/SEGMENT/cameras.txt,
/// images.txt and points3D.txt. Segments are models of their own because nothing links them.
/// Cameras 1 and 2 are left and right; images hold the views of both, in COLMAP's pixels (the
/// centre of the top-left one is at (0.5, 0.5)), and poses cam_from_world. Makes the directories.
/// Throws Error where a file cannot be written.
void WriteColmap(const std::filesystem::path& directory, const Map& map);

}  // namespace gluevo::vo
