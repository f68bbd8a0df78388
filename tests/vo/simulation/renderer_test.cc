#include "renderer.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <opencv2/calib3d.hpp>
#include <opencv2/core/eigen.hpp>
#include <opencv2/imgproc.hpp>
#include <set>

#include "gluevo/vo/simulation/simulation.h"
#include "path.h"
#include "room.h"
#include "sensor.h"

namespace gluevo::simulation {
namespace {

/// OpenCV's own camera model, so that nothing of ours checks itself.
std::vector<cv::Point2d> ProjectWithOpenCv(const vo::StereoRig& rig, int camera,
                                           const vo::Rigid3& world_from_body,
                                           const std::vector<Eigen::Vector3d>& points_in_world) {
  const vo::Camera& model = rig.cameras[camera];
  const vo::Rigid3 cam_from_world = (world_from_body * rig.body_from_cam[camera]).Inverse();
  cv::Mat rotation;
  cv::eigen2cv(Eigen::Matrix3d(cam_from_world.rotation.toRotationMatrix()), rotation);
  cv::Mat rotation_vector;
  cv::Rodrigues(rotation, rotation_vector);
  const Eigen::Vector3d& t = cam_from_world.translation;
  const cv::Matx33d matrix(model.fx, 0, model.cx, 0, model.fy, model.cy, 0, 0, 1);
  const std::vector<double> distortion(model.coefficients.begin(), model.coefficients.end());
  std::vector<cv::Point3d> points;
  points.reserve(points_in_world.size());
  for (const Eigen::Vector3d& point : points_in_world) {
    points.emplace_back(point.x(), point.y(), point.z());
  }
  std::vector<cv::Point2d> pixels;
  cv::projectPoints(points, rotation_vector, cv::Vec3d(t.x(), t.y(), t.z()), matrix, distortion,
                    pixels);
  return pixels;
}

/// Centroid of the polygon's inside (Green's theorem).
cv::Point2d PolygonCentroid(const std::vector<cv::Point2d>& polygon) {
  double area = 0.0;
  cv::Point2d moment(0.0, 0.0);
  // Relative to a vertex: the sums of large coordinates would cancel.
  const cv::Point2d origin = polygon.front();
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const cv::Point2d a = polygon[i] - origin;
    const cv::Point2d b = polygon[(i + 1) % polygon.size()] - origin;
    const double cross = a.x * b.y - b.x * a.y;
    area += cross / 2.0;
    moment += (a + b) * (cross / 6.0);
  }
  return origin + moment / area;
}

constexpr double kDiscRadius = 0.12;
constexpr double kDiscSpacing = 0.5;

/// A wall of 7 x 4.5 m, turned, with black discs on white, in an empty room.
SimulatedWorld WorldOfDiscs() {
  SimulatedWorld world;
  world.room.half_size = {10.0, 10.0, 5.0};
  SimulatedBox wall;
  wall.center = {2.5, 0.0, 0.0};
  wall.half_size = {0.1, 3.5, 2.25};
  wall.yaw = 0.25;
  const Pattern discs = [](double u, double v) {
    const double x = u - kDiscSpacing * std::round(u / kDiscSpacing);
    const double y = v - kDiscSpacing * std::round(v / kDiscSpacing);
    return std::hypot(x, y) < kDiscRadius ? 0.0 : 200.0 / 255.0;
  };
  wall.faces[0] = Texture(7.0, 4.5, 0.001, discs, 2);
  world.boxes.push_back(std::move(wall));
  return world;
}

/// At the origin, looking along +x with a tilt.
vo::Rigid3 TiltedBody() {
  Eigen::Matrix3d world_from_body;
  world_from_body.col(0) = Eigen::Vector3d::UnitZ();
  world_from_body.col(1) = -Eigen::Vector3d::UnitY();
  world_from_body.col(2) = Eigen::Vector3d::UnitX();
  const Eigen::AngleAxisd tilt(0.1, Eigen::Vector3d(1.0, -0.5, 0.7).normalized());
  return {Eigen::Quaterniond(world_from_body * tilt), Eigen::Vector3d(0.05, -0.1, 0.03)};
}

// The figures of the picture itself: the centroid of each rendered disc against that of the outline
// projected with OpenCV. Edges are known to a quarter of a pixel's area and to half a texel
// (0.2 px), both random along an outline of more than 100 pixels around an area of more than 1000,
// so that a centroid is good to about 0.2 * sqrt(100) * 20 / 1000 / 4 = 0.01 px.
TEST(RendererTest, DrawsDiscsWhereTheCameraModelPutsThem) {
  const vo::StereoRig rig = SimulationRig(752, 480);
  const SimulatedWorld world = WorldOfDiscs();
  const Renderer renderer(rig, 2);
  const vo::Rigid3 world_from_body = TiltedBody();
  for (int camera = 0; camera < 2; ++camera) {
    cv::Mat image;
    renderer.Render(world, camera, {world_from_body}).convertTo(image, CV_8UC1);
    int compared = 0;
    for (int column = 1; column < 14; ++column) {
      for (int row = 1; row < 9; ++row) {
        std::vector<Eigen::Vector3d> outline;
        for (int i = 0; i < 720; ++i) {
          const double angle = i * std::numbers::pi / 360.0;
          const double u = kDiscSpacing * column + kDiscRadius * std::cos(angle);
          const double v = kDiscSpacing * row + kDiscRadius * std::sin(angle);
          outline.push_back(world.boxes[0].WorldFromBox({-0.1, u - 3.5, v - 2.25}));
        }
        const std::vector<cv::Point2d> pixels =
            ProjectWithOpenCv(rig, camera, world_from_body, outline);
        cv::Rect window = cv::boundingRect(std::vector<cv::Point2f>(pixels.begin(), pixels.end()));
        window -= cv::Point(4, 4);
        window += cv::Size(8, 8);
        if ((window & cv::Rect(cv::Point(), image.size())) != window) continue;
        double weight = 0.0;
        cv::Point2d sum(0.0, 0.0);
        for (int y = window.y; y < window.br().y; ++y) {
          for (int x = window.x; x < window.br().x; ++x) {
            const double dark = 200.0 - image.at<uint8_t>(y, x);
            weight += dark;
            sum += dark * cv::Point2d(x, y);
          }
        }
        const cv::Point2d expected = PolygonCentroid(pixels);
        EXPECT_NEAR(sum.x / weight, expected.x, 0.02) << camera << " " << column << " " << row;
        EXPECT_NEAR(sum.y / weight, expected.y, 0.02) << camera << " " << column << " " << row;
        ++compared;
      }
    }
    EXPECT_GT(compared, 12) << camera;
  }
}

class HallTest : public ::testing::Test {
 protected:
  HallTest()
      : rig_(SimulationRig(752, 480)),
        path_(MakeSimulationPath("hall_loop")),
        world_(MakeRoom(7, PlanRoom(PathPoints(), {2.6, 2.6}), PathPoints(), RoomStyle{0.02, 0.02},
                        2)) {}

