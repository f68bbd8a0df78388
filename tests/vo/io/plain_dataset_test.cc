// Data sets of anybody's making: names, times and folders as people have them.

#include <gtest/gtest.h>

#include <fstream>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <string>
#include <vector>

#include "gluevo/nn/error.h"
#include "gluevo/vo/io/dataset.h"
#include "message_of.h"
#include "temporary_folder.h"

namespace gluevo::vo {
namespace {

namespace fs = std::filesystem;
using Names = std::vector<std::string>;
using Times = std::vector<int64_t>;

constexpr int64_t kSecond = 1'000'000'000;

class PlainDatasetTest : public testing::Test {
 protected:
  fs::path root() const { return folder_.path() / "data"; }

  static void WriteText(const fs::path& path, const std::string& text) {
    fs::create_directories(path.parent_path());
    std::ofstream(path, std::ios::binary) << text;
  }
  static void WriteImage(const fs::path& path) {
    fs::create_directories(path.parent_path());
    ASSERT_TRUE(cv::imwrite(path.string(), cv::Mat(24, 32, CV_8UC1, cv::Scalar(9))));
  }
  void Make(const Names& left, const Names& right, const std::string& left_folder = "left",
            const std::string& right_folder = "right") const {
    fs::remove_all(root());
    for (const std::string& name : left) {
      WriteImage(root() / left_folder / name);
    }
    for (const std::string& name : right) {
      WriteImage(root() / right_folder / name);
    }
  }
  Dataset Open(const DatasetOptions& asked = {}) const {
    DatasetOptions options = asked;
    options.calibration = folder_.path() / "camchain.yaml";
    const std::string camera =
        "  camera_model: pinhole\n  distortion_model: none\n  intrinsics: [20, 20, 16, 12]\n"
        "  resolution: [32, 24]\n";
    WriteText(*options.calibration,
              "cam0:\n" + camera +
                  "cam1:\n  T_cn_cnm1:\n  - [1.0, 0.0, 0.0, -0.1]\n  - [0.0, 1.0, 0.0, 0.0]\n"
                  "  - [0.0, 0.0, 1.0, 0.0]\n  - [0.0, 0.0, 0.0, 1.0]\n" +
                  camera);
    return OpenDataset(root(), options);
  }
  static Times TimesOf(const Dataset& dataset) {
    Times times;
    for (const Dataset::Entry& entry : dataset.entries) {
      times.push_back(entry.timestamp_ns);
    }
    return times;
  }
  Times TimesOf(const Names& names) const {
    Make(names, names);
    return TimesOf(Open());
  }
  std::string ErrorOf(const DatasetOptions& options = {}) const {
    return MessageOf([&] { Open(options); });
  }
  static std::string All(const std::vector<std::string>& sentences) {
    std::string all;
    for (const std::string& sentence : sentences) {
      all += sentence + '\n';
    }
    return all;
  }
  static void ExpectHas(const std::string& text, const Names& parts) {
    for (const std::string& part : parts) {
      EXPECT_NE(text.find(part), std::string::npos) << "\"" << part << "\" in: " << text;
    }
  }

