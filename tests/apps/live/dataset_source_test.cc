#include "dataset_source.h"

#include <gtest/gtest.h>

#include <fstream>
#include <opencv2/imgcodecs.hpp>

#include "temporary_folder.h"

namespace gluevo::apps {
namespace {

constexpr int64_t kMs = 1'000'000;
constexpr int64_t kStep = 50 * kMs;
constexpr int64_t kFirst = 7'000'000 * kMs;

// A clock that stands still but when somebody sleeps, or the test says so.
struct TestClock {
  int64_t now_ns = 123 * kMs;
  SourceClock Source() {
    return {[this] { return now_ns; },
            [this](int64_t until_ns) { now_ns = std::max(now_ns, until_ns); }};
  }
};

class DatasetSourceTest : public testing::Test {
 protected:
  // Images whose gray value is their number; readings every 20 ms, 5 ms beside the frames.
  vo::Dataset MakeDataset(int frames, bool has_readings) const {
    vo::Dataset dataset;
    for (vo::Camera& camera : dataset.rig.cameras) {
      camera.width = 16;
      camera.height = 8;
    }
    for (int i = 0; i < frames; ++i) {
      const std::string path = (folder_.path() / (std::to_string(i) + ".png")).string();
      cv::imwrite(path, cv::Mat(8, 16, CV_8UC1, cv::Scalar(i)));
      dataset.entries.push_back({kFirst + i * kStep, {path, path}});
    }
    if (has_readings) {
      dataset.imu.emplace();
      for (int i = -5; i < frames * 3; ++i) {
        dataset.imu->samples.push_back({kFirst + i * 20 * kMs + 5 * kMs, {}, {}});
      }
    }
    return dataset;
  }
  TemporaryFolder folder_;
};

TEST_F(DatasetSourceTest, ImagesComeAtTheirTimes) {
  for (const double pace : {1.0, 2.0, 0.5}) {
    const vo::Dataset dataset = MakeDataset(5, false);
    TestClock clock;
    const int64_t begin = clock.now_ns;
    DatasetSource source(dataset, {.pace = pace}, clock.Source());
    int frames = 0;
    for (SourceEvent event = source.Next(); !event.is_end; event = source.Next()) {
      if (event.frame) {
        EXPECT_EQ(event.frame->timestamp_ns, kFirst + frames * kStep);
        EXPECT_EQ(event.frame->images[0].at<uchar>(0, 0), frames);
        EXPECT_EQ(source.Now(), event.frame->timestamp_ns);
        EXPECT_EQ(clock.now_ns - begin, static_cast<int64_t>(frames * kStep / pace));
        ++frames;
      }
    }
    EXPECT_EQ(frames, 5);
    EXPECT_EQ(source.counts().frames_late, 0);
  }
}

TEST_F(DatasetSourceTest, WhenReadingIsTooLateImagesArePassedOver) {
  const vo::Dataset dataset = MakeDataset(10, false);
  TestClock clock;
  DatasetSource source(dataset, {}, clock.Source());
  std::vector<int> seen;
  for (SourceEvent event = source.Next(); !event.is_end; event = source.Next()) {
    if (event.frame) {
      seen.push_back(event.frame->images[0].at<uchar>(0, 0));
      clock.now_ns += seen.size() == 2 ? 170 * kMs : 0;  // Something else took its time.
    }
  }
  // When the third would be read the fifth has happened.
  EXPECT_EQ(seen, (std::vector<int>{0, 1, 4, 5, 6, 7, 8, 9}));
  EXPECT_EQ(source.counts().frames_late, 2);
}

TEST_F(DatasetSourceTest, EverySecondRoundIsBackwards) {
  const vo::Dataset dataset = MakeDataset(4, false);
  TestClock clock;
  DatasetSource source(dataset, {.rounds = 3}, clock.Source());
  EXPECT_EQ(source.frames(), 10U);
  std::vector<int> seen;
  for (SourceEvent event = source.Next(); !event.is_end; event = source.Next()) {
    if (event.frame) {
      EXPECT_EQ(event.frame->timestamp_ns, kFirst + static_cast<int64_t>(seen.size()) * kStep);
      seen.push_back(event.frame->images[0].at<uchar>(0, 0));
    }
  }
  EXPECT_EQ(seen, (std::vector<int>{0, 1, 2, 3, 2, 1, 0, 1, 2, 3}));
}

TEST_F(DatasetSourceTest, ReadingsComeInOrderOfTimeWithOneBeyondTheFrame) {
  const vo::Dataset dataset = MakeDataset(4, true);
  TestClock clock;
  DatasetSource source(dataset, {.gives_readings = true}, clock.Source());
  int64_t newest_reading = 0;
  int frames = 0;
  int readings = 0;
  for (SourceEvent event = source.Next(); !event.is_end; event = source.Next()) {
    for (const vo::ImuSample& reading : event.readings) {
      EXPECT_GT(reading.timestamp_ns, newest_reading);
      EXPECT_LE(reading.timestamp_ns, source.Now());
      newest_reading = reading.timestamp_ns;
      ++readings;
    }
    if (event.frame) {
      EXPECT_LE(newest_reading, event.frame->timestamp_ns);
      EXPECT_LT(event.frame->timestamp_ns - newest_reading, 20 * kMs);
      EXPECT_EQ(source.Now(), event.frame->timestamp_ns);
      ++frames;
    }
  }
  EXPECT_EQ(frames, 4);
  EXPECT_GT(newest_reading, kFirst + 3 * kStep);
  EXPECT_EQ(readings, 10);  // From the one before the first frame to the one beyond the last.
}

TEST_F(DatasetSourceTest, AnImageThatCannotBeReadIsTold) {
  const vo::Dataset dataset = MakeDataset(3, false);
  std::ofstream(dataset.entries[1].images[0]) << "no image";
  TestClock clock;
  DatasetSource source(dataset, {}, clock.Source());
  int frames = 0;
  std::vector<std::size_t> left_out;
  for (SourceEvent event = source.Next(); !event.is_end; event = source.Next()) {
    frames += event.frame ? 1 : 0;
    if (!event.left_out.empty()) {
      left_out.push_back(event.frame_index);
      EXPECT_NE(event.left_out.find("1.png"), std::string::npos);
    }
  }
  EXPECT_EQ(frames, 2);
  EXPECT_EQ(left_out, std::vector<std::size_t>{1});
}

}  // namespace
}  // namespace gluevo::apps
