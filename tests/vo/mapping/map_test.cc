// The map of a simulated run, read back by the documented rules of PLY and of COLMAP's text format
// (colmap.github.io/format.html, cameras.html), and by COLMAP itself where it is installed.

#include "gluevo/vo/mapping/map.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <iterator>
#include <map>
#include <set>
#include <sstream>

#include "gluevo/nn/error.h"
#include "temporary_folder.h"
#include "vo/scene.h"

namespace gluevo::vo {
namespace {

namespace fs = std::filesystem;

constexpr int kFrames = 6;
constexpr int kPoints = 1200;

Camera DistortedCamera(Distortion distortion, bool with_k3) {
  Camera camera{752, 480, 458.5, 457.25, 367.2, 248.4, distortion, {}};
  if (distortion == Distortion::kRadialTangential) {
    camera.coefficients = {-0.28, 0.074, 2e-4, 1.8e-5, with_k3 ? -0.01 : 0.0};
  } else if (distortion == Distortion::kEquidistant) {
    camera.coefficients = {-0.002, 0.001, -0.003, 0.0005, 0.0};
  }
  return camera;
}

struct Scene {
  StereoRig rig;
  std::vector<Eigen::Vector3d> points;
  std::vector<Rigid3> world_from_body;
};

Scene MakeScene(Distortion distortion, bool with_k3) {
  Scene scene{testing::SimulatedRig(), testing::RoomPoints(kPoints, 4.0, 7), {}};
  scene.rig.cameras.fill(DistortedCamera(distortion, with_k3));
  for (int i = 0; i < kFrames; ++i) {
    scene.world_from_body.push_back(
        {Eigen::Quaterniond(Eigen::AngleAxisd(0.05 * i, Eigen::Vector3d::UnitZ())),
         {0.2 * i, 0.1 * i, 0.05 * i}});
  }
  return scene;
}

// What the odometry gives for a frame that sees the scene without noise; track ids are 1000 plus
// the point's index.
FrameResult SeeScene(const Scene& scene, int frame, int segment) {
  FrameResult result;
  result.timestamp_ns = frame * 100'000'000LL;
  result.world_from_body = scene.world_from_body[static_cast<std::size_t>(frame)];
  result.is_keyframe = frame != 2;
  result.segment = segment;
  for (std::size_t i = 0; i < scene.points.size(); ++i) {
    Observation observation;
    observation.track_id = 1000 + static_cast<int64_t>(i);
    bool seen[2] = {};
    for (std::size_t side = 0; side < 2; ++side) {
      const Eigen::Vector3d in_cam =
          (result.world_from_body * scene.rig.body_from_cam[side]).Inverse() * scene.points[i];
      if (in_cam.z() > 0.5 && in_cam.head<2>().norm() < in_cam.z()) {
        const Eigen::Vector2d pixel = scene.rig.cameras[side].Project(in_cam);
        seen[side] = pixel.x() > 0.0 && pixel.y() > 0.0 && pixel.x() < 751.0 && pixel.y() < 479.0;
        (side == 0 ? observation.left_pixel : observation.right_pixel) = pixel;
      }
    }
    observation.has_right = seen[1];
    if (seen[0]) {
      result.tracked_frame.observations.push_back(observation);
    }
  }
  return result;
}

std::vector<MapPoint> WindowPoints(const Scene& scene) {
  std::vector<MapPoint> points;
  for (std::size_t i = 0; i < scene.points.size(); ++i) {
    points.push_back({1000 + static_cast<int64_t>(i), scene.points[i]});
  }
  return points;
}

StereoFrame GrayFrame() {
  StereoFrame frame;
  frame.images.fill(cv::Mat(480, 752, CV_8UC1, cv::Scalar(77)));
  return frame;
}

std::array<std::string, 2> Names(int frame) {
  return {"cam0/" + std::to_string(frame) + ".png", "cam1/" + std::to_string(frame) + ".png"};
}

Map MakeMap(const Scene& scene, int frames_of_first_segment = kFrames) {
  MapRecorder recorder(scene.rig.cameras, {});
  for (int i = 0; i < kFrames; ++i) {
    recorder.Add(GrayFrame(), Names(i), SeeScene(scene, i, i < frames_of_first_segment ? 0 : 1),
                 scene.rig, WindowPoints(scene));
  }
  return recorder.Build();
}

std::string Contents(const fs::path& path) {
  std::ifstream stream(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(stream), {}};
}

// COLMAP's text format, by its documentation.
struct ColmapImage {
  Rigid3 cam_from_world;
  int camera_id = 0;
  std::string name;
  std::vector<std::pair<Eigen::Vector2d, int64_t>> points2d;
};
struct ColmapPoint {
  Eigen::Vector3d point;
  int rgb[3] = {};
  double error = 0.0;
  std::vector<std::pair<int, std::size_t>> track;
};
struct ColmapCamera {
  std::string model;
  int width = 0, height = 0;
  std::vector<double> parameters;
};
struct ColmapModel {
  std::map<int, ColmapCamera> cameras;
  std::map<int, ColmapImage> images;
  std::map<int64_t, ColmapPoint> points;
};

ColmapModel ReadColmap(const fs::path& folder) {
  ColmapModel model;
  std::string line;
  std::ifstream cameras(folder / "cameras.txt");
  while (std::getline(cameras, line)) {
    if (line.empty() || line[0] == '#') {
      continue;
    }
    std::istringstream fields(line);
    int id = 0;
    fields >> id;
    ColmapCamera& camera = model.cameras[id];
    fields >> camera.model >> camera.width >> camera.height;
    camera.parameters.assign(std::istream_iterator<double>(fields), {});
  }
  std::ifstream images(folder / "images.txt");
  while (std::getline(images, line)) {
    if (line.empty() || line[0] == '#') {
      continue;
    }
    std::istringstream fields(line);
    int id = 0;
    fields >> id;
    ColmapImage& image = model.images[id];
    Eigen::Quaterniond& q = image.cam_from_world.rotation;
    Eigen::Vector3d& t = image.cam_from_world.translation;
    fields >> q.w() >> q.x() >> q.y() >> q.z() >> t.x() >> t.y() >> t.z() >> image.camera_id;
    fields >> image.name;
    EXPECT_TRUE(fields) << line;
    EXPECT_TRUE(std::getline(images, line));
    std::istringstream points(line);
    Eigen::Vector2d pixel;
    int64_t point_id = 0;
    while (points >> pixel.x() >> pixel.y() >> point_id) {
      image.points2d.emplace_back(pixel, point_id);
    }
    EXPECT_TRUE(points.eof());
  }
  std::ifstream points(folder / "points3D.txt");
  while (std::getline(points, line)) {
    if (line.empty() || line[0] == '#') {
      continue;
    }
    std::istringstream fields(line);
    int64_t id = 0;
    fields >> id;
    ColmapPoint& point = model.points[id];
    fields >> point.point.x() >> point.point.y() >> point.point.z();
    fields >> point.rgb[0] >> point.rgb[1] >> point.rgb[2] >> point.error;
    EXPECT_TRUE(fields) << line;
    int image_id = 0;
    std::size_t index = 0;
    while (fields >> image_id >> index) {
      point.track.emplace_back(image_id, index);
    }
    EXPECT_TRUE(fields.eof());
  }
  return model;
}

// COLMAP's camera models as src/colmap/sensor/models.h documents them.
Eigen::Vector2d ColmapProject(const ColmapCamera& camera, const Eigen::Vector3d& in_cam) {
  const std::vector<double>& p = camera.parameters;
  const double u = in_cam.x() / in_cam.z();
  const double v = in_cam.y() / in_cam.z();
  const double r2 = u * u + v * v;
  double x = u;
  double y = v;
  if (camera.model == "OPENCV" || camera.model == "FULL_OPENCV") {
    double radial = 1.0 + p[4] * r2 + p[5] * r2 * r2;
    if (camera.model == "FULL_OPENCV") {
      radial = (radial + p[8] * r2 * r2 * r2) /
               (1.0 + p[9] * r2 + p[10] * r2 * r2 + p[11] * r2 * r2 * r2);
    }
    x = u * radial + 2.0 * p[6] * u * v + p[7] * (r2 + 2.0 * u * u);
    y = v * radial + 2.0 * p[7] * u * v + p[6] * (r2 + 2.0 * v * v);
  } else if (camera.model == "OPENCV_FISHEYE") {
    const double r = std::sqrt(r2);
    const double t = std::atan(r);
    const double t2 = t * t;
    const double distorted = t * (1.0 + t2 * (p[4] + t2 * (p[5] + t2 * (p[6] + t2 * p[7]))));
    x = u * distorted / r;
    y = v * distorted / r;
  } else {
    EXPECT_EQ(camera.model, "PINHOLE");
  }
  return {p[0] * x + p[2], p[1] * y + p[3]};
}

class MapTest : public ::testing::Test {
 protected:
  TemporaryFolder folder_;
};

TEST_F(MapTest, ColmapsRulesFindEveryPointWhereTheImagesSeeIt) {
  const std::tuple<Distortion, bool, std::string, std::size_t> cases[] = {
      {Distortion::kNone, false, "PINHOLE", 4},
      {Distortion::kRadialTangential, false, "OPENCV", 8},
      {Distortion::kRadialTangential, true, "FULL_OPENCV", 12},
      {Distortion::kEquidistant, false, "OPENCV_FISHEYE", 8}};
  for (const auto& [distortion, with_k3, name, parameters] : cases) {
    SCOPED_TRACE(name);
    const Scene scene = MakeScene(distortion, with_k3);
    WriteColmap(folder_.path() / name, MakeMap(scene));
    const ColmapModel model = ReadColmap(folder_.path() / name / "0");

    ASSERT_EQ(model.cameras.size(), 2U);
    for (const auto& [id, camera] : model.cameras) {
      EXPECT_EQ(camera.model, name);
      EXPECT_EQ(camera.width, 752);
      EXPECT_EQ(camera.height, 480);
      ASSERT_EQ(camera.parameters.size(), parameters);
    }
    EXPECT_EQ(model.images.size(), 2U * (kFrames - 1)) << "both images of each key frame";
    EXPECT_GT(model.points.size(), 50U);
    std::set<std::string> names;
    for (const auto& [id, image] : model.images) {
      names.insert(image.name);
      for (std::size_t i = 0; i < image.points2d.size(); ++i) {
        const auto& [pixel, point_id] = image.points2d[i];
        const ColmapPoint& point = model.points.at(point_id);
        const Eigen::Vector2d projected =
            ColmapProject(model.cameras.at(image.camera_id), image.cam_from_world * point.point);
        // Pixels are kept as floats.
        EXPECT_LT((projected - pixel).norm(), 1e-3);
        EXPECT_EQ(std::count(point.track.begin(), point.track.end(), std::pair(id, i)), 1);
      }
    }
    EXPECT_TRUE(names.contains("cam0/5.png") && names.contains("cam1/0.png"));
    EXPECT_FALSE(names.contains("cam0/2.png")) << "no key frame";
    for (const auto& [id, point] : model.points) {
      EXPECT_GE(point.track.size(), 3U);
      EXPECT_EQ(point.rgb[1], 77);
      EXPECT_LT(point.error, 1e-3);
      for (const auto& [image_id, index] : point.track) {
        EXPECT_EQ(model.images.at(image_id).points2d.at(index).second, id);
      }
    }
  }
}

TEST_F(MapTest, ColmapReadsIt) {
  if (std::system("command -v colmap >/dev/null") != 0) {
    GTEST_SKIP() << "colmap is not installed (Debian package colmap)";
  }
  for (const bool with_k3 : {false, true}) {
    const fs::path folder = folder_.path() / (with_k3 ? "full" : "plain");
    const Map map = MakeMap(MakeScene(Distortion::kRadialTangential, with_k3));
    WriteColmap(folder, map);
    std::size_t views = 0;
    for (const Map::Keyframe& keyframe : map.keyframes) {
      views += keyframe.views[0].size() + keyframe.views[1].size();
    }
    // Newer versions print to the error stream, with a prefix.
    const std::string report = (folder / "report").string();
    ASSERT_EQ(std::system(("QT_QPA_PLATFORM=offscreen colmap model_analyzer --path " +
                           (folder / "0").string() + " >" + report + " 2>&1")
                              .c_str()),
              0)
        << Contents(report);
    const std::string text = Contents(report);
    for (const auto& [what, count] :
         {std::pair{"Cameras: ", std::size_t{2}}, std::pair{"Registered images: ", std::size_t{10}},
          std::pair{"Points: ", map.points.size()}, std::pair{"Observations: ", views}}) {
      EXPECT_NE(text.find(what + std::to_string(count) + "\n"), std::string::npos)
          << what << count << " expected in\n"
          << text;
    }
  }
}

TEST_F(MapTest, LeavesOutWrongViewsAndPointsThatTooFewSee) {
  const Scene scene = MakeScene(Distortion::kRadialTangential, false);
  const Map whole = MakeMap(scene);
  MapRecorder recorder(scene.rig.cameras, {});
  std::vector<MapPoint> window = WindowPoints(scene);
  int64_t spoilt = 0;
  int64_t lonely = 0;
  for (int i = 0; i < kFrames; ++i) {
    FrameResult result = SeeScene(scene, i, 0);
    auto& observations = result.tracked_frame.observations;
    if (i == 0) {
      spoilt = observations[0].track_id;
      lonely = observations[1].track_id;
      observations[0].left_pixel.x() += 9.0;
    } else {
      std::erase_if(observations, [&](const Observation& o) { return o.track_id == lonely; });
    }
    recorder.Add(GrayFrame(), Names(i), result, scene.rig, window);
  }
  const Map map = recorder.Build();
  EXPECT_EQ(map.points.size() + 1, whole.points.size());
  const auto views = [](const Map& m, const Eigen::Vector3d& point) {
    std::size_t count = 0;
    for (const Map::Keyframe& keyframe : m.keyframes) {
      for (const auto& side : keyframe.views) {
        for (const Map::View& view : side) {
          count += m.points[view.point].point_in_world == point ? 1 : 0;
        }
      }
    }
    return count;
  };
  const Eigen::Vector3d spoilt_point = scene.points[static_cast<std::size_t>(spoilt - 1000)];
  EXPECT_GT(views(whole, spoilt_point), 3U);
  EXPECT_EQ(views(map, spoilt_point) + 1, views(whole, spoilt_point));
  EXPECT_EQ(views(map, scene.points[static_cast<std::size_t>(lonely - 1000)]), 0U);
}

TEST_F(MapTest, SegmentsAreModelsOfTheirOwn) {
  const Scene scene = MakeScene(Distortion::kNone, false);
  const Map map = MakeMap(scene, 4);
  WriteColmap(folder_.path(), map);
  const ColmapModel first = ReadColmap(folder_.path() / "0");
  const ColmapModel second = ReadColmap(folder_.path() / "1");
  EXPECT_EQ(first.images.size(), 6U);
  EXPECT_EQ(second.images.size(), 4U);
  EXPECT_EQ(first.points.size() + second.points.size(), map.points.size());
  EXPECT_GT(second.points.size(), 50U);
  // A later map of one segment leaves no model of the earlier one.
  WriteColmap(folder_.path(), MakeMap(scene));
  EXPECT_TRUE(fs::exists(folder_.path() / "0" / "points3D.txt"));
  EXPECT_FALSE(fs::exists(folder_.path() / "1"));
}

// Little-endian values of a binary PLY file after its header.
template <typename T>
T Take(const std::string& bytes, std::size_t& at) {
  T value;
  std::memcpy(&value, bytes.data() + at, sizeof(T));
  at += sizeof(T);
  return value;
}

TEST_F(MapTest, PlyHoldsPointsAndKeyframes) {
  const Scene scene = MakeScene(Distortion::kNone, false);
  const Map map = MakeMap(scene, 4);
  WritePly(folder_.path() / "new", map);
  const std::string points = Contents(folder_.path() / "new" / "points.ply");
  ASSERT_EQ(points.rfind("ply\nformat binary_little_endian 1.0\n", 0), 0U);
  EXPECT_NE(points.find("element vertex " + std::to_string(map.points.size()) + "\n"),
            std::string::npos);
  std::size_t at = points.find("end_header\n") + 11;
  ASSERT_EQ(points.size() - at, map.points.size() * (3 * 4 + 3 + 4));
  for (const Map::Point& point : map.points) {
    for (int i = 0; i < 3; ++i) {
      EXPECT_EQ(Take<float>(points, at), static_cast<float>(point.point_in_world[i]));
    }
    for (int i = 0; i < 3; ++i) {
      EXPECT_EQ(Take<uint8_t>(points, at), 77);
    }
    EXPECT_EQ(Take<int32_t>(points, at), point.segment);
  }

  const std::string keyframes = Contents(folder_.path() / "new" / "keyframes.ply");
  EXPECT_NE(keyframes.find("element vertex 5\n"), std::string::npos);
  EXPECT_NE(keyframes.find("element edge 3\n"), std::string::npos) << "none over the break";
  at = keyframes.find("end_header\n") + 11;
  ASSERT_EQ(keyframes.size() - at, 5U * (6 * 4 + 8 + 4) + 3U * 8);
  for (const int frame : {0, 1, 3, 4, 5}) {
    const Rigid3 world_from_left =
        scene.world_from_body[static_cast<std::size_t>(frame)] * scene.rig.body_from_cam[0];
    const Eigen::Vector3d direction = world_from_left.rotation * Eigen::Vector3d(0.0, 0.0, 1.0);
    for (int i = 0; i < 3; ++i) {
      EXPECT_NEAR(Take<float>(keyframes, at), world_from_left.translation[i], 1e-6);
    }
    for (int i = 0; i < 3; ++i) {
      EXPECT_NEAR(Take<float>(keyframes, at), direction[i], 1e-6);
    }
    EXPECT_DOUBLE_EQ(Take<double>(keyframes, at), 0.1 * frame);
    EXPECT_EQ(Take<int32_t>(keyframes, at), frame < 4 ? 0 : 1);
  }
  for (const int start : {0, 1, 3}) {
    EXPECT_EQ(Take<int32_t>(keyframes, at), start);
    EXPECT_EQ(Take<int32_t>(keyframes, at), start + 1);
  }
}

TEST_F(MapTest, RefusesWhatItCannotWrite) {
  const Scene scene = MakeScene(Distortion::kNone, false);
  MapRecorder recorder(scene.rig.cameras, {});
  try {
    recorder.Add(GrayFrame(), {"left 1.png", "right.png"}, SeeScene(scene, 0, 0), scene.rig, {});
    FAIL() << "a name with a blank was taken";
  } catch (const Error& error) {
    EXPECT_NE(std::string(error.what()).find("left 1.png"), std::string::npos);
  }
  EXPECT_THROW(MapRecorder(scene.rig.cameras, {.min_views = 1}), Error);
  std::ofstream(folder_.path() / "file") << "x";
  EXPECT_THROW(WritePly(folder_.path() / "file", MakeMap(scene)), Error);
}

}  // namespace
}  // namespace gluevo::vo
