#include "gluevo/vo/frontend/feature_files.h"

#include <gtest/gtest.h>
#include <sys/stat.h>

#include <filesystem>
#include <fstream>

#include "gluevo/nn/error.h"
#include "temporary_folder.h"

namespace gluevo::vo {
namespace {

nn::Features SomeFeatures(int count) {
  nn::Features features;
  features.width = 752;
  features.height = 480;
  features.keypoints.resize(count, 2);
  features.scores.resize(count);
  features.descriptors.resize(count, 4);
  for (int i = 0; i < count; ++i) {
    features.keypoints.row(i) << static_cast<float>(i) + 0.5F, 3.0F;
    features.scores[i] = 0.1F * static_cast<float>(i);
    features.descriptors.row(i) << 1.0F, static_cast<float>(i), 0.0F, -1.0F;
  }
  return features;
}

TEST(FeatureFilesTest, WhatIsWrittenIsRead) {
  const TemporaryFolder folder;
  const auto path = folder.path() / "features.h5";
  FeatureWriter writer(path);
  writer.Add("cam0/1.png", SomeFeatures(3));
  writer.Add("empty.png", SomeFeatures(0));
  EXPECT_FALSE(std::filesystem::exists(path));
  writer.Finish();
  const FeatureReader reader(path);
  EXPECT_EQ(reader.images(), (std::vector<std::string>{"cam0/1.png", "empty.png"}));
  const nn::Features read = reader.Read("cam0/1.png");
  EXPECT_EQ(read.keypoints, SomeFeatures(3).keypoints);
  EXPECT_EQ(read.scores, SomeFeatures(3).scores);
  EXPECT_EQ(read.descriptors, SomeFeatures(3).descriptors);
  EXPECT_EQ(read.width, 752);
  EXPECT_EQ(read.height, 480);
  EXPECT_EQ(reader.Read("empty.png").size(), 0);
  EXPECT_THROW(reader.Read("other.png"), Error);
}

TEST(FeatureFilesTest, MatchesKeepTheirOrderAndNames) {
  const TemporaryFolder folder;
  const auto path = folder.path() / "matches.h5";
  {
    MatchWriter writer(path);
    writer.Add("a/0.png", "b/1.png", {{1, -1, 0}, {0.5F, 0.0F, 0.25F}});
    writer.Finish();
  }
  const MatchReader reader(path);
  EXPECT_EQ(reader.pairs(),
            (std::vector<std::pair<std::string, std::string>>{{"a-0.png", "b-1.png"}}));
  const nn::Matches matches = reader.Read("a/0.png", "b/1.png");
  EXPECT_EQ(matches.matches0, (std::vector<int>{1, -1, 0}));
  EXPECT_EQ(matches.scores0, (std::vector<float>{0.5F, 0.0F, 0.25F}));
}

TEST(FeatureFilesTest, AnUnfinishedFileLeavesNothing) {
  const TemporaryFolder folder;
  {
    FeatureWriter writer(folder.path() / "features.h5");
    writer.Add("a.png", SomeFeatures(2));
  }
  EXPECT_TRUE(std::filesystem::is_empty(folder.path()));
}

TEST(FeatureFilesTest, TheyDoNotTakeThePlaceOfWhatIsNoFile) {
  const TemporaryFolder folder;
  const auto pipe = folder.path() / "pipe";
  ASSERT_EQ(mkfifo(pipe.c_str(), 0600), 0);
  EXPECT_THROW(MatchWriter{pipe}, Error);
  EXPECT_TRUE(std::filesystem::is_fifo(pipe));
}

TEST(FeatureFilesTest, BrokenFilesAreNamed) {
  const TemporaryFolder folder;
  const auto path = folder.path() / "broken.h5";
  std::ofstream(path) << "not HDF5";
  for (const auto& file : {path, folder.path() / "absent.h5"}) {
    try {
      const FeatureReader reader(file);
      FAIL();
    } catch (const Error& error) {
      EXPECT_NE(std::string(error.what()).find(file.string()), std::string::npos);
    }
  }
}

}  // namespace
}  // namespace gluevo::vo
