// Frames are found in a map, each by itself, or are said not to be.

#include "gluevo/vo/mapping/map_localizer.h"

#include <gtest/gtest.h>

#include <memory>
#include <numbers>

#include "gluevo/vo/geometry/manifold.h"
#include "message_of.h"
#include "vo/mapping/place_map_scene.h"

namespace gluevo::vo {
namespace {

// An image here is the place that it shows: its four numbers are the angle, the shift, and which
// camera sees it.
cv::Mat ImageAt(double angle, double shift, int camera) {
  cv::Mat image(1, 3, CV_64F);
  image.at<double>(0, 0) = angle;
  image.at<double>(0, 1) = shift;
  image.at<double>(0, 2) = camera;
  return image;
}

Rigid3 PlaceOf(double angle, double shift) {
  Rigid3 place = testing::RoundPlace(angle);
  place.translation.z() += shift;
  return place;
}

class SceneExtractor final : public FeatureExtractor {
 public:
  explicit SceneExtractor(std::vector<Eigen::Vector3d> points) : points_(std::move(points)) {}
  nn::Features Extract(const cv::Mat& image) override {
    const testing::StereoFeatures seen = testing::Look(
        testing::SimulatedRig(), points_, PlaceOf(image.at<double>(0, 0), image.at<double>(0, 1)));
    return image.at<double>(0, 2) == 0.0 ? seen.left : seen.right;
  }
  nn::Features Describe(const cv::Mat& /*image*/, const nn::Features::Points& /*pixels*/) override {
    return {};
  }

 private:
  std::vector<Eigen::Vector3d> points_;
};

MapLocalizer MakeLocalizer(const std::vector<Eigen::Vector3d>& world,
                           const LocalizationOptions& options = {}) {
  static const PlaceMap map = testing::RoundMap();
  return {map, testing::RoundCodebook(), std::make_shared<SceneExtractor>(world),
          MakeNearestNeighborMatcher(), options};
}

StereoFrame FrameAt(double angle, double shift) {
  return {0, {ImageAt(angle, shift, 0), ImageAt(angle, shift, 1)}};
}

double ErrorOf(const Localization& result, double angle, double shift) {
  return Minus(result.map_from_body, PlaceOf(angle, shift)).norm();
}

TEST(MapLocalizer, FindsPairsBetweenItsKeyframes) {
  const MapLocalizer localizer = MakeLocalizer(testing::RoundRoom());
  for (const double angle : {0.2, 1.7, 3.0, 5.5}) {
    const Localization result = localizer.Locate(FrameAt(angle, 0.1), testing::SimulatedRig());
    ASSERT_TRUE(result.is_found) << angle << ": " << result.reason;
    EXPECT_EQ(result.part, 0);
    EXPECT_GE(result.inliers, 30);
    EXPECT_LT(ErrorOf(result, angle, 0.1), 0.01) << angle;
    EXPECT_GT(result.position_sigma_m, 0.0);
  }
}

TEST(MapLocalizer, FindsSingleLeftImages) {
  const MapLocalizer localizer = MakeLocalizer(testing::RoundRoom());
  StereoFrame frame = FrameAt(1.7, 0.1);
  frame.images[1] = cv::Mat();
  const Localization result = localizer.Locate(frame, testing::SimulatedRig());
  ASSERT_TRUE(result.is_found) << result.reason;
  EXPECT_LT(ErrorOf(result, 1.7, 0.1), 0.01);
  // What the right image would have told makes it less certain.
  EXPECT_GT(result.position_sigma_m,
            localizer.Locate(FrameAt(1.7, 0.1), testing::SimulatedRig()).position_sigma_m);
}

TEST(MapLocalizer, ARigOfItsOwnMayTakeTheFrame) {
  // The map's body is the camera's here, and elsewhere the frame's.
  StereoRig rig = testing::SimulatedRig();
  const Rigid3 moved = {ExpSo3({0.0, 0.1, 0.2}), {0.1, -0.2, 0.3}};
  for (Rigid3& body_from_cam : rig.body_from_cam) {
    body_from_cam = moved * body_from_cam;
  }
  const MapLocalizer localizer = MakeLocalizer(testing::RoundRoom());
  Localization result = localizer.Locate(FrameAt(1.7, 0.1), rig);
  ASSERT_TRUE(result.is_found) << result.reason;
  result.map_from_body = result.map_from_body * moved;
  EXPECT_LT(ErrorOf(result, 1.7, 0.1), 0.01);
}

TEST(MapLocalizer, AnotherRoomIsNotFound) {
  // Its points have the same descriptors in other places: matches abound, and no pose fits them.
  const MapLocalizer localizer = MakeLocalizer(testing::RoomPoints(1500, 4.0, 77));
  for (const double angle : {0.2, 1.7, 3.0}) {
    const Localization result = localizer.Locate(FrameAt(angle, 0.0), testing::SimulatedRig());
    EXPECT_FALSE(result.is_found);
    EXPECT_FALSE(result.reason.empty());
  }
}

TEST(MapLocalizer, APlaceThatIsThereTwiceIsNotFound) {
  // The same room again, ten metres away.
  PlaceMap map = testing::RoundMap();
  const std::size_t count = map.keyframes.size();
  for (std::size_t i = 0; i < count; ++i) {
    map.keyframes.push_back(map.keyframes[i]);
    map.map_from_body.push_back(map.map_from_body[i]);
    map.map_from_body.back().translation.x() += 10.0;
  }
  const MapLocalizer localizer(map, testing::RoundCodebook(),
                               std::make_shared<SceneExtractor>(testing::RoundRoom()),
                               MakeNearestNeighborMatcher(), {});
  const Localization result = localizer.Locate(FrameAt(0.2, 0.1), testing::SimulatedRig());
  EXPECT_FALSE(result.is_found);
  EXPECT_EQ(result.reason, "two places fit");
}

TEST(MapLocalizer, WhatIsTooUncertainIsNotFound) {
  const MapLocalizer localizer =
      MakeLocalizer(testing::RoundRoom(), {.max_position_sigma_m = 1e-6});
  const Localization result = localizer.Locate(FrameAt(0.2, 0.1), testing::SimulatedRig());
  EXPECT_FALSE(result.is_found);
  EXPECT_EQ(result.reason, "the pose is too uncertain");
}

TEST(MapLocalizer, AnEmptyMapHasNothing) {
  const MapLocalizer localizer({.rig = testing::SimulatedRig()}, testing::RoundCodebook(),
                               std::make_shared<SceneExtractor>(testing::RoundRoom()),
                               MakeNearestNeighborMatcher(), {});
  const Localization result = localizer.Locate(FrameAt(0.2, 0.0), testing::SimulatedRig());
  EXPECT_FALSE(result.is_found);
  EXPECT_EQ(result.reason, "the map is empty");
}

TEST(MapLocalizer, OptionsOutOfRangeAreNamed) {
  const std::string message =
      MessageOf([] { MakeLocalizer(testing::RoundRoom(), {.max_candidates = 0}); });
  EXPECT_NE(message.find("--candidates"), std::string::npos) << message;
}

}  // namespace
}  // namespace gluevo::vo