 private:
  TemporaryFolder folder_;
};

TEST_F(PlainDatasetTest, KnowsTheUnitOfStampsInNames) {
  const Times tenths = {1700000000 * kSecond, 1700000000 * kSecond + 100000000};
  EXPECT_EQ(TimesOf(Names{"1700000000000000000.png", "1700000000100000000.png"}), tenths);
  EXPECT_EQ(Open().notes.size(), 0U);
  EXPECT_EQ(TimesOf(Names{"1700000000000000.png", "1700000000100000.png"}), tenths);
  ExpectHas(All(Open().notes), {"microseconds"});
  EXPECT_EQ(TimesOf(Names{"1700000000000.png", "1700000000100.png"}), tenths);
  ExpectHas(All(Open().notes), {"milliseconds"});
  EXPECT_EQ(TimesOf(Names{"1700000000.0.png", "1700000000.1.png"}), tenths);
  EXPECT_EQ(TimesOf(Names{"1700000000_000000000.png", "1700000000_100000000.png"}), tenths);
  ExpectHas(All(Open().notes), {"seconds and nanoseconds"});
  // Not padded with zeros, as some write them.
  EXPECT_EQ(TimesOf(Names{"1700000000_0.png", "1700000000_100000000.png"}), tenths);
  EXPECT_EQ(TimesOf(Names{"1700000000-000000.png", "1700000000-100000.png"}), tenths);
  EXPECT_EQ(TimesOf(Names{"cam_1700000000000.5.png", "cam_1700000000100.5.png"}).at(1),
            1700000000 * kSecond + 100500000);
  // Of clocks that count from the start of a camera, the step tells.
  EXPECT_EQ(TimesOf(Names{"5000000.png", "5050000.png", "5100000.png"}),
            (Times{5 * kSecond, 5 * kSecond + 50000000, 5 * kSecond + 100000000}));
  EXPECT_EQ(TimesOf(Names{"0.png", "33.png", "67.png", "100.png", "133.png"}).at(4), 133000000);
  EXPECT_TRUE(Open().warnings.empty());
}

TEST_F(PlainDatasetTest, ReadsNanosecondsWithoutTheirZeros) {
  // str(seconds) + "." + str(nanoseconds): 7000001 is seven thousandths.
  const Names names = {"1500000000.7000001.png", "1500000000.57000001.png",
                       "1500000000.107000001.png", "1500000000.957000001.png",
                       "1500000001.7000001.png"};
  const Times times = TimesOf(names);
  ASSERT_EQ(times.size(), 5U);
  EXPECT_EQ(times[0], 1500000000 * kSecond + 7000001);
  EXPECT_EQ(times[1] - times[0], 50000000);
  EXPECT_EQ(times[4], 1500000001 * kSecond + 7000001);
  ExpectHas(All(Open().notes), {"seconds and nanoseconds"});
  // As decimals half a second and five hundredths would be the same.
  EXPECT_EQ(TimesOf(Names{"1500000000.0.png", "1500000000.50000000.png", "1500000000.100000000.png",
                          "1500000000.150000000.png", "1500000000.500000000.png"})[1],
            1500000000 * kSecond + 50000000);
  // Decimals without their last zeros stay decimals.
  EXPECT_EQ(TimesOf(Names{"1500000000.0.png", "1500000000.25.png", "1500000000.5.png",
                          "1500000000.75.png"}),
            (Times{1500000000 * kSecond, 1500000000 * kSecond + 250000000,
                   1500000000 * kSecond + 500000000, 1500000000 * kSecond + 750000000}));
}

TEST_F(PlainDatasetTest, ReadsDatesInNames) {
  // 2023-05-01 12:00:59.95 and a tenth later.
  const Times times = {1682942459 * kSecond + 950000000, 1682942460 * kSecond + 50000000};
  for (const Names& names :
       {Names{"20230501120059950.png", "20230501120100050.png"},
        Names{"20230501T120059.950000.png", "20230501T120100.050000.png"},
        Names{"2023-05-01_12-00-59.950000.png", "2023-05-01_12-01-00.050000.png"},
        Names{"2023-05-01-12-00-59-950000.png", "2023-05-01-12-01-00-050000.png"},
        Names{"2023-05-01-12-00-59-950.png", "2023-05-01-12-01-00-50.png"},
        Names{"2023-05-01 12:00:59.95.png", "2023-05-01 12:01:00.05.png"},
        Names{"left_20230501_120059_950000.png", "left_20230501_120100_050000.png"}}) {
    SCOPED_TRACE(names.front());
    EXPECT_EQ(TimesOf(names), times);
    ExpectHas(All(Open().notes), {"times in years, months, days, hours"});
  }
  // When the recording began, and a number: no times.
  const Names numbered = {"20230501_120059_00001.png", "20230501_120059_00002.png"};
  EXPECT_EQ(TimesOf(numbered), (Times{0, kSecond / 10}));
}

TEST_F(PlainDatasetTest, DatesMayDifferWithinOneSecondOnly) {
  const Times times = {1682942459 * kSecond + 50000000, 1682942459 * kSecond + 100000000,
                       1682942459 * kSecond + 150000000};
  for (const Names& names :
       {Names{"20230501_120059_050.png", "20230501_120059_100.png", "20230501_120059_150.png"},
        Names{"2023-05-01-12-00-59-050000.png", "2023-05-01-12-00-59-100000.png",
              "2023-05-01-12-00-59-150000.png"},
        Names{"20230501_120059_050000000.png", "20230501_120059_100000000.png",
              "20230501_120059_150000000.png"}}) {
    SCOPED_TRACE(names.front());
    EXPECT_EQ(TimesOf(names), times);
  }
  // Each tenth image of a recording that began then.
  EXPECT_EQ(TimesOf(Names{"20230501_120059_010.png", "20230501_120059_020.png"}),
            (Times{0, kSecond / 10}));
  EXPECT_EQ(TimesOf(Names{"20230501_120059_000001.png", "20230501_120059_000002.png"}),
            (Times{0, kSecond / 10}));
}

TEST_F(PlainDatasetTest, CountersBehindDatesAreNoPartsOfSeconds) {
  const Names names = {"20230501_120050_0000.png", "20230501_120050_0001.png",
                       "20230501_120051_0002.png", "20230501_120051_0003.png"};
  Make(names, names);
  ExpectHas(All(Open().warnings), {"10 images a second are assumed"});
}

TEST_F(PlainDatasetTest, NumbersKeepTheirTimes) {
  Make({"000000.png", "000001.png", "000002.png", "000003.png"},
       {"000000.png", "000002.png", "000003.png"});
  const Dataset dataset = Open();
  EXPECT_EQ(TimesOf(dataset), (Times{0, 200000000, 300000000}));
  EXPECT_EQ(dataset.images_left_out, 1);
  ExpectHas(All(dataset.warnings),
            {"1 of 4 left images has no mate", "000001.png", "10 images a second are assumed"});
  DatasetOptions options;
  options.rate_hz = 20.0;
  const Dataset faster = Open(options);
  EXPECT_EQ(TimesOf(faster), (Times{0, 100000000, 150000000}));
  EXPECT_EQ(faster.warnings.size(), 1U);
  options.rate_hz = 0.0;
  ExpectHas(ErrorOf(options), {"--rate"});
  // Every tenth image was kept: as if they were numbered one by one.
  EXPECT_EQ(TimesOf(Names{"000010.png", "000020.png", "000040.png"}),
            (Times{0, 100000000, 300000000}));
}

TEST_F(PlainDatasetTest, PairsByNumberWhateverElseIsInTheName) {
  for (const auto& [left, right] :
       std::vector<std::pair<std::string, std::string>>{{"left#.png", "right#.png"},
                                                        {"image_l_#.png", "image_r_#.jpg"},
                                                        {"#_left.PNG", "#_right.JPG"},
                                                        {"cam0_#.pgm", "cam1_#.pgm"},
                                                        {"#.png", "#.jpg"}}) {
    const auto names = [](const std::string& pattern) {
      Names result;
      for (const char* const number : {"01", "02", "10"}) {
        std::string name = pattern;
        result.push_back(name.replace(name.find('#'), 1, number));
      }
      return result;
    };
    Make(names(left), names(right));
    EXPECT_EQ(TimesOf(Open()), (Times{0, 100000000, 900000000})) << left << " " << right;
  }
  Make({"3.png", "4.png"}, {"3.png", "4.png"});
  WriteImage(root() / "left" / "3.jpg");
  ExpectHas(ErrorOf(), {"left/3.png: has the same number as ", "left/3.jpg"});
  // What is no image of the sequence is left out, and said.
  Make({"1.png", "2.png", "3.png", "thumbnail.png"}, {"1.png", "2.png", "3.png"});
  const Dataset dataset = Open();
  EXPECT_EQ(dataset.entries.size(), 3U);
  ExpectHas(All(dataset.warnings), {"1 image named unlike the others", "thumbnail.png"});
}

TEST_F(PlainDatasetTest, PairsStampsThatAreNearAndSaysWhichAreNot) {
  Names left;
  Names near;
  Names far;
  for (int i = 0; i < 10; ++i) {
    const int64_t stamp = 1700000000 * kSecond + i * 100000000;
    left.push_back(std::to_string(stamp) + ".png");
    near.push_back(std::to_string(stamp + 1000) + ".png");
    far.push_back(std::to_string(stamp + (i == 0 ? 0 : 30000000)) + ".png");
  }
  Make(left, near);
  const Dataset dataset = Open();
  EXPECT_EQ(dataset.entries.size(), 10U);
  EXPECT_EQ(dataset.entries[3].timestamp_ns, 1700000000 * kSecond + 300000000);
  ExpectHas(All(dataset.notes), {"differ by up to 1 us"});
  Make(left, far);
  const Dataset alone = Open();
  EXPECT_EQ(alone.entries.size(), 1U);
  EXPECT_EQ(alone.images_left_out, 18);
  ExpectHas(All(alone.warnings), {"9 of 10 left and 9 of 10 right images have no mate",
                                  "30 ms apart", "at most 10 ms", "--pair-tolerance"});
  DatasetOptions options;
  options.pair_tolerance_s = 0.031;
  EXPECT_EQ(Open(options).entries.size(), 10U);
  Make({"1700000000000000000.png", "1700000000100000000.png"},
       {"1700000000040000000.png", "1700000000140000000.png"});
  ExpectHas(ErrorOf(), {"left: no image has a time near that of one in ", "40 ms apart"});
}

TEST_F(PlainDatasetTest, ReadsTimesFilesInTheirForms) {
  const Names names = {"000000.png", "000001.png", "000002.png"};
  const Times expected = {5 * kSecond, 5 * kSecond + 50000000, 5 * kSecond + 100000000};
  const auto with = [&](const std::string& file, const std::string& text) {
    Make(names, names);
    WriteText(root() / file, text);
    return TimesOf(Open());
  };
  for (const char* const file : {"times.txt", "timestamps.txt", "Timestamps.csv", "left.txt",
                                 "left/times.txt", "left_timestamps.txt"}) {
    EXPECT_EQ(with(file, "5.0\n5.05\n5.1\n"), expected) << file;
    ExpectHas(All(Open().notes), {file});
  }
  const auto text = [&](const std::string& lines) { return with("times.txt", lines); };
  EXPECT_EQ(text("\xEF\xBB\xBF# seconds\r\n5.0\r\n5.05\r\n5.1\r\n"), expected);
  EXPECT_EQ(text("5000000000\n5050000000\n5100000000\n"), expected);
  EXPECT_EQ(text("5000000\n5050000\n5100000\n"), expected);
  EXPECT_EQ(text("5000\n5050\n5100\n"), expected);
  EXPECT_EQ(text("timestamp [ms],filename\n5000,000000.png\n5050,000001.png\n5100,000002.png\n"),
            expected);
  EXPECT_EQ(text("frame,time\n0,5.0\n1,5.05\n2,5.1\n"), expected);
  EXPECT_EQ(text("00000 5.0 0.01\n00001 5.05 0.01\n00002 5.1 0.01\n"), expected);
  EXPECT_EQ(text("5.1 left/000002.png\n5.0 left/000000.png\n5.05 left/000001.png\n"), expected);
  EXPECT_EQ(text("5.0 5.0001\n5.05 5.0501\n5.1 5.1001\n"), expected);
  EXPECT_EQ(text("1970-01-01 00:00:05.0\n1970-01-01 00:00:05.05\n1970-01-01 00:00:05.1\n"),
            expected);
  // More rows than images: numbers count rows, as KITTI's do.
  EXPECT_EQ(text("5.0\n5.05\n5.1\n5.15\n"), expected);
}

TEST_F(PlainDatasetTest, ReadsTimesOfIsoFormAndOfClocks) {
  const Names names = {"0.png", "1.png"};
  Make(names, names);
  WriteText(root() / "times.txt", "2023-05-01T12:00:59.95Z\n2023-05-01T14:01:00.05+02:00\n");
  EXPECT_EQ(TimesOf(Open()),
            (Times{1682942459 * kSecond + 950000000, 1682942460 * kSecond + 50000000}));
  WriteText(root() / "times.txt", "12:00:00.05\n12:00:00.10\n");
  EXPECT_EQ(TimesOf(Open()), (Times{43200 * kSecond + 50000000, 43200 * kSecond + 100000000}));
  WriteText(root() / "times.txt", "0,050000\n0,100000\n");
  EXPECT_EQ(ErrorOf().find("decimal commas") == std::string::npos, false) << ErrorOf();
  WriteText(root() / "times.txt", "1.5e+09\n1.5e+09\n");
  ExpectHas(ErrorOf(), {"too few digits"});
}

TEST_F(PlainDatasetTest, FindsTimesByTheImagesThatTheyName) {
  const Names names = {"a0.png", "a1.png"};
  for (const std::string file : {"rgb.txt", "associations.txt", "frames.csv"}) {
    SCOPED_TRACE(file);
    Make(names, names);
    WriteText(root() / file, "1.5 left/a0.png\n1.75 left/a1.png\n");
    EXPECT_EQ(TimesOf(Open()), (Times{1500000000, 1750000000}));
    ExpectHas(All(Open().notes), {file});
  }
  // Numbers that are no times of images.
  Make(names, names);
  WriteText(root() / "exposures.txt", "1.5 2\n1.75 3\n");
  EXPECT_EQ(TimesOf(Open()), (Times{0, kSecond / 10}));
  ExpectHas(All(Open().warnings), {"whose name has \"time\" or \"stamp\""});
}

TEST_F(PlainDatasetTest, TimesFilesMayNumberTheirRowsWithGaps) {
  const Names names = {"000000.png", "000002.png", "000004.png"};
  Make(names, names);
  WriteText(root() / "times.txt", "0 0.0 0.01\n2 0.2 0.01\n4 0.41 0.01\n");
  EXPECT_EQ(TimesOf(Open()), (Times{0, 200'000'000, 410'000'000}));
  // Times, and numbers behind them.
  WriteText(root() / "times.txt", "1000 0\n1033 2\n1066 4\n");
  EXPECT_EQ(TimesOf(Open())[1] - TimesOf(Open())[0], 33'000'000);
}

TEST_F(PlainDatasetTest, TimesFilesMayNameTheImagesOfBothFolders) {
  const Names names = {"000000.png", "000001.png"};
  Make(names, names);
  WriteText(root() / "times.txt",
            "0.00 left/000000.png\n0.10 left/000001.png\n"
            "0.03 right/000000.png\n0.13 right/000001.png\n");
  EXPECT_EQ(TimesOf(Open()), (Times{0, 100'000'000}));
  WriteText(root() / "times.txt", "0.00 000000.png\n0.03 000000.png\n0.10 000001.png\n");
  ExpectHas(ErrorOf(), {"times.txt: two times for", "000000.png"});
}

TEST_F(PlainDatasetTest, WhatOnlySoundsLikeTimesIsNone) {
  const Names names = {"000000.png", "000001.png", "000002.png"};
  Make(names, names);
  WriteText(root() / "runtime.csv", "0.5\n0.6\n");
  EXPECT_EQ(TimesOf(Open()), (Times{0, 100'000'000, 200'000'000}));
  // More times than images, which count from 1.
  const Names from_one = {"1.png", "2.png"};
  Make(from_one, from_one);
  WriteText(root() / "times.txt", "0\n0.1\n0.2\n0.3\n");
  ExpectHas(All(Open().warnings), {"4 times for 2 images", "counted from 0"});
}

TEST_F(PlainDatasetTest, AFolderOfDataWithoutImagesIsPassedOver) {
  const Names names = {"000000.png", "000001.png"};
  Make(names, names);
  fs::create_directories(root() / "left" / "data");
  EXPECT_EQ(Open().entries.size(), 2U);
  // EuRoC's list without its folder.
  Make(names, names, "cam0", "cam1");
  WriteText(root() / "cam0" / "data.csv",
            "#timestamp [ns],filename\n0,000000.png\n50000000,000001.png\n");
  EXPECT_EQ(TimesOf(Open()), (Times{0, 50'000'000}));
}

TEST_F(PlainDatasetTest, EachCamerasImagesHaveItsSize) {
  const Names names = {"000000.png"};
  Make(names, names);
  cv::imwrite((root() / "right" / names[0]).string(), cv::Mat(20, 32, CV_8UC1, cv::Scalar(9)));
  ExpectHas(ErrorOf(), {"right/000000.png", "32 x 20", "expected 32 x 24"});
}

TEST_F(PlainDatasetTest, NamesWhatIsWrongWithTimesFiles) {
  const Names names = {"000000.png", "000001.png", "000002.png"};
  const auto error = [&](const std::string& text) {
    Make(names, names);
    WriteText(root() / "times.txt", text);
    return ErrorOf();
  };
  ExpectHas(error("5.0\n5.1\n"), {"times.txt: has 2 times for the 3 images of ", "left"});
  ExpectHas(error("5.0\n5.1\nsoon\n"), {"times.txt:3: \"soon\" has no time"});
  ExpectHas(error("5.0\n5.1\n5.1\n"), {"times.txt:3: ", "not after"});
  ExpectHas(error("# nothing\n"), {"times.txt: no times"});
  Make(names, names);
  WriteText(root() / "times.txt", "1.0 000000.png\n3.0 000002.png\n");
  const Dataset dataset = Open();
  EXPECT_EQ(TimesOf(dataset), (Times{kSecond, 3 * kSecond}));
  ExpectHas(All(dataset.warnings), {"1 of 3 images", "no time in"});
}

TEST_F(PlainDatasetTest, TimesOfBothCamerasPairTheirImages) {
  // The right camera lost its second image, and its numbers go on.
  Make({"0.png", "1.png", "2.png"}, {"0.png", "1.png"});
  WriteText(root() / "left" / "timestamps.txt", "5.0\n5.05\n5.1\n");
  WriteText(root() / "right" / "timestamps.txt", "5.0001\n5.1001\n");
  const Dataset dataset = Open();
  ASSERT_EQ(TimesOf(dataset), (Times{5 * kSecond, 5 * kSecond + 100000000}));
  EXPECT_EQ(dataset.entries[1].images[0].filename(), "2.png");
  EXPECT_EQ(dataset.entries[1].images[1].filename(), "1.png");
}

TEST_F(PlainDatasetTest, FindsTheFoldersOfTwoCameras) {
  const Names names = {"000000.png", "000001.png"};
  for (const auto& [left, right] :
       std::vector<std::pair<std::string, std::string>>{{"Left", "Right"},
                                                        {"image_left", "image_right"},
                                                        {"camera_l", "camera_r"},
                                                        {"L", "R"},
                                                        {"cam_0", "cam_1"},
                                                        {"camera_0", "camera_1"},
                                                        {"Camera0", "Camera1"},
                                                        {"cam1", "cam2"},
                                                        {"infra1", "infra2"},
                                                        {"image_02", "image_03"},
                                                        {"left/images", "right/images"},
                                                        {"cam0/data", "cam1/data"}}) {
    Make(names, names, left, right);
    const Dataset dataset = Open();
    ASSERT_EQ(dataset.entries.size(), 2U) << left;
    EXPECT_EQ(dataset.entries[1].images[0], root() / left / "000001.png");
    EXPECT_EQ(dataset.entries[1].images[1], root() / right / "000001.png");
    EXPECT_EQ(All(dataset.notes).find("others would do"), std::string::npos) << left;
  }
  for (const auto& [left, right] :
       std::vector<std::pair<std::string, std::string>>{{"left_000.png", "right_000.png"},
                                                        {"000_left.png", "000_right.png"},
                                                        {"L000.png", "R000.png"},
                                                        {"000_l.png", "000_r.png"}}) {
    Make({left}, {right}, ".", ".");
    const Dataset dataset = Open();
    ASSERT_EQ(dataset.entries.size(), 1U) << left;
    EXPECT_EQ(dataset.entries[0].images[0].filename(), left);
    EXPECT_EQ(dataset.entries[0].images[1].filename(), right);
  }
}

TEST_F(PlainDatasetTest, SaysThatThereAreNoImages) {
  fs::create_directories(root() / "left");
  fs::create_directories(root() / "right");
  ExpectHas(ErrorOf(), {"left: no images in it: the folder is empty"});
  Make({"1.png"}, {});
  WriteText(root() / "right" / "1.heic", "");
  ExpectHas(ErrorOf(), {"right: no images in it", "\".heic\" (1)", ".webp"});
}

TEST_F(PlainDatasetTest, PassesOverHiddenFilesAndFollowsLinks) {
  Make({"1.png", "2.png"}, {"1.png", "2.png"});
  WriteText(root() / "left" / "._1.png", "a trace of another system");
  fs::create_symlink(root() / "left" / "2.png", root() / "left" / "3.png");
  fs::create_symlink(root() / "right" / "2.png", root() / "right" / "3.png");
  const Dataset dataset = Open();
  EXPECT_EQ(dataset.entries.size(), 3U);
  EXPECT_EQ(dataset.Read(2).images[0].cols, 32);
}

TEST_F(PlainDatasetTest, TakesTheSameBitsOfAll16BitImages) {
  Make({}, {});
  for (const char* const side : {"left", "right"}) {
    fs::create_directories(root() / side);
    for (const int value : {400, 1023}) {
      cv::Mat image(24, 32, CV_16UC1, cv::Scalar(value));
      cv::imwrite((root() / side / (std::to_string(value / 512) + ".png")).string(), image);
    }
  }
  const Dataset dataset = Open();
  EXPECT_EQ(dataset.gray_bits, 10);
  ExpectHas(All(dataset.notes), {"values of 10 bits"});
  EXPECT_EQ(dataset.Read(0).images[0].at<unsigned char>(3, 3), 100);
  EXPECT_EQ(dataset.Read(1).images[1].at<unsigned char>(3, 3), 255);
  DatasetOptions options;
  options.count = 1;  // Whichever are chosen.
  EXPECT_EQ(Open(options).gray_bits, 10);
}

}  // namespace
}  // namespace gluevo::vo
