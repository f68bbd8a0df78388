// gluevo extract and gluevo match as a user runs them.

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <opencv2/imgcodecs.hpp>
#include <random>

#include "apps/command_test.h"

namespace gluevo::apps {
namespace {

class MatchTest : public CommandTest {
 protected:
  // Two views of a random mosaic, the second 8 pixels to the right of the first.
  void MakeImages() const {
    std::mt19937 generator(9);
    cv::Mat texture(120, 176, CV_8UC1);
    for (int y = 0; y < texture.rows; ++y) {
      for (int x = 0; x < texture.cols; ++x) {
        texture.at<uchar>(y, x) = y % 8 == 0 && x % 8 == 0
                                      ? static_cast<uchar>(generator() % 256)
                                      : texture.at<uchar>(y / 8 * 8, x / 8 * 8);
      }
    }
    fs::create_directories(Path("images/sub"));
    cv::imwrite(Path("images/a.png"), texture(cv::Rect(0, 0, 160, 120)));
    cv::imwrite(Path("images/sub/b.png"), texture(cv::Rect(8, 0, 160, 120)));
    Write("shift.txt", "1 0 -8 0 1 0 0 0 1\n");
  }
};

TEST_F(MatchTest, TwoImagesGiveRightMatches) {
  MakeImages();
  for (const std::string matcher : {"superglue", "nn"}) {
    const Outcome outcome =
        Run("match " + Path("images/a.png") + " " + Path("images/sub/b.png") + " --matcher " +
            matcher + " --json --draw " + Path("draw.png") + " --homography " + Path("shift.txt"));
    ASSERT_EQ(outcome.exit_code, 0) << outcome.error;
    const auto json = nlohmann::json::parse(outcome.out);
    EXPECT_GT(json["matches"].size(), 20U);
    EXPECT_GT(json["precision"].get<double>(), 0.8);
    EXPECT_EQ(cv::imread(Path("draw.png")).cols, 320);
  }
}

TEST_F(MatchTest, FilesInHlocsLayout) {
  MakeImages();
  ASSERT_EQ(Run("extract " + Path("images") + " -o " + Path("features.h5")).exit_code, 0);
  Write("pairs.txt", "a.png sub/b.png\n");
  const Outcome outcome = Run("match " + Path("features.h5") + " --pairs " + Path("pairs.txt") +
                              " -o " + Path("matches.h5"));
  ASSERT_EQ(outcome.exit_code, 0) << outcome.error;
  EXPECT_NE(outcome.out.find("1 pair, "), std::string::npos);
  EXPECT_TRUE(fs::exists(Path("matches.h5")));
}

TEST_F(MatchTest, BadInputIsNamed) {
  MakeImages();
  ASSERT_EQ(Run("extract " + Path("images") + " -o " + Path("features.h5")).exit_code, 0);
  Write("pairs.txt", "a.png absent.png\n");
  const Outcome absent = Run("match " + Path("features.h5") + " --pairs " + Path("pairs.txt") +
                             " -o " + Path("matches.h5"));
  EXPECT_EQ(absent.exit_code, 1);
  EXPECT_NE(absent.error.find("absent.png"), std::string::npos);
  EXPECT_FALSE(fs::exists(Path("matches.h5")));
  EXPECT_EQ(Run("match " + Path("features.h5")).exit_code, 2);
  EXPECT_EQ(Run("extract " + Path("nowhere") + " -o " + Path("x.h5")).exit_code, 1);
  // The others are extracted.
  Write("images/broken.png", "no image");
  const Outcome broken = Run("extract " + Path("images") + " -o " + Path("x.h5"));
  EXPECT_EQ(broken.exit_code, 0);
  EXPECT_NE(broken.error.find("broken.png: not an image"), std::string::npos) << broken.error;
  EXPECT_EQ(broken.out.substr(0, 8), "2 images");
  EXPECT_NE(broken.out.find("1 image that cannot be read"), std::string::npos) << broken.out;
  fs::create_directories(Path("bad"));
  Write("bad/broken.png", "no image");
  const Outcome none = Run("extract " + Path("bad") + " -o " + Path("y.h5"));
  EXPECT_EQ(none.exit_code, 1);
  EXPECT_NE(none.error.find("none of its images can be read"), std::string::npos) << none.error;
  EXPECT_FALSE(fs::exists(Path("y.h5")));
}

TEST_F(MatchTest, AHomographyMapsImagesToImages) {
  MakeImages();
  const std::string match = "match " + Path("images/a.png") + " " + Path("images/sub/b.png") +
                            " --matcher nn --max-keypoints 20 --homography ";
  for (const std::string text :
       {"0 0 0 0 0 0 0 0 0", "1 0 5 1 0 5 0 0 1", "nan 0 0 0 1 0 0 0 1", "1 0 0 0 1 0 0 0",
        "%YAML:1.0\n---\nH: !!opencv-matrix\n  rows: 3\n  cols: 3\n  dt: d\n"
        "  data: [0, 0, 0, 0, 0, 0, 0, 0, 0]\n"}) {
    const Outcome outcome = Run(match + Write("h.txt", text));
    EXPECT_EQ(outcome.exit_code, 1) << text;
    EXPECT_NE(outcome.error.find("h.txt: no homography"), std::string::npos) << outcome.error;
  }
  EXPECT_EQ(Run(match + Write("h.txt", "1e-9 0 0 0 1e-9 0 0 0 1e-9\n")).exit_code, 0);
  EXPECT_EQ(Run(match + Write("h.txt", "1 0 -20000 0 1 9000 0 0 1\n")).exit_code, 0);
  EXPECT_EQ(Run(match + Write("h.yml",
                              "%YAML:1.0\n---\nH: !!opencv-matrix\n  rows: 3\n  cols: 3\n  dt: d\n"
                              "  data: [1, 0, -8, 0, 1, 0, 0, 0, 1]\n"))
                .exit_code,
            0);
}

// A device has no end; a pipe has one.
TEST_F(MatchTest, DevicesAreNoInputs) {
  MakeImages();
  ASSERT_EQ(Run("extract " + Path("images") + " -o " + Path("features.h5")).exit_code, 0);
  const std::string image = Path("images/a.png");
  const std::string to = " -o " + Path("matches.h5");
  for (const std::string& arguments :
       {"match " + Path("features.h5") + " --pairs /dev/zero" + to,
        "match /dev/zero --pairs " + Write("pairs.txt", "a.png sub/b.png\n") + to,
        "match " + image + " /dev/zero", "match " + image + " " + image + " --homography /dev/zero",
        std::string("calibration /dev/zero"), std::string("evaluate /dev/zero /dev/zero"),
        "experiment /dev/zero -o " + Path("out"),
        "run " + Path("images") + " --config /dev/zero -o " + Path("out")}) {
    const Outcome outcome = RunProgram("timeout 60 " + std::string(GLUEVO_PROGRAM), arguments);
    EXPECT_EQ(outcome.exit_code, 1) << arguments;
    EXPECT_NE(outcome.error.find("/dev/zero: is a device or a pipe, expected a file"),
              std::string::npos)
        << arguments << ": " << outcome.error;
  }
  const Outcome pipe = RunProgram("cat " + Path("pairs.txt") + " | " + GLUEVO_PROGRAM,
                                  "match " + Path("features.h5") + " --pairs /dev/stdin" + to);
  EXPECT_EQ(pipe.exit_code, 0) << pipe.error;
}

TEST_F(MatchTest, ListsOfPairsInTheFormsOfOtherTools) {
  MakeImages();
  ASSERT_EQ(Run("extract " + Path("images") + " -o " + Path("features.h5")).exit_code, 0);
  const auto match = [&](const std::string& list) {
    Write("pairs.txt", list);
    return Run("match " + Path("features.h5") + " --pairs " + Path("pairs.txt") + " -o " +
               Path("matches.h5") + " --matcher nn");
  };
  for (const std::string list :
       {"\xEF\xBB\xBF# pairs\r\n\r\na.png sub/b.png\r\n", "a.png\tsub/b.png\n", "a.png,sub/b.png\n",
        "a.png sub/b.png 0 0 0.5\n", "a.png sub/b.png\na.png sub/b.png\n", "./a.png sub\\b.png\n",
        "/somewhere/images/a.png /somewhere/images/sub/b.png\n", "a.png b.png\n"}) {
    const Outcome outcome = match(list);
    EXPECT_EQ(outcome.exit_code, 0) << list << outcome.error;
    EXPECT_EQ(outcome.out.substr(0, 8), "1 pair, ") << list << outcome.out;
  }
  const Outcome both = match("a.png sub/b.png\nsub/b.png a.png\n");
  EXPECT_EQ(both.out.substr(0, 7), "2 pairs") << both.out;
  const Outcome late = match("a.png sub/b.png\na.png absent.png\ngone.png a.png\n");
  EXPECT_EQ(late.exit_code, 1);
  EXPECT_NE(late.error.find("pairs.txt:2: \"absent.png\" has no features"), std::string::npos);
  EXPECT_NE(late.error.find("1 other of the list"), std::string::npos) << late.error;
  EXPECT_EQ(match("\"a.png\" \"sub/b.png\"\n").out.substr(0, 8), "1 pair, ");
  EXPECT_EQ(match("'a.png', 'sub/b.png'\n").out.substr(0, 8), "1 pair, ");
  const std::string utf16(
      "\xFF\xFE"
      "a\0 \0b\0\n\0",
      10);
  EXPECT_NE(match(utf16).error.find("pairs.txt: text in UTF-16"), std::string::npos);
  EXPECT_EQ(late.error.find("pair 1"), std::string::npos) << late.error;
  EXPECT_NE(match("a.png\n").error.find("pairs.txt:1: expected two names"), std::string::npos);
}

TEST_F(MatchTest, NamesThatFitSeveralImagesAreToldFromThoseThatFitNone) {
  MakeImages();
  fs::create_directories(Path("images/other"));
  fs::copy(Path("images/sub/b.png"), Path("images/other/b.png"));
  ASSERT_EQ(Run("extract " + Path("images") + " -o " + Path("features.h5")).exit_code, 0);
  Write("pairs.txt", "a.png b.png\n");
  const Outcome outcome = Run("match " + Path("features.h5") + " --pairs " + Path("pairs.txt") +
                              " -o " + Path("matches.h5"));
  EXPECT_EQ(outcome.exit_code, 1);
  EXPECT_NE(outcome.error.find("\"b.png\" may be \"other/b.png\" or \"sub/b.png\""),
            std::string::npos)
      << outcome.error;
}

TEST_F(MatchTest, AnImageThatIsTooSmallIsNamedAndTheOthersAreExtracted) {
  MakeImages();
  cv::imwrite(Path("images/tiny.png"), cv::Mat(5, 5, CV_8UC1, cv::Scalar(9)));
  const Outcome extract = Run("extract " + Path("images") + " -o " + Path("features.h5"));
  EXPECT_EQ(extract.exit_code, 0) << extract.error;
  EXPECT_NE(extract.error.find("tiny.png: an image of 5 x 5 pixels"), std::string::npos)
      << extract.error;
  EXPECT_EQ(extract.out.substr(0, 8), "2 images");
  const Outcome match = Run("match " + Path("images/a.png") + " " + Path("images/tiny.png"));
  EXPECT_EQ(match.exit_code, 1);
  EXPECT_NE(match.error.find("tiny.png: an image of 5 x 5 pixels"), std::string::npos)
      << match.error;
}

}  // namespace
}  // namespace gluevo::apps
