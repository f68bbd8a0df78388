#include "gluevo/vo/geometry/triangulation.h"

#include <gtest/gtest.h>

#include <limits>
#include <vector>

#include "gluevo/nn/error.h"
#include "gluevo/vo/geometry/manifold.h"
#include "vo/scene.h"

namespace gluevo::vo {
namespace {

PosedObservation ViewOf(const Rigid3& world_from_cam, const Eigen::Vector3d& point) {
  const Rigid3 cam_from_world = world_from_cam.Inverse();
  return {cam_from_world, (cam_from_world * point).hnormalized()};
}

TEST(Triangulation, StereoByHand) {
  // Baseline 0.5 m along x, disparity 0.1 on the normalised plane: depth 0.5 / 0.1 = 5 m, and the
  // point lies at 5 * (0.2, -0.1, 1).
  const std::vector<PosedObservation> views = {
      {{}, {0.2, -0.1}}, {{Eigen::Quaterniond::Identity(), {-0.5, 0.0, 0.0}}, {0.1, -0.1}}};
  const auto point = Triangulate(views, {});
  ASSERT_TRUE(point);
  EXPECT_LT((*point - Eigen::Vector3d(1.0, -0.5, 5.0)).norm(), 1e-10);
}

TEST(Triangulation, ManyViewsFarFromTheOrigin) {
  std::mt19937_64 generator(7);
  const Eigen::Vector3d point = Eigen::Vector3d(1e4, -2e4, 300.0);
  std::vector<PosedObservation> views;
  for (int i = 0; i < 6; ++i) {
    const Eigen::Vector3d turn = testing::UniformVector(generator, 0.1);
    const Eigen::Vector3d center =
        point - Eigen::Vector3d(0.0, 0.0, 6.0) + testing::UniformVector(generator, 1.0);
    views.push_back(ViewOf({ExpSo3(turn), center}, point));
  }
  const auto found = Triangulate(views, {});
  ASSERT_TRUE(found);
  // Coordinates of 2e4 m carry a rounding error of 4e-12 m, magnified by depth over baseline.
  EXPECT_LT((*found - point).norm(), 1e-9);
}

TEST(Triangulation, NoiseGivesTheLeastReprojectionError) {
  // The answer's error must be no larger than the true point's.
  std::mt19937_64 generator(9);
  for (int trial = 0; trial < 20; ++trial) {
    const Eigen::Vector3d point = Eigen::Vector3d(0, 0, 5) + testing::UniformVector(generator, 1);
    std::vector<PosedObservation> views;
    double true_cost = 0.0;
    for (int i = 0; i < 4; ++i) {
      views.push_back(ViewOf(
          {ExpSo3(testing::UniformVector(generator, 0.05)), testing::UniformVector(generator, 0.5)},
          point));
      const Eigen::Vector2d noise(testing::Gaussian(generator) / 460.0,
                                  testing::Gaussian(generator) / 460.0);
      views.back().normalized += noise;
      true_cost += noise.squaredNorm();
    }
    const auto found = Triangulate(views, {.max_error_px = 46.0});
    ASSERT_TRUE(found);
    double cost = 0.0;
    for (const PosedObservation& view : views) {
      cost += ((view.cam_from_world * *found).hnormalized() - view.normalized).squaredNorm();
    }
    EXPECT_LE(cost, true_cost);
  }
}

TEST(Triangulation, LeavesOutWhatCannotBeTrusted) {
  const Rigid3 left;
  const Rigid3 right{Eigen::Quaterniond::Identity(), {0.1, 0.0, 0.0}};
  const auto stereo = [&](const Eigen::Vector3d& point) {
    return std::vector<PosedObservation>{ViewOf(left, point), ViewOf(right, point)};
  };
  const TriangulationOptions options;
  EXPECT_TRUE(Triangulate(stereo({0.0, 0.0, 5.0}), options));
  // Too close, and too far for the parallax: 0.1 m / 100 m is below 1 / 460.
  EXPECT_FALSE(Triangulate(stereo({0.0, 0.0, 0.05}), options));
  EXPECT_FALSE(Triangulate(stereo({0.0, 0.0, 100.0}), options));
  // Disparity of the wrong sign: the rays meet behind the cameras.
  EXPECT_FALSE(Triangulate(stereo({0.0, 0.0, -5.0}), options));
  // Rays that miss each other by 10 px.
  auto skew = stereo({0.0, 0.0, 5.0});
  skew[1].normalized.y() += 10.0 / 460.0;
  EXPECT_FALSE(Triangulate(skew, options));
  // Standing still.
  EXPECT_FALSE(
      Triangulate(std::vector<PosedObservation>(5, ViewOf(left, {0.0, 0.0, 5.0})), options));
  // One view, none, and values that are not finite.
  EXPECT_FALSE(Triangulate(std::vector<PosedObservation>{ViewOf(left, {0.0, 0.0, 5.0})}, options));
  EXPECT_FALSE(Triangulate(std::vector<PosedObservation>{}, options));
  auto nan = stereo({0.0, 0.0, 5.0});
  nan[0].normalized.x() = std::numeric_limits<double>::quiet_NaN();
  EXPECT_FALSE(Triangulate(nan, options));
}

TEST(Triangulation, OptionsAreChecked) {
  EXPECT_THROW(TriangulationOptions{.min_depth_m = 0.0}.Validate(), Error);
  EXPECT_THROW(TriangulationOptions{.max_error_px = -1.0}.Validate(), Error);
  EXPECT_NO_THROW(TriangulationOptions{}.Validate());
}

}  // namespace
}  // namespace gluevo::vo
