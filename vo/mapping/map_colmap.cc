// A map as COLMAP's text model (colmap.github.io/format.html).

#include <algorithm>
#include <iomanip>
#include <limits>
#include <optional>
#include <ostream>
#include <string>
#include <system_error>
#include <utility>

#include "gluevo/nn/output_file.h"
#include "gluevo/vo/io/output_directory.h"
#include "gluevo/vo/mapping/map.h"

namespace gluevo::vo {
namespace {

// COLMAP's pixels begin at the corner of the top-left one, ours at its centre.
constexpr double kColmapPixelOffset = 0.5;

struct Track {
  std::vector<std::pair<std::size_t, std::size_t>> views;  // image id, index of the view in it
};

std::size_t ImageId(std::size_t keyframe, std::size_t side) { return 2 * keyframe + side + 1; }

/// What COLMAP calls a camera of ours; its parameters are fx, fy, cx, cy and the coefficients.
struct ColmapModel {
  const char* name;
  std::size_t coefficients;  // the first so many
};

/// Nothing for the models that COLMAP does not have.
std::optional<ColmapModel> ModelOf(const Camera& camera) {
  switch (camera.distortion) {
    case Distortion::kNone:
      return ColmapModel{"PINHOLE", 0};
    case Distortion::kRadialTangential:
      // Its further three coefficients are zero here.
      return camera.coefficients[4] != 0.0 ? ColmapModel{"FULL_OPENCV", 8}
                                           : ColmapModel{"OPENCV", 4};
    case Distortion::kRational:
      return ColmapModel{"FULL_OPENCV", 8};
    case Distortion::kEquidistant:
      return ColmapModel{"OPENCV_FISHEYE", 4};
    case Distortion::kFieldOfView:
      return ColmapModel{"FOV", 1};
    default:
      return std::nullopt;
  }
}

/// The camera of the views that are written: without distortion where COLMAP lacks the model.
Camera ExportedCamera(const Camera& camera) {
  if (ModelOf(camera)) {
    return camera;
  }
  const Eigen::Vector2d focal = camera.CentralFocal();
  return {camera.width, camera.height, focal.x(), focal.y(), camera.cx, camera.cy};
}

void WriteCameras(std::ostream& out, const Map& map) {
  out << "# CAMERA_ID, MODEL, WIDTH, HEIGHT, PARAMS[]\n";
  for (std::size_t side = 0; side < 2; ++side) {
    if (!ModelOf(map.cameras[side])) {
      out << "# " << NameOf(map.cameras[side].distortion) << " is no model of COLMAP's: camera "
          << side + 1 << " and its views are without distortion, the images are not\n";
    }
    const Camera camera = ExportedCamera(map.cameras[side]);
    const ColmapModel model = *ModelOf(camera);
    out << side + 1 << ' ' << model.name << ' ' << camera.width << ' ' << camera.height << ' '
        << camera.fx << ' ' << camera.fy << ' ' << camera.cx + kColmapPixelOffset << ' '
        << camera.cy + kColmapPixelOffset;
    for (std::size_t i = 0; i < model.coefficients; ++i) {
      out << ' ' << camera.coefficients[i];
    }
    out << '\n';
  }
}

void WriteImages(std::ostream& out, const Map& map, int segment) {
  out << "# IMAGE_ID, QW, QX, QY, QZ, TX, TY, TZ, CAMERA_ID, NAME\n"
         "# POINTS2D[] as (X, Y, POINT3D_ID)\n";
  for (std::size_t i = 0; i < map.keyframes.size(); ++i) {
    const Map::Keyframe& keyframe = map.keyframes[i];
    for (std::size_t side = 0; side < 2 && keyframe.segment == segment; ++side) {
      const Rigid3 cam_from_world = keyframe.world_from_cam[side].Inverse();
      const Eigen::Quaterniond& q = cam_from_world.rotation;
      const Eigen::Vector3d& t = cam_from_world.translation;
      out << ImageId(i, side) << ' ' << q.w() << ' ' << q.x() << ' ' << q.y() << ' ' << q.z() << ' '
          << t.x() << ' ' << t.y() << ' ' << t.z() << ' ' << side + 1 << ' '
          << keyframe.images[side] << '\n';
      const char* separator = "";
      const Camera& camera = map.cameras[side];
      const bool is_exported = ModelOf(camera).has_value();
      for (const Map::View& view : keyframe.views[side]) {
        const Eigen::Vector2d pixel =
            is_exported ? view.pixel : ExportedCamera(camera).Distort(camera.Undistort(view.pixel));
        out << separator << pixel.x() + kColmapPixelOffset << ' ' << pixel.y() + kColmapPixelOffset
            << ' ' << view.point + 1;
        separator = " ";
      }
      out << '\n';
    }
  }
}

void WritePoints(std::ostream& out, const Map& map, const std::vector<Track>& tracks, int segment) {
  out << "# POINT3D_ID, X, Y, Z, R, G, B, ERROR, TRACK[] as (IMAGE_ID, POINT2D_IDX)\n";
  for (std::size_t i = 0; i < map.points.size(); ++i) {
    const Map::Point& point = map.points[i];
    if (point.segment != segment) {
      continue;
    }
    const Eigen::Vector3d& p = point.point_in_world;
    const int gray = point.gray;
    out << i + 1 << ' ' << p.x() << ' ' << p.y() << ' ' << p.z() << ' ' << gray << ' ' << gray
        << ' ' << gray << ' ' << point.mean_error_px;
    for (const auto& [image_id, index] : tracks[i].views) {
      out << ' ' << image_id << ' ' << index;
    }
    out << '\n';
  }
}

// A model that an earlier run left would pass for a segment of this one.
void RemoveModel(const std::filesystem::path& model) {
  std::error_code ignored;
  for (const char* const name : {"cameras.txt", "images.txt", "points3D.txt"}) {
    std::filesystem::remove(model / name, ignored);
  }
  std::filesystem::remove(model, ignored);  // where nothing else is in it
}

}  // namespace

void WriteColmap(const std::filesystem::path& directory, const Map& map) {
  std::vector<Track> tracks(map.points.size());
  std::vector<bool> has_points;  // by segment
  for (std::size_t i = 0; i < map.keyframes.size(); ++i) {
    for (std::size_t side = 0; side < 2; ++side) {
      const auto& views = map.keyframes[i].views[side];
      for (std::size_t index = 0; index < views.size(); ++index) {
        tracks[views[index].point].views.emplace_back(ImageId(i, side), index);
      }
    }
  }
  for (const Map::Point& point : map.points) {
    const auto segment = static_cast<std::size_t>(point.segment);
    has_points.resize(std::max(has_points.size(), segment + 1));
    has_points[segment] = true;
  }
  for (std::size_t i = 0; i < has_points.size(); ++i) {
    const auto segment = static_cast<int>(i);
    const std::filesystem::path model = directory / std::to_string(segment);
    if (!has_points[i]) {
      RemoveModel(model);
      continue;
    }
    MakeOutputDirectory(model);
    const auto write = [&](const char* name, const auto& content) {
      nn::WriteWholeFile(model / name, [&](std::ostream& out) {
        out << std::setprecision(std::numeric_limits<double>::max_digits10);
        content(out);
      });
    };
    write("cameras.txt", [&](std::ostream& out) { WriteCameras(out, map); });
    write("images.txt", [&](std::ostream& out) { WriteImages(out, map, segment); });
    write("points3D.txt", [&](std::ostream& out) { WritePoints(out, map, tracks, segment); });
  }
  for (std::size_t i = has_points.size(); std::filesystem::exists(directory / std::to_string(i));
       ++i) {
    RemoveModel(directory / std::to_string(i));
  }
}

}  // namespace gluevo::vo
