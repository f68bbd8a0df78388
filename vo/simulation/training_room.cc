#include "training_room.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <opencv2/imgproc.hpp>
#include <optional>

#include "gluevo/vo/simulation/simulation.h"
#include "random.h"
#include "room.h"
#include "sensor.h"

namespace gluevo::simulation {
namespace {

constexpr int kGrid = 8;  // pixels
constexpr double kPi = std::numbers::pi;

/// A body upright but for pitch and roll (x up, z forward).
vo::Rigid3 Place(const Eigen::Vector3d& position, double yaw, double pitch, double roll) {
  Eigen::Matrix3d level;
  level.col(0) = Eigen::Vector3d::UnitZ();
  level.col(1) = -Eigen::Vector3d::UnitY();
  level.col(2) = Eigen::Vector3d::UnitX();
  const Eigen::Quaterniond rotation = Eigen::AngleAxisd(yaw, Eigen::Vector3d::UnitZ()) *
                                      Eigen::AngleAxisd(pitch, Eigen::Vector3d::UnitY()) *
                                      Eigen::Quaterniond(level) *
                                      Eigen::AngleAxisd(roll, Eigen::Vector3d::UnitZ());
  return {rotation, position};
}

/// The poses of the stereo pairs: around one place, by small steps and by jumps.
std::vector<vo::Rigid3> DrawPoses(const RoomPlan& plan, RandomStream* random) {
  constexpr double kWall = 0.5;  // metres
  const auto inside = [&](const Eigen::Vector3d& point) {
    const Eigen::Vector3d margin = Eigen::Vector3d::Constant(kWall);
    return Eigen::Vector3d(point.cwiseMax(plan.low + margin).cwiseMin(plan.high - margin));
  };
  const Eigen::Vector3d size = plan.high - plan.low;
  const auto around = [random](double reach) { return random->Uniform(-reach, reach); };
  const Eigen::Vector3d start =
      inside(plan.low +
             size.cwiseProduct(Eigen::Vector3d(random->Uniform(0.0, 1.0), random->Uniform(0.0, 1.0),
                                               random->Uniform(0.2, 0.8))));
  // Mostly towards the middle: a wall that fills the image teaches little.
  const Eigen::Vector3d to_middle = 0.5 * (plan.low + plan.high) - start;
  const double yaw = std::atan2(to_middle.y(), to_middle.x()) + around(1.2);
  const double pitch = around(0.3);
  const double roll = around(0.15);
  std::vector<vo::Rigid3> poses = {Place(start, yaw, pitch, roll)};
  for (int i = 1; i < kViews / 2; ++i) {
    const bool jump = i >= 2;
    const double turn = jump ? 45.0 : 8.0;
    const double reach = jump ? 1.5 : 0.3;
    const double shift = 0.5 * reach;
    const Eigen::Vector3d position =
        inside(start + Eigen::Vector3d(around(reach), around(reach), around(shift)));
    const double radians = turn * kPi / 180.0;
    poses.push_back(Place(position, yaw + around(radians), pitch + around(0.3 * radians),
                          roll + around(0.3 * radians)));
  }
  return poses;
}

/// Each camera sees the room in its own way.
cv::Mat Photograph(cv::Mat brightness, RandomStream* random) {
  ImageOptions image;
  image.noise = random->Uniform(0.0, 6.0);
  image.vignetting = random->Index(2) == 0 ? random->Uniform(0.0, 0.5) : 0.0;
  const double exposure = std::exp2(random->Uniform(-1.0, 0.7));
  const double gamma = std::exp2(random->Uniform(-0.4, 0.4));
  const double blur = random->Index(2) == 0 ? random->Uniform(0.3, 1.2) : 0.0;
  if (blur > 0.0) cv::GaussianBlur(brightness, brightness, cv::Size(), blur);
  cv::Mat exposed = Sensor(image).Expose(brightness, exposure, random->Next());
  std::array<uint8_t, 256> curve = {};
  for (int i = 0; i < 256; ++i) {
    curve[i] = static_cast<uint8_t>(std::lround(255.0 * std::pow(i / 255.0, gamma)));
  }
  for (int y = 0; y < exposed.rows; ++y) {
    uint8_t* const line = exposed.ptr<uint8_t>(y);
    for (int x = 0; x < exposed.cols; ++x) line[x] = curve[line[x]];
  }
  return exposed;
}

void Append(const SimulatedBox& box, std::vector<double>* boxes) {
  boxes->insert(boxes->end(), box.center.begin(), box.center.end());
  boxes->insert(boxes->end(), box.half_size.begin(), box.half_size.end());
  boxes->push_back(box.yaw);
}

void FindCorrespondences(const std::vector<Eye>& eyes, const GridRays& rays, TrainingRoom* room) {
  constexpr double kLeastOverlap = 0.1;
  const std::size_t count = rays[0].size();
  std::vector<std::vector<std::optional<Eigen::Vector3d>>> points(eyes.size());
  for (std::size_t view = 0; view < eyes.size(); ++view) {
    for (const Eigen::Vector2d& ray : rays[view % 2]) {
      points[view].push_back(eyes[view].PointAlong(ray));
    }
  }
  // Of the ordered pair (first, second), kept until the other order is known, too.
  std::vector<std::vector<float>> seen(eyes.size() * eyes.size());
  std::vector<double> overlap(seen.size());
  const auto at = [&](std::size_t first, std::size_t second) {
    return first * eyes.size() + second;
  };
  for (std::size_t first = 0; first < eyes.size(); ++first) {
    for (std::size_t second = 0; second < eyes.size(); ++second) {
      if (first == second) continue;
      std::size_t found = 0;
      for (const auto& point : points[first]) {
        const auto pixel = point ? eyes[second].PixelOf(*point) : std::nullopt;
        found += pixel ? 1 : 0;
        seen[at(first, second)].push_back(pixel ? static_cast<float>(pixel->x()) : -1.0F);
        seen[at(first, second)].push_back(pixel ? static_cast<float>(pixel->y()) : -1.0F);
      }
      overlap[at(first, second)] = static_cast<double>(found) / static_cast<double>(count);
    }
  }
  for (std::size_t first = 0; first < eyes.size(); ++first) {
    for (std::size_t second = 0; second < eyes.size(); ++second) {
      if (first == second || overlap[at(first, second)] < kLeastOverlap ||
          overlap[at(second, first)] < kLeastOverlap) {
        continue;
      }
      room->pairs.push_back(static_cast<int32_t>(first));
      room->pairs.push_back(static_cast<int32_t>(second));
      room->overlap.push_back(static_cast<float>(overlap[at(first, second)]));
      const std::vector<float>& pixels = seen[at(first, second)];
      room->correspondences.insert(room->correspondences.end(), pixels.begin(), pixels.end());
    }
  }
}

}  // namespace

vo::StereoRig DrawRig(const PairOptions& options, uint64_t seed) {
  vo::StereoRig rig = SimulationRig(options.width, options.height);
  RandomStream random(seed);
  const double zoom = random.Uniform(0.8, 1.4);
  const double distortion = random.Uniform(0.0, 1.0);
  const double baseline = random.Uniform(0.7, 2.5);
  for (vo::Camera& camera : rig.cameras) {
    camera.fx *= zoom;
    camera.fy *= zoom;
    for (double& coefficient : camera.coefficients) coefficient *= distortion;
  }
  vo::Rigid3& left = rig.body_from_cam[0];
  vo::Rigid3& right = rig.body_from_cam[1];
  right.translation = left.translation + baseline * (right.translation - left.translation);
  return rig;
}

std::vector<float> GridOf(const PairOptions& options) {
  std::vector<float> grid;
  for (int y = kGrid / 2; y < options.height; y += kGrid) {
    for (int x = kGrid / 2; x < options.width; x += kGrid) {
      grid.push_back(static_cast<float>(x));
      grid.push_back(static_cast<float>(y));
    }
  }
  return grid;
}

GridRays RaysOf(const std::vector<float>& grid, const vo::StereoRig& rig) {
  GridRays rays;
  for (std::size_t i = 0; i < grid.size(); i += 2) {
    for (const int camera : {0, 1}) {
      rays[camera].push_back(rig.cameras[camera].Undistort({grid[i], grid[i + 1]}));
    }
  }
  return rays;
}

TrainingRoom MakeTrainingRoom(const PairOptions& options, const Renderer& renderer,
                              const GridRays& rays, uint64_t seed) {
  RandomStream random(seed);
  const vo::StereoRig& rig = renderer.rig();
  RoomPlan plan;
  plan.low.setZero();
  plan.high = {random.Uniform(4.0, 8.0), random.Uniform(4.0, 8.0), random.Uniform(2.5, 3.6)};
  const std::vector<vo::Rigid3> poses = DrawPoses(plan, &random);
  std::vector<Eigen::Vector3d> positions;
  for (const vo::Rigid3& pose : poses) positions.push_back(pose.translation);
  RoomStyle style;
  // A texel is what a pixel covers at 4 m, or at 3 m on boxes: most of a room's time is spent here.
  style.texel_m = std::clamp(4.0 / rig.cameras[0].fx, 0.002, 0.03);
  style.box_texel_m = 0.75 * style.texel_m;
  style.floor_per_box = random.Uniform(3.0, 8.0);
  style.any_cover = true;
  const SimulatedWorld world = MakeRoom(
      random.Next(), plan, positions, style, 1,
      [&](const SimulatedWorld& plain, SeenParts* seen) {
        for (int view = 0; view < kViews; ++view) {
          renderer.AddSeen(plain, view % 2, poses[view / 2], seen);
        }
      },
      options.checkpoint);

  TrainingRoom room;
  Append(world.room, &room.boxes);
  for (const SimulatedBox& box : world.boxes) Append(box, &room.boxes);
  std::vector<Eye> eyes;
  for (int view = 0; view < kViews; ++view) {
    const int camera = view % 2;
    const vo::Rigid3& world_from_body = poses[view / 2];
    const cv::Mat image = Photograph(renderer.Render(world, camera, {world_from_body}), &random);
    room.images.insert(room.images.end(), image.datastart, image.dataend);
    if (options.depth) {
      const cv::Mat depth = renderer.Depth(world, camera, world_from_body);
      room.depth.insert(room.depth.end(), depth.begin<float>(), depth.end<float>());
    }
    eyes.push_back(renderer.At(world, camera, world_from_body));
    const vo::Rigid3 world_from_cam = world_from_body * rig.body_from_cam[camera];
    const Eigen::Vector3d& t = world_from_cam.translation;
    const Eigen::Quaterniond& q = world_from_cam.rotation;
    room.world_from_cam.insert(room.world_from_cam.end(),
                               {t.x(), t.y(), t.z(), q.x(), q.y(), q.z(), q.w()});
    const vo::Camera& model = rig.cameras[camera];
    const auto& k = model.coefficients;
    room.cameras.insert(room.cameras.end(),
                        {model.fx, model.fy, model.cx, model.cy, k[0], k[1], k[2], k[3]});
  }
  FindCorrespondences(eyes, rays, &room);
  return room;
}

}  // namespace gluevo::simulation
