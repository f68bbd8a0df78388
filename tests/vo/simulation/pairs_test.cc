#include "gluevo/vo/simulation/pairs.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <iterator>
#include <opencv2/calib3d.hpp>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "gluevo/nn/error.h"
#include "gluevo/vo/core/rigid3.h"
#include "gluevo/vo/io/hdf5_file.h"
#include "temporary_folder.h"

namespace gluevo::simulation {
namespace {

PairOptions Small() {
  PairOptions options;
  options.rooms = 2;
  options.width = 188;
  options.height = 120;
  options.depth = true;
  return options;
}

std::string Bytes(const std::filesystem::path& file) {
  std::ifstream stream(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(stream), {}};
}

TEST(SimulatePairsTest, BytesDependOnTheSeedAndNotOnTheThreads) {
  const TemporaryFolder folder;
  PairOptions options = Small();
  options.threads = 1;
  SimulatePairs(options, folder.path() / "one");
  options.threads = 2;
  std::vector<int> done;
  SimulatePairs(options, folder.path() / "two", [&](int rooms, int all) {
    done.push_back(rooms);
    EXPECT_EQ(all, 2);
  });
  EXPECT_EQ(done, (std::vector<int>{1, 2}));
  options.seed = 2;
  SimulatePairs(options, folder.path() / "other");
  const std::string one = Bytes(folder.path() / "one" / "rooms_00000.h5");
  EXPECT_GT(one.size(), 300'000U);
  EXPECT_TRUE(one == Bytes(folder.path() / "two" / "rooms_00000.h5"));
  EXPECT_FALSE(one == Bytes(folder.path() / "other" / "rooms_00000.h5"));
}

/// A view's camera in OpenCV's terms.
struct View {
  cv::Matx33d matrix;
  std::vector<double> distortion;
  vo::Rigid3 world_from_cam;
};

std::vector<View> ReadViews(const vo::internal::H5InputFile& file, const std::string& room) {
  const std::vector<float> cameras = file.ReadFloats(room + "/camera");
  const std::vector<float> poses = file.ReadFloats(room + "/world_from_cam");
  std::vector<View> views;
  for (std::size_t i = 0; i < poses.size() / 7; ++i) {
    const float* const c = &cameras[8 * i];
    const float* const p = &poses[7 * i];
    View view;
    view.matrix = {c[0], 0, c[2], 0, c[1], c[3], 0, 0, 1};
    view.distortion.assign(c + 4, c + 8);
    view.world_from_cam.translation = {p[0], p[1], p[2]};
    view.world_from_cam.rotation = Eigen::Quaterniond(p[6], p[3], p[4], p[5]).normalized();
    views.push_back(view);
  }
  return views;
}

// Depth maps and OpenCV's camera model say the same as the listed correspondences.
TEST(SimulatePairsTest, CorrespondencesAgreeWithDepthsAndCameras) {
  const TemporaryFolder folder;
  SimulatePairs(Small(), folder.path() / "out");
  const vo::internal::H5InputFile file(folder.path() / "out" / "rooms_00000.h5");
  std::set<std::pair<int, int>> stereo;
  int compared = 0;
  for (const std::string room : {"room_000000", "room_000001"}) {
    EXPECT_EQ(file.ShapeOf(room + "/images", 3, 1 << 20), (std::vector<int64_t>{8, 120, 188}));
    const std::vector<View> views = ReadViews(file, room);
    const std::vector<float> depth = file.ReadFloats(room + "/depth");
    const std::vector<float> grid = file.ReadFloats(room + "/grid");
    const std::vector<float> overlap = file.ReadFloats(room + "/overlap");
    const std::vector<float> seen = file.ReadFloats(room + "/correspondences");
    const std::vector<int> pairs = file.ReadIntegers(room + "/pairs");
    EXPECT_GE(file.ShapeOf(room + "/boxes", 2, 1000)[0], 5);
    const std::size_t points = grid.size() / 2;
    ASSERT_EQ(seen.size(), overlap.size() * points * 2);
    ASSERT_EQ(pairs.size(), overlap.size() * 2);
    for (std::size_t pair = 0; pair < overlap.size(); ++pair) {
      const int first = pairs[2 * pair];
      const int second = pairs[2 * pair + 1];
      ASSERT_TRUE(first >= 0 && first < 8 && second >= 0 && second < 8 && first != second);
      if (second == first + 1 && first % 2 == 0) stereo.insert({first, second});
      std::size_t visible = 0;
      for (std::size_t i = 0; i < points; ++i) {
        const float* const pixel = &seen[2 * (pair * points + i)];
        if (pixel[0] < -0.9F) continue;
        ++visible;
        const auto x = static_cast<int>(grid[2 * i]);
        const auto y = static_cast<int>(grid[2 * i + 1]);
        std::vector<cv::Point2d> rays;
        cv::undistortPoints(
            std::vector<cv::Point2d>{{static_cast<double>(x), static_cast<double>(y)}}, rays,
            views[first].matrix, views[first].distortion, cv::noArray(), cv::noArray(),
            cv::TermCriteria(cv::TermCriteria::COUNT, 50, 0.0));
        const double z = depth[(static_cast<std::size_t>(first) * 120 + y) * 188 + x];
        const Eigen::Vector3d in_second =
            views[second].world_from_cam.Inverse() *
            (views[first].world_from_cam * (z * Eigen::Vector3d(rays[0].x, rays[0].y, 1.0)));
        std::vector<cv::Point2d> projected;
        cv::projectPoints(std::vector<cv::Point3d>{{in_second.x(), in_second.y(), in_second.z()}},
                          cv::Vec3d(0, 0, 0), cv::Vec3d(0, 0, 0), views[second].matrix,
                          views[second].distortion, projected);
        EXPECT_NEAR(projected[0].x, pixel[0], 0.02);
        EXPECT_NEAR(projected[0].y, pixel[1], 0.02);
        ++compared;
      }
      EXPECT_NEAR(static_cast<double>(visible) / static_cast<double>(points), overlap[pair], 1e-6);
      EXPECT_GE(overlap[pair], 0.1);
    }
  }
  EXPECT_GT(compared, 2000);
  EXPECT_GE(stereo.size(), 3U);
}

TEST(SimulatePairsTest, RefusesOptionsOutOfRange) {
  const TemporaryFolder folder;
  PairOptions options = Small();
  options.rooms = 0;
  EXPECT_THROW(SimulatePairs(options, folder.path() / "out"), Error);
  options = Small();
  options.height = 20;
  EXPECT_THROW(SimulatePairs(options, folder.path() / "out"), Error);
  EXPECT_TRUE(std::filesystem::is_empty(folder.path()));
}

}  // namespace
}  // namespace gluevo::simulation