  std::vector<Eigen::Vector3d> PathPoints() const {
    constexpr int kSteps = 420;
    std::vector<Eigen::Vector3d> points;
    points.reserve(kSteps);
    for (int step = 0; step < kSteps; ++step) {
      points.push_back(path_(0.05 * step).translation);
    }
    return points;
  }

  vo::StereoRig rig_;
  SimulationPath path_;
  SimulatedWorld world_;
};

TEST_F(HallTest, ExactPointsReprojectIntoBothImages) {
  const Renderer renderer(rig_, 2);
  int seen_by_both = 0;
  int hidden = 0;
  for (const double time : {0.0, 3.7, 9.1, 14.2}) {
    const vo::Rigid3 world_from_body = path_(time);
    const vo::Rigid3 world_from_right = world_from_body * rig_.body_from_cam[1];
    for (int y = 10; y < 480; y += 47) {
      for (int x = 10; x < 752; x += 61) {
        const auto point = renderer.At(world_, 0, world_from_body).PointAt(Eigen::Vector2d(x, y));
        ASSERT_TRUE(point.has_value());
        const cv::Point2d left = ProjectWithOpenCv(rig_, 0, world_from_body, {*point})[0];
        EXPECT_NEAR(left.x, x, 1e-6);
        EXPECT_NEAR(left.y, y, 1e-6);
        const cv::Point2d right = ProjectWithOpenCv(rig_, 1, world_from_body, {*point})[0];
        if (right.x < 0 || right.y < 0 || right.x > 751 || right.y > 479) continue;
        const auto again =
            renderer.At(world_, 1, world_from_body).PointAt(Eigen::Vector2d(right.x, right.y));
        ASSERT_TRUE(again.has_value());
        // What the right camera sees there is the same point, or something in front of it.
        const Eigen::Vector3d ray = *point - world_from_right.translation;
        const Eigen::Vector3d ray_again = *again - world_from_right.translation;
        EXPECT_LT(ray.cross(ray_again).norm(), 1e-6 * ray.norm() * ray_again.norm());
        EXPECT_LT(ray_again.norm(), ray.norm() + 1e-6);
        const bool seen = ray.norm() - ray_again.norm() < 1e-6;
        (seen ? seen_by_both : hidden) += 1;
        const auto pixel = renderer.At(world_, 1, world_from_body).PixelOf(*point);
        ASSERT_EQ(pixel.has_value(), seen);
        if (!seen) continue;
        EXPECT_NEAR(pixel->x(), right.x, 1e-6);
        EXPECT_NEAR(pixel->y(), right.y, 1e-6);
      }
    }
  }
  EXPECT_GT(seen_by_both, 300);
  EXPECT_LT(hidden, seen_by_both / 10);
}

// The renderer's tiles and homographies in float find the surfaces that casting rays in double
// finds, but for the few pixels whose ray passes an edge within rounding.
TEST_F(HallTest, DepthMapsAreTheDistancesOfRays) {
  const Renderer renderer(rig_, 2);
  std::set<int> boxes;
  for (const double time : {1.0, 5.0, 11.0, 17.0}) {
    const vo::Rigid3 world_from_body = path_(time);
    const vo::Rigid3 world_from_cam = world_from_body * rig_.body_from_cam[1];
    const WorldView view(world_, world_from_cam.translation);
    const cv::Mat depth = renderer.Depth(world_, 1, world_from_body);
    ASSERT_EQ(depth.size(), cv::Size(752, 480));
    int different = 0;
    for (int y = 0; y < 480; y += 3) {
      for (int x = 0; x < 752; x += 2) {
        const Eigen::Vector3d ray = rig_.cameras[1].Undistort(Eigen::Vector2d(x, y)).homogeneous();
        const auto hit = view.Cast(world_from_cam.rotation * ray);
        ASSERT_TRUE(hit.has_value());
        boxes.insert(hit->box);
        different += std::abs(depth.at<float>(y, x) / hit->distance - 1.0) < 2e-6 ? 0 : 1;
      }
    }
    EXPECT_LE(different, 3) << time;
  }
  EXPECT_GE(boxes.size(), 5U);
}

// An equidistant camera of 240 degrees has no ray in its corners.
TEST_F(HallTest, PixelsWithoutARayAreBlack) {
  vo::StereoRig rig = rig_;
  for (vo::Camera& camera : rig.cameras) {
    camera = {200, 200, 60.0, 60.0, 99.5, 99.5};
    camera.distortion = vo::Distortion::kEquidistant;
  }
  const Renderer renderer(rig, 2);
  const vo::Rigid3 pose = path_(2.0);
  const cv::Mat image = renderer.Render(world_, 0, {pose});
  const cv::Mat depth = renderer.Depth(world_, 0, pose);
  int seen = 0;
  for (int y = 0; y < 200; ++y) {
    for (int x = 0; x < 200; ++x) {
      const bool has_ray = rig.cameras[0].Undistort(Eigen::Vector2d(x, y)).allFinite();
      EXPECT_EQ(has_ray, std::isfinite(depth.at<float>(y, x)));
      EXPECT_EQ(has_ray, renderer.At(world_, 0, pose).PointAt(Eigen::Vector2d(x, y)).has_value());
      seen += has_ray ? 1 : 0;
    }
  }
  EXPECT_GT(seen, 20000);
  EXPECT_LT(seen, 35000);
  EXPECT_EQ(image.at<float>(0, 0), 0.0F);
  EXPECT_GT(image.at<float>(100, 100), 0.0F);
}

// A body that turns by 0.02 rad sees a mean of what it saw on the way.
TEST_F(HallTest, MotionBlurIsTheMeanOfTheExposure) {
  const Renderer renderer(rig_, 2);
  std::vector<vo::Rigid3> poses;
  cv::Mat mean(480, 752, CV_32FC1, cv::Scalar(0.0));
  constexpr int kPoses = 16;
  for (int i = 0; i < kPoses; ++i) {
    const Eigen::AngleAxisd turn(0.02 * i / kPoses, Eigen::Vector3d::UnitX());
    poses.push_back(path_(3.0) * vo::Rigid3{Eigen::Quaterniond(turn), Eigen::Vector3d::Zero()});
    mean += renderer.Render(world_, 0, {poses.back()}) / kPoses;
  }
  const cv::Mat blurred = renderer.Render(world_, 0, poses);
  // A quarter of the samples: differences of noise at edges, none in the mean.
  EXPECT_NEAR(cv::mean(blurred)[0], cv::mean(mean)[0], 0.05);
  EXPECT_LT(cv::norm(blurred, mean, cv::NORM_L1) / (480 * 752), 1.5);
  EXPECT_GT(cv::norm(renderer.Render(world_, 0, {poses[0]}), mean, cv::NORM_L1) / (480 * 752), 3.0);
}

TEST_F(HallTest, PathKeepsClearOfEverything) {
  EXPECT_GE(world_.boxes.size(), 9U);
  for (const Eigen::Vector3d& point : PathPoints()) {
    EXPECT_LT(
        (point - world_.room.center).cwiseQuotient(world_.room.half_size).cwiseAbs().maxCoeff(),
        0.9);
    for (const SimulatedBox& box : world_.boxes) EXPECT_GT(box.Distance(point), 0.59);
  }
}

TEST_F(HallTest, EveryViewHasCornersAllOver) {
  const SimulatedWorld world =
      MakeRoom(7, PlanRoom(PathPoints(), {2.6, 2.6}), PathPoints(), RoomStyle{0.004, 0.004}, 2);
  const Renderer renderer(rig_, 2);
  const Sensor sensor((ImageOptions()));
  for (const double time : {0.0, 4.0, 8.0, 12.0, 16.0}) {
    const cv::Mat image = sensor.Expose(renderer.Render(world, 0, {path_(time)}), 1.0, 1);
    const double mean = cv::mean(image)[0];
    EXPECT_GT(mean, 60.0) << time;
    EXPECT_LT(mean, 170.0) << time;
    for (int quarter = 0; quarter < 4; ++quarter) {
      const cv::Rect part(quarter % 2 * 376, quarter / 2 * 240, 376, 240);
      std::vector<cv::Point2f> corners;
      cv::goodFeaturesToTrack(image(part), corners, 1000, 0.03, 10.0);
      EXPECT_GT(corners.size(), 60U) << time << " s, quarter " << quarter;
    }
  }
}

// At steep angles and near walls, too, where coarse levels of the textures are read.
TEST_F(HallTest, TexturesOnlyOfWhatIsSeenGiveTheSameImages) {
  const vo::StereoRig rig = SimulationRig(376, 240);
  const Renderer renderer(rig, 2);
  RoomPlan plan;
  plan.low.setZero();
  plan.high = {6.0, 5.0, 3.0};
  const RoomStyle style{0.017, 0.012, 4.0, true};
  int gray = 0;
  for (uint64_t seed = 0; seed < 6; ++seed) {
    std::vector<vo::Rigid3> poses = {path_(1.7 * static_cast<double>(seed)),
                                     path_(1.7 * static_cast<double>(seed) + 0.6)};
    poses[0].translation = {0.3 + 0.9 * static_cast<double>(seed), 0.2, 1.5};
    poses[1].translation = {3.0, 2.5, 0.2 + 0.5 * static_cast<double>(seed)};
    const std::vector<Eigen::Vector3d> places = {poses[0].translation, poses[1].translation};
    const SimulatedWorld whole = MakeRoom(seed, plan, places, style, 2);
    const SimulatedWorld seen =
        MakeRoom(seed, plan, places, style, 2, [&](const SimulatedWorld& plain, SeenParts* parts) {
          for (const vo::Rigid3& pose : poses) {
            for (const int camera : {0, 1}) renderer.AddSeen(plain, camera, pose, parts);
          }
        });
    for (const vo::Rigid3& pose : poses) {
      for (const int camera : {0, 1}) {
        EXPECT_EQ(cv::norm(renderer.Render(whole, camera, {pose}),
                           renderer.Render(seen, camera, {pose}), cv::NORM_INF),
                  0.0)
            << seed << " " << camera;
      }
    }
    for (int face = 0; face < 6; ++face) {
      const float at_corner = seen.room.faces[face].At(-10.0F).Sample(0.0F, 0.0F);
      gray += at_corner == 128.0F ? 1 : 0;
    }
  }
  EXPECT_GT(gray, 6);
}

TEST(TextureTest, SamplesWhatWasBaked) {
  // A ramp of 0.1 a metre: bilinear sampling reproduces it up to the rounding to 1 / 255, at all
  // scales and away from the edges.
  const Texture texture(
      2.0, 1.0, 0.01, [](double u, double v) { return 0.1 * u + 0.3 * v; }, 2);
  for (const double footprint : {0.001, 0.01, 0.02, 0.05}) {
    for (const double u : {0.2, 0.513, 1.7}) {
      for (const double v : {0.21, 0.777}) {
        EXPECT_NEAR(texture.At(static_cast<float>(std::log2(footprint)))
                        .Sample(static_cast<float>(u), static_cast<float>(v)),
                    255.0 * (0.1 * u + 0.3 * v), 1.0);
      }
    }
  }
}

TEST(NormalTableTest, IsStandardNormal) {
  const NormalTable normal;
  double sum = 0.0;
  double squares = 0.0;
  int within_one = 0;
  constexpr int kCount = 1 << NormalTable::kBits;
  for (int i = 0; i < kCount; ++i) {
    const double value = normal(static_cast<uint64_t>(i) << (64 - NormalTable::kBits));
    sum += value;
    squares += value * value;
    within_one += std::abs(value) < 1.0 ? 1 : 0;
  }
  EXPECT_NEAR(sum / kCount, 0.0, 1e-6);
  EXPECT_NEAR(squares / kCount, 1.0, 2e-3);
  EXPECT_NEAR(static_cast<double>(within_one) / kCount, 0.682689, 1e-3);
}

}  // namespace
}  // namespace gluevo::simulation
