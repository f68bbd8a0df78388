#include "gluevo/vo/mapping/place_codebook.h"

#include <gtest/gtest.h>

#include "gluevo/nn/error.h"
#include "gluevo/vo/mapping/place_training.h"
#include "temporary_folder.h"
#include "vo/mapping/loop_scene.h"

namespace gluevo::vo {
namespace {

// Random descriptors, the same for the same seed.
nn::Features Image(std::size_t first, int count) {
  nn::Features features;
  features.keypoints.setZero(count, 2);
  features.descriptors.resize(count, testing::DescriptorOf(0).size());
  for (int i = 0; i < count; ++i) {
    features.descriptors.row(i) = testing::DescriptorOf(first + static_cast<std::size_t>(i));
  }
  return features;
}

PlaceCodebook Trained() {
  return TrainPlaceCodebook({Image(0, 300), Image(300, 300)}, "abc", {.centres = 8});
}

TEST(PlaceCodebook, TrainingIsTheSameEachTime) {
  EXPECT_EQ(Trained().centres(), Trained().centres());
}

TEST(PlaceCodebook, CentresAreMeansOfWhatIsNearThem) {
  // Two bundles of descriptors: two centres, one in each.
  nn::Features bundles = Image(0, 40);
  for (int i = 0; i < bundles.size(); ++i) {
    bundles.descriptors.row(i) =
        testing::DescriptorOf(i % 2) + 0.1F * bundles.descriptors.row(i).transpose();
  }
  const PlaceCodebook codebook = TrainPlaceCodebook({bundles}, "", {.centres = 2});
  for (int bundle = 0; bundle < 2; ++bundle) {
    const Eigen::VectorXf target = testing::DescriptorOf(static_cast<std::size_t>(bundle));
    const float nearest = std::min((codebook.centres().row(0).transpose() - target).norm(),
                                   (codebook.centres().row(1).transpose() - target).norm());
    EXPECT_LT(nearest, 0.1F);
  }
}

TEST(PlaceCodebook, ImagesThatShareMostPointsAreAlike) {
  const PlaceCodebook codebook = Trained();
  const Eigen::VectorXf place = codebook.Describe(Image(1000, 200));
  EXPECT_NEAR(place.norm(), 1.0F, 1e-5F);
  const float same = place.dot(codebook.Describe(Image(1040, 200)));
  const float other = place.dot(codebook.Describe(Image(2000, 200)));
  EXPECT_GT(same, 0.5F);
  EXPECT_LT(other, 0.5F * same);
}

TEST(PlaceCodebook, AnImageWithoutKeypointsIsLikeNothing) {
  EXPECT_EQ(Trained().Describe(Image(0, 0)).norm(), 0.0F);
}

TEST(PlaceCodebook, FilesComeBackAsTheyWent) {
  const TemporaryFolder folder;
  const auto path = folder.path() / "places.safetensors";
  WritePlaceCodebook(path, Trained());
  const PlaceCodebook read = PlaceCodebook::FromWeights(nn::ReadWeights(path));
  EXPECT_EQ(read.centres(), Trained().centres());
  EXPECT_EQ(read.of_weights(), "abc");
}

TEST(PlaceCodebook, WhatDoesNotFitIsRefused) {
  EXPECT_THROW(TrainPlaceCodebook({Image(0, 7)}, "", {.centres = 8}), Error);
  nn::Features narrow = Image(0, 9);
  narrow.descriptors.conservativeResize(9, 16);
  EXPECT_THROW(Trained().Describe(narrow), Error);
  EXPECT_THROW(TrainPlaceCodebook({Image(0, 9), narrow}, "", {.centres = 8}), Error);
  EXPECT_THROW(PlaceCodebook::FromWeights(nn::OpenSuperPointWeights()), Error);
}

}  // namespace
}  // namespace gluevo::vo
