// Ground truth of a data set: named or found, with times or a row a frame, and what does not fit.

#include "groundtruth.h"

#include <gtest/gtest.h>

#include <fstream>
#include <string>

#include "gluevo/nn/error.h"
#include "temporary_folder.h"

namespace gluevo::vo {
namespace {

namespace fs = std::filesystem;

class GroundtruthTest : public testing::Test {
 protected:
  fs::path Write(const std::string& text) const {
    const fs::path path = folder_.path() / "truth.txt";
    std::ofstream(path) << text;
    return path;
  }
  static Dataset ThreeFrames() {
    Dataset dataset;
    dataset.entries = {{5, {}}, {7, {}}, {9, {}}};
    return dataset;
  }
  /// KITTI's form, x being the row.
  static std::string Rows(int count) {
    std::string text;
    for (int i = 0; i < count; ++i) {
      text += "1 0 0 " + std::to_string(i) + " 0 1 0 0 0 0 1 0\n";
    }
    return text;
  }

 private:
  TemporaryFolder folder_;
};

TEST_F(GroundtruthTest, RowsBelongToTheFrames) {
  Dataset dataset = ThreeFrames();
  DatasetOptions options;
  options.groundtruth = Write(Rows(3));
  AddGroundtruth(options, {}, {}, dataset);
  ASSERT_EQ(dataset.groundtruth->size(), 3U);
  EXPECT_EQ(dataset.groundtruth->at(2).timestamp_ns, 9);
  EXPECT_EQ(dataset.groundtruth->at(2).world_from_body.translation.x(), 2.0);
  EXPECT_TRUE(dataset.warnings.empty());
  // Of other numbers nobody knows which row is whose.
  options.groundtruth = Write(Rows(4));
  EXPECT_THROW(AddGroundtruth(options, {}, {}, dataset), Error);
}

TEST_F(GroundtruthTest, RowsBelongToTimesOfTheSequence) {
  for (const int rows : {2, 3, 5}) {
    Dataset dataset = ThreeFrames();
    AddGroundtruth({}, {"nowhere", Write(Rows(rows))}, {{10, 20, 30}, {}}, dataset);
    ASSERT_TRUE(dataset.groundtruth);
    EXPECT_EQ(dataset.groundtruth->size(), std::min<std::size_t>(3, rows));
    EXPECT_EQ(dataset.groundtruth->at(1).timestamp_ns, 20);
    ASSERT_EQ(dataset.warnings.size(), rows == 3 ? 0U : 1U);
    if (rows == 5) {
      EXPECT_NE(dataset.warnings[0].find("5 poses for 3 times"), std::string::npos)
          << dataset.warnings[0];
    }
  }
}

TEST_F(GroundtruthTest, NumberedRowsBelongToFrames) {
  Dataset dataset = ThreeFrames();
  const fs::path truth = Write("1 1 0 0 4 0 1 0 0 0 0 1 0\n7 1 0 0 5 0 1 0 0 0 0 1 0\n");
  AddGroundtruth({}, {truth}, {}, dataset);
  ASSERT_EQ(dataset.groundtruth->size(), 1U);
  EXPECT_EQ(dataset.groundtruth->front().timestamp_ns, 7);
  AddGroundtruth({}, {truth}, {{}, {10, 20, 30, 40, 50, 60, 70, 80}}, dataset);
  ASSERT_EQ(dataset.groundtruth->size(), 2U);
  EXPECT_EQ(dataset.groundtruth->back().timestamp_ns, 80);
  EXPECT_EQ(dataset.groundtruth->back().world_from_body.translation.x(), 5.0);
}

TEST_F(GroundtruthTest, WhatNobodyNamedStopsNothing) {
  Dataset dataset = ThreeFrames();
  const fs::path broken = Write("1,2,3\n");
  AddGroundtruth({}, {broken}, {}, dataset);
  EXPECT_FALSE(dataset.groundtruth);
  ASSERT_EQ(dataset.warnings.size(), 1U);
  EXPECT_NE(dataset.warnings[0].find("truth.txt:1: "), std::string::npos) << dataset.warnings[0];
  DatasetOptions options;
  options.groundtruth = broken;
  EXPECT_THROW(AddGroundtruth(options, {}, {}, dataset), Error);
}

TEST_F(GroundtruthTest, HowItWasReadIsAWarning) {
  Dataset dataset = ThreeFrames();
  AddGroundtruth({}, {Write("1 0 0 0 0 0 0 1\n2 nan 0 0 0 0 0 1\n")}, {}, dataset);
  EXPECT_EQ(dataset.groundtruth->size(), 1U);
  ASSERT_EQ(dataset.warnings.size(), 1U);
  EXPECT_NE(dataset.warnings[0].find("1 row (first in line 2)"), std::string::npos);
}

}  // namespace
}  // namespace gluevo::vo
