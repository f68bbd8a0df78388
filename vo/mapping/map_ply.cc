// A map as PLY files (Turk, "The PLY polygon file format", 1994).

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <cstring>
#include <ostream>

#include "gluevo/nn/output_file.h"
#include "gluevo/vo/io/output_directory.h"
#include "gluevo/vo/mapping/map.h"

namespace gluevo::vo {
namespace {

// The files are little endian whatever the machine is.
template <typename T>
void Put(std::ostream& out, T value) {
  std::array<char, sizeof(T)> bytes;
  std::memcpy(bytes.data(), &value, sizeof(T));
  if constexpr (std::endian::native == std::endian::big) {
    std::reverse(bytes.begin(), bytes.end());
  }
  out.write(bytes.data(), bytes.size());
}

void PutFloats(std::ostream& out, const Eigen::Vector3d& vector) {
  for (int i = 0; i < 3; ++i) {
    Put(out, static_cast<float>(vector[i]));
  }
}

void WritePoints(std::ostream& out, const Map& map) {
  out << "ply\nformat binary_little_endian 1.0\n"
         "comment sparse points, world frame, metres\n"
      << "element vertex " << map.points.size() << '\n'
      << "property float x\nproperty float y\nproperty float z\n"
         "property uchar red\nproperty uchar green\nproperty uchar blue\n"
         "property int segment\nend_header\n";
  for (const Map::Point& point : map.points) {
    PutFloats(out, point.point_in_world);
    for (int channel = 0; channel < 3; ++channel) {
      Put(out, point.gray);
    }
    Put(out, static_cast<int32_t>(point.segment));
  }
}

void WriteKeyframes(std::ostream& out, const Map& map) {
  std::vector<int32_t> starts;  // of the edges: each goes to the next key frame
  for (std::size_t i = 1; i < map.keyframes.size(); ++i) {
    if (map.keyframes[i].segment == map.keyframes[i - 1].segment) {
      starts.push_back(static_cast<int32_t>(i - 1));
    }
  }
  out << "ply\nformat binary_little_endian 1.0\n"
         "comment key frames: left camera's centre and viewing direction, world frame, metres\n"
      << "element vertex " << map.keyframes.size() << '\n'
      << "property float x\nproperty float y\nproperty float z\n"
         "property float nx\nproperty float ny\nproperty float nz\n"
         "property double time\nproperty int segment\n"
      << "element edge " << starts.size() << '\n'
      << "property int vertex1\nproperty int vertex2\nend_header\n";
  for (const Map::Keyframe& keyframe : map.keyframes) {
    const Rigid3& world_from_left = keyframe.world_from_cam[0];
    PutFloats(out, world_from_left.translation);
    PutFloats(out, world_from_left.rotation * Eigen::Vector3d::UnitZ());
    Put(out, static_cast<double>(keyframe.timestamp_ns) * 1e-9);
    Put(out, static_cast<int32_t>(keyframe.segment));
  }
  for (const int32_t start : starts) {
    Put(out, start);
    Put(out, start + 1);
  }
}

}  // namespace

void WritePly(const std::filesystem::path& directory, const Map& map) {
  MakeOutputDirectory(directory);
  nn::WriteWholeFile(directory / "points.ply", [&](std::ostream& out) { WritePoints(out, map); });
  nn::WriteWholeFile(directory / "keyframes.ply",
                     [&](std::ostream& out) { WriteKeyframes(out, map); });
}

}  // namespace gluevo::vo
