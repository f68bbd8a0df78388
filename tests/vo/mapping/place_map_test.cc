// Maps of places: what is written is read, nothing else is, and frames are found in them.

#include "gluevo/vo/mapping/place_map.h"

#include <gtest/gtest.h>

#include <fstream>
#include <iterator>
#include <limits>
#include <random>

#include "gluevo/nn/input_file.h"
#include "gluevo/vo/geometry/manifold.h"
#include "gluevo/vo/mapping/loop_closer.h"
#include "gluevo/vo/mapping/place_map_export.h"
#include "message_of.h"
#include "place_map_layout.h"
#include "temporary_folder.h"
#include "vo/mapping/place_map_scene.h"

namespace gluevo::vo {
namespace {

namespace fs = std::filesystem;

std::string BytesOf(const PlaceMap& map) {
  const TemporaryFolder folder;
  WritePlaceMap(folder.path() / "a.map", map);
  std::ifstream stream(folder.path() / "a.map", std::ios::binary);
  return {std::istreambuf_iterator<char>(stream), {}};
}

PlaceMap Parse(const std::string& bytes) {
  return ParsePlaceMap(bytes.data(), bytes.size(), "a.map");
}

/// A file whose checksum is right, whatever its body.
std::string WithBody(const std::string& file, const std::string& body) {
  std::string bytes = file.substr(0, place_map::kMark.size() + 8);
  const uint64_t size = body.size();
  bytes.append(reinterpret_cast<const char*>(&size), sizeof(size));
  return bytes + nn::Sha256(body.data(), body.size()) + body;
}

TEST(PlaceMap, WhatIsWrittenIsRead) {
  const PlaceMap map = testing::RoundMap();
  ASSERT_GE(map.loops.size(), 3U);
  const PlaceMap read = Parse(BytesOf(map));
  EXPECT_EQ(read.features.network, "superpoint");
  EXPECT_EQ(read.features.source, "built-in");
  EXPECT_EQ(read.features.checksum, "12ab");
  EXPECT_EQ(read.rig.body_frame, map.rig.body_frame);
  EXPECT_TRUE(IsSameRig(read.rig, map.rig));
  ASSERT_EQ(read.keyframes.size(), map.keyframes.size());
  for (std::size_t i = 0; i < map.keyframes.size(); ++i) {
    const LoopKeyframe& a = map.keyframes[i];
    const LoopKeyframe& b = read.keyframes[i];
    EXPECT_EQ(a.timestamp_ns, b.timestamp_ns);
    EXPECT_EQ(a.segment, b.segment);
    EXPECT_EQ(a.motion.translation, b.motion.translation);
    EXPECT_EQ(a.motion.rotation.coeffs(), b.motion.rotation.coeffs());
    EXPECT_EQ(a.motion_covariance, b.motion_covariance);
    EXPECT_EQ(a.world_from_body.translation, b.world_from_body.translation);
    EXPECT_EQ(map.map_from_body[i].rotation.coeffs(), read.map_from_body[i].rotation.coeffs());
    ASSERT_EQ(a.features.size(), b.features.size());
    EXPECT_EQ(b.features.width, 752);
    // Half a step of 752 / 65535 pixels along each axis, and its square root of two.
    EXPECT_LT((a.features.keypoints - b.features.keypoints).rowwise().norm().maxCoeff(), 0.0082);
    for (int k = 0; k < a.features.size(); ++k) {
      EXPECT_GT(a.features.descriptors.row(k).dot(b.features.descriptors.row(k)), 0.9999F);
      EXPECT_EQ(a.keypoints[k].has_right, b.keypoints[k].has_right);
      EXPECT_NEAR(a.keypoints[k].inverse_depth, b.keypoints[k].inverse_depth, 1e-7);
      EXPECT_LT((a.keypoints[k].left - b.keypoints[k].left).norm(), 2e-5);
      EXPECT_LT((a.keypoints[k].right - b.keypoints[k].right).norm(), 2e-5);
    }
  }
  ASSERT_EQ(read.loops.size(), map.loops.size());
  for (std::size_t i = 0; i < map.loops.size(); ++i) {
    EXPECT_EQ(read.loops[i].candidate, map.loops[i].candidate);
    EXPECT_EQ(read.loops[i].query, map.loops[i].query);
    EXPECT_EQ(read.loops[i].inliers, map.loops[i].inliers);
    // Only half of it is written.
    EXPECT_TRUE(
        read.loops[i].measurement.covariance.isApprox(map.loops[i].measurement.covariance, 1e-12));
  }
}

TEST(PlaceMap, OfNothingIsReadToo) {
  const PlaceMap read = Parse(BytesOf({.rig = testing::SimulatedRig()}));
  EXPECT_TRUE(read.keyframes.empty());
  EXPECT_EQ(read.LargestPart(), 0);
}

TEST(PlaceMap, KeyframesStayBelowTheirSize) {
  PlaceMap map{.rig = testing::SimulatedRig()};
  LoopKeyframe keyframe;
  constexpr int kCount = 1000;
  keyframe.features.keypoints.setConstant(kCount, 2, 10.0F);
  keyframe.features.scores = Eigen::VectorXf::LinSpaced(kCount, 1.0F, 0.0F);
  keyframe.features.descriptors.setConstant(kCount, 256, 1.0F / 16.0F);
  keyframe.keypoints.resize(kCount);
  for (int i = 0; i < kCount; ++i) {
    keyframe.features.keypoints(i, 0) = static_cast<float>(i % 700);
    // The weakest half is what is worth keeping.
    keyframe.keypoints[i].inverse_depth = i >= kCount / 2 ? 0.5 : 0.0;
  }
  map.keyframes.push_back(keyframe);
  map.map_from_body.emplace_back();
  const std::string bytes = BytesOf(map);
  EXPECT_LT(bytes.size(), 120'000U);
  const PlaceMap read = Parse(bytes);
  ASSERT_GT(read.keyframes[0].features.size(), 400);
  for (const StereoKeypoint& keypoint : read.keyframes[0].keypoints) {
    EXPECT_EQ(keypoint.inverse_depth, 0.5);
  }
  // The strongest of those, in their order.
  EXPECT_NEAR(read.keyframes[0].features.keypoints(0, 0), 500.0F, 0.01F);
}

TEST(PlaceMap, ThatIsCutShortIsRefusedByName) {
  const std::string bytes = BytesOf(testing::SmallMap());
  for (std::size_t size = 0; size < bytes.size(); size += size < 200 ? 1 : 97) {
    const std::string message = MessageOf([&] { Parse(bytes.substr(0, size)); });
    EXPECT_TRUE(message.starts_with("a.map: ")) << size << ": " << message;
  }
  EXPECT_NE(MessageOf([&] { Parse(bytes + "x"); }).find("behind"), std::string::npos);
}

TEST(PlaceMap, ThatWasChangedIsRefused) {
  const std::string bytes = BytesOf(testing::SmallMap());
  for (std::size_t at = 0; at < bytes.size(); at += at < 200 ? 1 : 97) {
    std::string changed = bytes;
    changed[at] = static_cast<char>(changed[at] ^ 0x10);
    const std::string message = MessageOf([&] { Parse(changed); });
    EXPECT_TRUE(message.starts_with("a.map: ")) << at << ": " << message;
  }
}

TEST(PlaceMap, ThatLiesWithARightChecksumIsRefusedOrHarmless) {
  const std::string bytes = BytesOf(testing::SmallMap());
  const std::string body = bytes.substr(place_map::kHeaderSize);
  std::mt19937_64 generator(5);
  int refused = 0;
  for (std::size_t at = 0; at < body.size(); at += at < 1200 ? 1 : 211) {
    std::string changed = body;
    changed[at] = static_cast<char>(generator());
    const std::string message = MessageOf([&] { Parse(WithBody(bytes, changed)); });
    if (message != "no error") {
      EXPECT_TRUE(message.starts_with("a.map")) << at << ": " << message;
      ++refused;
    }
  }
  EXPECT_GT(refused, 100);
  // Cut short within, too.
  for (std::size_t size = 0; size < body.size(); size += size < 1200 ? 7 : 211) {
    EXPECT_NE(MessageOf([&] { Parse(WithBody(bytes, body.substr(0, size))); }), "no error");
  }
}

TEST(PlaceMap, ValuesThatNoMapHasAreRefused) {
  const auto refuses = [](const PlaceMap& map, const std::string& what) {
    const std::string message = MessageOf([&] { Parse(BytesOf(map)); });
    EXPECT_NE(message.find(what), std::string::npos) << message;
  };
  PlaceMap map = testing::SmallMap();
  map.map_from_body[1].translation.x() = std::numeric_limits<double>::quiet_NaN();
  refuses(map, "the pose of key frame 1 has a value that is not finite");
  map = testing::SmallMap();
  map.map_from_body[1].rotation.coeffs() *= 1.1;
  refuses(map, "unit length");
  map = testing::SmallMap();
  map.keyframes[1].motion_covariance(2, 2) = -1.0;
  refuses(map, "the covariance of key frame 1 is no covariance");
  map = testing::SmallMap();
  map.keyframes[1].timestamp_ns = map.keyframes[0].timestamp_ns;
  refuses(map, "key frame 1 is out of order");
  map = testing::SmallMap();
  map.keyframes[1].segment = 7;
  refuses(map, "out of order");
  map = testing::SmallMap();
  map.loops.push_back({.candidate = 1, .query = 0});
  refuses(map, "loop 0 names key frames");
  map = testing::SmallMap();
  map.keyframes[0].keypoints[3].inverse_depth = -1.0;
  refuses(map, "inverse depth");
}

TEST(PlaceMap, OfAnotherVersionOrKindIsRefused) {
  std::string bytes = BytesOf(testing::SmallMap());
  bytes[place_map::kMark.size()] = 9;
  EXPECT_NE(MessageOf([&] { Parse(bytes); }).find("version 9"), std::string::npos);
  EXPECT_NE(MessageOf([&] { Parse("\x89HDF\r\n"); }).find("is no map"), std::string::npos);
}

TEST(PlaceMap, OfOtherWeightsIsRefusedByName) {
  const PlaceMap map = testing::SmallMap();
  CheckMapFeatures(map, "a.map", map.features);
  const std::string message = MessageOf([&] {
    CheckMapFeatures(map, "a.map", {"superpoint", "mine.safetensors", "34cd"});
  });
  for (const char* const part : {"a.map", "built-in", "12ab", "mine.safetensors", "34cd"}) {
    EXPECT_NE(message.find(part), std::string::npos) << message;
  }
}

TEST(PlaceMap, IsWholeOrNotThere) {
  const TemporaryFolder folder;
  PlaceMap map = testing::SmallMap();
  WritePlaceMap(folder.path() / "a.map", map);
  EXPECT_NE(MessageOf([&] { WritePlaceMap(folder.path() / "none" / "a.map", map); }), "no error");
  EXPECT_EQ(std::distance(fs::directory_iterator(folder.path()), {}), 1);
  EXPECT_NE(MessageOf([&] { ReadPlaceMap(folder.path() / "b.map"); }).find("b.map"),
            std::string::npos);
}

// What the fuzzer begins with.
TEST(PlaceMap, EverySeedIsRead) {
  int read = 0;
  for (const auto& entry : fs::directory_iterator(fs::path(GLUEVO_TEST_DATA_DIR) / ".." / "fuzz" /
                                                  "corpus" / "place_map")) {
    EXPECT_EQ(MessageOf([&] { ReadPlaceMap(entry.path()); }), "no error");
    ++read;
  }
  EXPECT_GE(read, 3);
}

TEST(PlaceMap, ALaterRunComesBackToIt) {
  const PlaceMap map = Parse(BytesOf(testing::RoundMap()));
  LoopCloser closer = testing::RoundCloser();
  closer.Load(map.keyframes, map.loops);
  // Somewhere else, as its own odometry sees it.
  const Rigid3 elsewhere = {ExpSo3({0.0, 0.0, 2.0}), {5.0, 1.0, 0.0}};
  const int first = map.keyframes.back().segment + 1;
  for (int i = 0; i < 4; ++i) {
    LoopKeyframe keyframe = testing::RoundKeyframe(0.3 + 0.2 * i, i);
    keyframe.world_from_body = elsewhere * keyframe.world_from_body;
    keyframe.segment = first;
    if (i > 0) {
      keyframe.motion =
          closer.keyframes().back().world_from_body.Inverse() * keyframe.world_from_body;
    }
    keyframe.motion_covariance.diagonal() << 4e-4, 4e-4, 4e-4, 4e-5, 4e-5, 4e-5;
    closer.Add(std::move(keyframe));
  }
  const PlaceMap grown = MakePlaceMap(closer, closer.Optimized(), map.features);
  ASSERT_EQ(grown.keyframes.size(), map.keyframes.size() + 4);
  EXPECT_EQ(grown.Parts().back(), 0);
  for (int i = 0; i < 4; ++i) {
    EXPECT_LT((grown.map_from_body[map.keyframes.size() + i].translation -
               testing::RoundPlace(0.3 + 0.2 * i).translation)
                  .norm(),
              0.05);
  }
  // And what is read of that is what was written.
  EXPECT_EQ(Parse(BytesOf(grown)).loops.size(), grown.loops.size());
}

TEST(PlaceMap, ExportsItsPointsAndKeyframes) {
  const PlaceMap map = testing::RoundMap();
  const Map sparse = SparseMapOf(map);
  ASSERT_EQ(sparse.keyframes.size(), map.keyframes.size());
  ASSERT_GT(sparse.points.size(), 500U);
  for (const Map::Point& point : sparse.points) {
    // On the walls of the room, four metres from its middle; the map is as good as its poses.
    EXPECT_NEAR(point.point_in_world.cwiseAbs().maxCoeff(), 4.0, 0.3);
  }
  EXPECT_EQ(KeyframesOf(map, map.LargestPart()).size(), map.keyframes.size());
  EXPECT_TRUE(KeyframesOf(map, 5).empty());
}

}  // namespace
}  // namespace gluevo::vo
