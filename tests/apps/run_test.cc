// gluevo run as a user runs it: good runs, and one clear line for each bad input.

#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>
#include <nlohmann/json.hpp>
#include <opencv2/imgcodecs.hpp>
#include <random>

#include "apps/command_test.h"

namespace gluevo::apps {
namespace {

class RunTest : public CommandTest {
 protected:
  // Four stereo pairs of a random texture that drifts by 2 pixels a frame, in KITTI's layout. Blobs
  // of 4 pixels at a disparity of 6.
  fs::path MakeKitti() const {
    fs::path root = fs::path(Path("data")) / "sequences" / "00";
    fs::create_directories(root / "image_0");
    fs::create_directories(root / "image_1");
    std::mt19937 generator(5);
    cv::Mat texture(130, 300, CV_8UC1);
    for (int y = 0; y < texture.rows; ++y) {
      for (int x = 0; x < texture.cols; ++x) {
        texture.at<uchar>(y, x) = y % 4 == 0 && x % 4 == 0
                                      ? static_cast<uchar>(generator() % 256)
                                      : texture.at<uchar>(y / 4 * 4, x / 4 * 4);
      }
    }
    std::ofstream times(root / "times.txt");
    for (int i = 0; i < 4; ++i) {
      for (int side = 0; side < 2; ++side) {
        const cv::Mat view = texture(cv::Rect(20 + 2 * i + 6 * side, 0, 160, 120));
        cv::imwrite(ImagePath(root, side, i).string(), view);
      }
      times << 0.1 * i << '\n';
    }
    std::ofstream(root / "calib.txt") << "P0: 100 0 80 0 0 100 60 0 0 0 1 0\n"
                                         "P1: 100 0 80 -50 0 100 60 0 0 0 1 0\n";
    return root;
  }
  static fs::path ImagePath(const fs::path& root, int side, int frame) {
    return root / ("image_" + std::to_string(side)) / ("00000" + std::to_string(frame) + ".png");
  }
  // The command with these arguments and words put behind them.
  Outcome RunWith(std::string arguments, std::initializer_list<std::string> words) const {
    for (const std::string& word : words) {
      arguments.append(" ").append(word);
    }
    return Run(arguments);
  }
  // One line that names what is wrong, exit 1, no results.
  void ExpectRefused(const std::string& arguments, const std::string& expected) const {
    SCOPED_TRACE(arguments);
    const Outcome outcome = Run("run " + arguments + " -o " + Path("out"));
    EXPECT_EQ(outcome.exit_code, 1);
    EXPECT_EQ(outcome.out, "");
    const std::size_t message = outcome.error.find("gluevo: error: ");
    ASSERT_NE(message, std::string::npos) << outcome.error;
    const std::string line = outcome.error.substr(message);
    EXPECT_EQ(std::count(line.begin(), line.end(), '\n'), 1) << line;
    EXPECT_NE(line.find(expected), std::string::npos) << line;
    EXPECT_FALSE(fs::exists(Path("out"))) << "half-written output";
  }
};

TEST_F(RunTest, WritesAPoseForEveryFrameAndTheSameForAnyNumberOfThreads) {
  const fs::path root = MakeKitti();
  const std::string run = "run " + root.string();
  for (const std::string method : {"klt", "superglue"}) {
    for (const std::string threads : {"1", "2"}) {
      const Outcome outcome =
          RunWith(run, {"-o", Path(method + threads), "--method", method, "--threads", threads});
      ASSERT_EQ(outcome.exit_code, 0) << outcome.error;
      EXPECT_TRUE(fs::exists(Path(method + threads + "/keyframes.tum")));
    }
    const std::string trajectory = Contents(Path(method + "1/trajectory.tum"));
    EXPECT_EQ(trajectory, Contents(Path(method + "2/trajectory.tum")));
    EXPECT_NE(trajectory.find("left camera"), std::string::npos);
    for (const char* const time :
         {"\n0.000000000 ", "\n0.100000000 ", "\n0.200000000 ", "\n0.300000000 "}) {
      EXPECT_NE(trajectory.find(time), std::string::npos) << time;
    }
    const auto metrics = nlohmann::json::parse(Contents(Path(method + "1/metrics.json")));
    EXPECT_EQ(metrics["frames"], 4);
    EXPECT_EQ(metrics["frames_with_pose"], 4);
    EXPECT_EQ(metrics["method"], method);
    EXPECT_EQ(metrics["threads"], 1);
    for (const char* const key :
         {"keyframes", "resets", "segments", "warnings", "duration_s", "frames_per_second",
          "stages_ms", "matches_per_frame", "peak_memory_mb", "isa", "weights", "options", "preset",
          "preset_from", "option_origins"}) {
      EXPECT_TRUE(metrics.contains(key)) << key;
    }
    if (method == "superglue") {
      EXPECT_EQ(metrics["weights"]["superglue"]["sha256"].get<std::string>().size(), 64U);
      EXPECT_TRUE(metrics["stages_ms"].contains("match_stereo"));
    }
  }
}

TEST_F(RunTest, SaysWhereEachOptionsValueComesFrom) {
  const fs::path root = MakeKitti();
  const std::string config = Write("config.yaml", "window: 9\niterations: 5\n");
  const Outcome by_data = Run("run " + root.string() + " -o " + Path("by_data") +
                              " --method klt --window 10 --config " + config);
  ASSERT_EQ(by_data.exit_code, 0) << by_data.error;
  auto metrics = nlohmann::json::parse(Contents(Path("by_data/metrics.json")));
  EXPECT_EQ(metrics["preset"], "driving");
  EXPECT_EQ(metrics["preset_from"], "data set");
  EXPECT_EQ(metrics["options"]["klt-corners"], "200");
  EXPECT_EQ(metrics["option_origins"]["klt-corners"], "preset");
  EXPECT_EQ(metrics["options"]["window"], "10");
  EXPECT_EQ(metrics["option_origins"]["window"], "command line");
  EXPECT_EQ(metrics["options"]["iterations"], "5");
  EXPECT_EQ(metrics["option_origins"]["iterations"], "file");
  EXPECT_EQ(metrics["option_origins"]["refine"], "default");

  const Outcome asked = Run("run " + root.string() + " -o " + Path("asked") +
                            " --method superpoint --preset euroc --keyframe-parallax 12");
  ASSERT_EQ(asked.exit_code, 0) << asked.error;
  metrics = nlohmann::json::parse(Contents(Path("asked/metrics.json")));
  EXPECT_EQ(metrics["preset"], "euroc");
  EXPECT_EQ(metrics["preset_from"], "command line");
  EXPECT_EQ(metrics["options"]["klt-corners"], "150");
  EXPECT_EQ(metrics["options"]["keyframe-parallax"], "12");
  EXPECT_EQ(metrics["options"]["max-keypoints"], "1500");
  EXPECT_EQ(metrics["option_origins"]["max-keypoints"], "method");
}

TEST_F(RunTest, TheFileOfOptionsMayNameTheOutput) {
  const fs::path root = MakeKitti();
  const std::string config = Write("config.yaml", "output: " + Path("named") + "\nmethod: klt\n");
  const Outcome outcome = Run("run " + root.string() + " --config " + config);
  ASSERT_EQ(outcome.exit_code, 0) << outcome.error;
  const auto metrics = nlohmann::json::parse(Contents(Path("named/metrics.json")));
  EXPECT_EQ(metrics["options"]["output"], Path("named"));
  EXPECT_EQ(metrics["option_origins"]["output"], "file");
  // The command line goes before it, and one of them must.
  EXPECT_EQ(Run("run " + root.string() + " --config " + config + " -o " + Path("o")).exit_code, 0);
  EXPECT_TRUE(fs::exists(Path("o/metrics.json")));
  const Outcome neither = Run("run " + root.string());
  EXPECT_EQ(neither.exit_code, 2);
  EXPECT_NE(neither.error.find("--output is missing"), std::string::npos) << neither.error;
}

TEST_F(RunTest, AnOptionGivenTwiceIsAList) {
  const fs::path data = Path("flight");
  ASSERT_EQ(
      Run("simulate -o " + data.string() + " --duration 0.3 --rate 10 --width 160 --height 120")
          .exit_code,
      0);
  const std::vector<std::string> files = {(data / "mav0/cam0/sensor.yaml").string(),
                                          (data / "mav0/cam1/sensor.yaml").string()};
  const std::string config = Write(
      "config.yaml", "method: klt\ncalibration:\n  - " + files[0] + "\n  - " + files[1] + "\n");
  const std::string run = "run " + data.string() + " --threads 1 -o " + Path("out") + " ";
  for (const std::string& options :
       {"--method klt --calibration " + files[0] + " --calibration " + files[1],
        "--config " + config}) {
    const Outcome outcome = Run(run + options + " --save-matches " + Path("m.h5"));
    EXPECT_EQ(outcome.exit_code, 0) << outcome.error;
    const auto metrics = nlohmann::json::parse(Contents(Path("out/metrics.json")));
    EXPECT_EQ(metrics["options"]["calibration"], files);
    const std::string list = nlohmann::json(files).dump();
    EXPECT_NE(Contents(Path("m.h5")).find(list), std::string::npos);
  }
}

TEST_F(RunTest, SaysHowManyImagesAreLeftOut) {
  const fs::path root = MakeKitti();
  fs::remove(ImagePath(root, 1, 2));
  const Outcome outcome = Run("run " + root.string() + " --method klt -o " + Path("out"));
  ASSERT_EQ(outcome.exit_code, 0) << outcome.error;
  EXPECT_NE(outcome.error.find("warning: 1 of 4 left images has no mate"), std::string::npos)
      << outcome.error;
  const auto metrics = nlohmann::json::parse(Contents(Path("out/metrics.json")));
  EXPECT_EQ(metrics["frames"], 3);
  EXPECT_EQ(metrics["images_left_out"], 1);
  EXPECT_NE(metrics["warnings"].dump().find("000002.png"), std::string::npos);
}

TEST_F(RunTest, RefusesABadOutputBeforeTheFirstFrame) {
  const fs::path root = MakeKitti();
  // No frame can be read: whoever looks at one first complains of it.
  for (int i = 0; i < 4; ++i) {
    std::ofstream(ImagePath(root, 1, i), std::ios::binary) << "broken";
  }
  const std::string file = Write("taken", "kept");
  for (const std::string& output : {file, file + "/below"}) {
    const Outcome outcome = Run("run " + root.string() + " --method klt -o " + output);
    EXPECT_EQ(outcome.exit_code, 1);
    EXPECT_NE(outcome.error.find("gluevo: error: " + output + ": "), std::string::npos)
        << outcome.error;
  }
  EXPECT_EQ(Contents(file), "kept");
  const Outcome map =
      Run("run " + root.string() + " --method klt -o " + Path("out") + " --map " + file);
  EXPECT_EQ(map.exit_code, 1);
  EXPECT_NE(map.error.find(file + ": is a file"), std::string::npos) << map.error;
  for (const std::string taken : {"points.ply", "keyframes.ply"}) {
    const std::string folder = Path("map_of_" + taken);
    fs::create_directories(folder + "/" + taken);
    const Outcome outcome =
        Run("run " + root.string() + " --method klt -o " + Path("out") + " --map " + folder);
    EXPECT_EQ(outcome.exit_code, 1);
    EXPECT_NE(outcome.error.find(taken + ": cannot be written: is a folder"), std::string::npos)
        << outcome.error;
  }
  fs::create_directories(Path("models"));
  const std::string models = Write("models/colmap", "");
  EXPECT_NE(
      Run("run " + root.string() + " --method klt -o " + Path("out") + " --map " + Path("models"))
          .error.find(models + ": is a file"),
      std::string::npos);
  EXPECT_FALSE(fs::exists(Path("out")));
}

TEST_F(RunTest, AReplayEqualsItsRun) {
  const fs::path root = MakeKitti();
  const std::string open = (fs::path(GLUEVO_SOURCE_DIR) / "nn" / "open_weights").string();
  const std::string plain = "run " + root.string() + " --weights ";
  const std::string matches = Path("matches.h5");
  const fs::path first = Path("first");
  const fs::path again = Path("again");
  const std::string run_first =
      plain + open + " --start 1 --count 2 -o " + first.string() + " --save-matches " + matches;
  const std::string run_again =
      plain + Path("absent") + " -o " + again.string() + " --replay " + matches;
  for (const std::string method : {"klt", "superpoint", "superglue"}) {
    SCOPED_TRACE(method);
    fs::remove(matches);
    const Outcome run = RunWith(run_first, {"--method", method});
    ASSERT_EQ(run.exit_code, 0) << run.error;
    // Images that cannot be read show that none is read; absent weights, that none are loaded.
    const std::string image = Contents(ImagePath(root, 0, 1));
    std::ofstream(ImagePath(root, 0, 1), std::ios::binary) << "broken";
    const Outcome replayed_run = Run(run_again);
    ASSERT_EQ(replayed_run.exit_code, 0) << replayed_run.error;
    for (const char* const file : {"trajectory.tum", "keyframes.tum"}) {
      EXPECT_EQ(Contents(first / file), Contents(again / file));
    }
    const auto metrics = nlohmann::json::parse(Contents(first / "metrics.json"));
    const auto replayed = nlohmann::json::parse(Contents(again / "metrics.json"));
    EXPECT_EQ(replayed["frames"], 2);
    EXPECT_EQ(replayed["method"], method);
    for (const char* const key : {"weights", "matches_per_frame", "keyframes", "segments"}) {
      EXPECT_EQ(metrics[key], replayed[key]) << key;
    }
    std::ofstream(ImagePath(root, 0, 1), std::ios::binary) << image;
    fs::remove_all(first);
    fs::remove_all(again);
  }
}

TEST_F(RunTest, RefusesMatchesOfOtherData) {
  const fs::path root = MakeKitti();
  const std::string matches = Path("matches.h5");
  const std::string replay = root.string() + " --replay " + matches;
  ASSERT_EQ(Run("run " + root.string() + " -o " + Path("run") +
                " --method klt --count 3 --save-matches " + matches)
                .exit_code,
            0);
  ExpectRefused(replay + " --method superglue", "matches of method");
  ExpectRefused(replay + " --start 1", "frame 0 is at 0 ns there and at 100000000 ns");
  ExpectRefused(replay + " --stride 2", "frame 1 is at");
  ExpectRefused(replay + " --count 4", "3 frames there, 4 in the data set");
  ExpectRefused(root.string() + " --replay " + Path("absent.h5"), "absent.h5");
  ExpectRefused(root.string() + " --replay " + (root / "calib.txt").string(), "calib.txt");
  std::ofstream(root / "calib.txt") << "P0: 100 0 80 0 0 100 60 0 0 0 1 0\n"
                                       "P1: 100 0 80 -51 0 100 60 0 0 0 1 0\n";
  ExpectRefused(replay, "calibrated differently");
  EXPECT_EQ(Run("run " + replay + " -o " + Path("out") + " --save-matches " + matches).exit_code,
            2);
}

TEST_F(RunTest, AFailedRunLeavesNoMatches) {
  const fs::path root = MakeKitti();
  std::ofstream(ImagePath(root, 1, 0), std::ios::binary) << "broken";
  fs::create_directories(Path("matches"));
  ExpectRefused(root.string() + " --method klt --strict --save-matches " + Path("matches/m.h5"),
                "000000.png");
  EXPECT_TRUE(fs::is_empty(Path("matches")));
  ExpectRefused(root.string() + " --method klt --save-matches " + Path("none/m.h5"), "m.h5");
}

TEST_F(RunTest, WarnsWhereMatchingYieldsNextToNothing) {
  const fs::path root = MakeKitti();
  const Outcome outcome = Run("run " + root.string() + " -o " + Path("out") +
                              " --tracking-threshold 0.9999 --stereo-matching network"
                              " --stereo-threshold 0.9999");
  // Results are there, though nothing was tracked.
  ASSERT_EQ(outcome.exit_code, 1) << outcome.error;
  EXPECT_NE(outcome.error.find("error: nothing was tracked over 4 frames"), std::string::npos);
  const auto metrics = nlohmann::json::parse(Contents(Path("out/metrics.json")));
  EXPECT_NE(metrics["warnings"].dump().find("next to nothing"), std::string::npos);
}

TEST_F(RunTest, RefusesBrokenDataSets) {
  ExpectRefused(Path("absent"), "absent");
  const fs::path root = MakeKitti();
  fs::rename(root / "image_1", root / "hidden");
  ExpectRefused(root.string() + " --format kitti", "image_1");
  fs::rename(root / "hidden", root / "image_1");

  cv::imwrite(ImagePath(root, 1, 0).string(), cv::Mat(100, 160, CV_8UC1, cv::Scalar(9)));
  ExpectRefused(root.string() + " --method klt --strict", "160 x 100");
  fs::copy_file(ImagePath(root, 1, 1), ImagePath(root, 1, 0), fs::copy_options::overwrite_existing);

  std::ofstream(root / "calib.txt") << "P0: 100 0 80 0 0 100 60 0 0 0 1 0\n";
  ExpectRefused(root.string(), "P1");
}

TEST_F(RunTest, RefusesBrokenWeightsAndOptions) {
  const std::string root = MakeKitti().string();
  const fs::path open = fs::path(GLUEVO_SOURCE_DIR) / "nn" / "open_weights";
  const std::string superpoint = (open / "superpoint.safetensors").string();
  const std::string superglue = (open / "superglue.safetensors").string();
  Write("cut.safetensors", Contents(superpoint).substr(0, 100000));
  ExpectRefused(root + " --superpoint " + Path("cut.safetensors"), "cut.safetensors");
  ExpectRefused(root + " --superpoint " + superglue, "these are a SuperGlue's");
  ExpectRefused(root + " --superglue " + superpoint, "these are a SuperPoint's");
  ExpectRefused(root + " --superpoint " + Path("none.npz"), "none.npz");
  ExpectRefused(root + " --weights " + Path(""), "no superpoint.safetensors");
  Write("run.yaml", "method: klt\nwindow: 9\nwindow: 10\n");
  ExpectRefused(root + " --config " + Path("run.yaml"), "run.yaml:3: \"window\" for the second");
  ExpectRefused(root + " --config " + Path(""), Path("") + ": is a folder, expected a file");
  ExpectRefused(root + " --groundtruth " + Path("none.txt"), "none.txt");
  setenv("GLUEVO_ISA", "mmx", 1);
  ExpectRefused(root, "GLUEVO_ISA=mmx");
  ExpectRefused(root + " --method klt --loops off", "GLUEVO_ISA=mmx");
  unsetenv("GLUEVO_ISA");
}

TEST_F(RunTest, BadUsageExitsWithTwo) {
  EXPECT_EQ(Run("run").exit_code, 2);
  EXPECT_EQ(Run("run a -o b --no-such-option").exit_code, 2);
  EXPECT_EQ(Run("run a -o b --method sift").exit_code, 2);
  EXPECT_EQ(Run("").exit_code, 2);
  for (const std::string command :
       {"run", "extract", "match", "evaluate", "experiment", "simulate"}) {
    const Outcome help = Run(command + " --help");
    EXPECT_EQ(help.exit_code, 0);
    EXPECT_NE(help.out.find("Example"), std::string::npos) << command;
  }
}

}  // namespace
}  // namespace gluevo::apps
