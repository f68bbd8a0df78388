// An output that is one of the inputs is refused before anything is done.

#include <gtest/gtest.h>

#include <algorithm>
#include <opencv2/imgcodecs.hpp>
#include <set>

#include "apps/command_test.h"

namespace gluevo::apps {
namespace {

class DistinctOutputsTest : public CommandTest {
 protected:
  void ExpectRefused(const std::string& arguments, const std::string& file) const {
    SCOPED_TRACE(arguments);
    const std::string before = Contents(file);
    const Outcome outcome = Run(arguments);
    EXPECT_EQ(outcome.exit_code, 1);
    EXPECT_NE(outcome.error.find("is an input of this command"), std::string::npos)
        << outcome.error;
    EXPECT_EQ(Contents(file), before);
  }
  std::string Calibration(const std::string& name) const { return Write(name, Camchain(160, 120)); }
};

TEST_F(DistinctOutputsTest, OfImagesAndFeatures) {
  fs::create_directories(Path("images"));
  const std::string image = Path("images/a.png");
  const std::string other = Path("b.png");
  cv::imwrite(image, cv::Mat(64, 64, CV_8UC1, cv::Scalar(90)));
  cv::imwrite(other, cv::Mat(64, 64, CV_8UC1, cv::Scalar(90)));
  ExpectRefused("match " + image + " " + other + " --draw " + image, image);
  fs::create_symlink(other, Path("link.png"));
  ExpectRefused("match " + image + " " + other + " --draw " + Path("link.png"), other);
  ExpectRefused("extract " + Path("images") + " -o " + image, image);
  const std::string features = Write("f.h5", "features");
  const std::string pairs = Write("pairs.txt", "a b\n");
  ExpectRefused("match " + features + " --pairs " + pairs + " -o " + features, features);
  ExpectRefused("match " + features + " --pairs " + pairs + " -o " + Path("images/../pairs.txt"),
                pairs);
  ExpectRefused("bench --image " + image + " --layers 1 --output " + image, image);
}

TEST_F(DistinctOutputsTest, OfTrajectoriesAndCalibrations) {
  const std::string trajectory = Write("e.tum", "1 0 0 0 0 0 0 1\n2 1 0 0 0 0 0 1\n");
  ExpectRefused("evaluate " + trajectory + " " + trajectory + " --plot " + trajectory, trajectory);
  const std::string chain = Calibration("chain.yaml");
  ASSERT_EQ(Run("calibration " + chain).exit_code, 0);
  ExpectRefused("calibration " + chain + " --write kalibr -o " + chain, chain);
  ASSERT_EQ(Run("calibration " + chain + " --write euroc -o " + Path("rig")).exit_code, 0);
  // The one that is not named, too.
  ExpectRefused("calibration " + Path("rig/cam0/sensor.yaml") + " --write kalibr -o " +
                    Path("rig/cam1/sensor.yaml"),
                Path("rig/cam1/sensor.yaml"));
  ExpectRefused("calibration " + Path("rig/cam0/sensor.yaml") + " --write euroc -o " + Path("rig"),
                Path("rig/cam0/sensor.yaml"));
}

TEST_F(DistinctOutputsTest, OfRuns) {
  fs::create_directories(Path("data"));
  const std::string chain = Calibration("chain.yaml");
  ExpectRefused("run " + Path("data") + " -o " + Path("out") + " --calibration " + chain +
                    " --save-matches " + chain,
                chain);
  fs::create_directories(Path("out"));
  const std::string truth = Write("out/trajectory.tum", "1 0 0 0 0 0 0 1\n");
  ExpectRefused("run " + Path("data") + " -o " + Path("out") + " --groundtruth " + truth, truth);
}

// Before anything is read: the data set is an empty folder.
TEST_F(DistinctOutputsTest, TwoOfOneNameAreRefused) {
  fs::create_directories(Path("data"));
  fs::create_directories(Path("there"));
  fs::create_symlink(Path("there"), Path("link"));
  const auto expect_refused = [&](const std::string& options, const std::string& expected) {
    SCOPED_TRACE(options);
    const Outcome outcome = Run("run " + Path("data") + " " + options);
    EXPECT_EQ(outcome.exit_code, 2);
    EXPECT_NE(outcome.error.find(expected), std::string::npos) << outcome.error;
    EXPECT_EQ(std::count(outcome.error.begin(), outcome.error.end(), '\n'), 1) << outcome.error;
    EXPECT_EQ(Files(), 4U);
  };
  // A link to what is not there yet is where it leads.
  fs::create_symlink("out/metrics.json", Path("ahead"));
  const std::string same = ": two outputs of this command have this name";
  const std::string file = Path("F.h5");
  const std::string out = " -o " + Path("out");
  expect_refused("--save-matches " + file + " --save-map " + Path("there/../F.h5") + out,
                 file + same);
  for (const char* const option : {" --save-matches ", " --save-map "}) {
    expect_refused(option + Path("out/metrics.json") + out, Path("out/metrics.json") + same);
    expect_refused(option + Path("ahead") + out, "two outputs of this command have this name");
    expect_refused(option + Path("there/report.html") + " -o " + Path("link"),
                   Path("there/report.html") + same);
    expect_refused(option + Path("map/points.ply") + out + " --map " + Path("map"),
                   Path("map/points.ply") + same);
    expect_refused(option + Path("map/colmap/0/images.txt") + out + " --map " + Path("map"),
                   ": lies below " + Path("map/colmap"));
    expect_refused(option + Path("out") + out, ": lies below " + Path("out"));
  }
  const Outcome live = Run("live " + Path("data") + out + " --socket " + Path("out/report.html"));
  EXPECT_EQ(live.exit_code, 2);
  EXPECT_NE(live.error.find(same), std::string::npos) << live.error;
}

// The folders that are inputs hold more files than the command line names.
class FilesOfInputsTest : public DistinctOutputsTest {
 protected:
  void ExpectKept(const std::string& arguments, const std::string& file,
                  const std::string& expected) const {
    SCOPED_TRACE(arguments);
    const std::string before = Contents(file);
    const Outcome outcome = Run(arguments);
    EXPECT_EQ(outcome.exit_code, 1);
    EXPECT_NE(outcome.error.find(file + ": cannot be written: " + expected), std::string::npos)
        << outcome.error;
    EXPECT_EQ(Contents(file), before);
  }
  std::string Data() const {
    std::string data = Path("flight");
    EXPECT_EQ(
        Run("simulate -o " + data + " --duration 0.3 --rate 10 --width 160 --height 120").exit_code,
        0);
    return data;
  }
};

TEST_F(FilesOfInputsTest, AreNotReplacedByARun) {
  const std::string data = Data();
  const std::string run = "run " + data + " --method klt --threads 1 -o ";
  const std::string run_and_save = run + Path("out") + " --save-matches ";
  for (const char* const name : {"mav0/cam0/data.csv", "mav0/cam1/sensor.yaml"}) {
    const std::string file = (fs::path(data) / name).string();
    ExpectKept(run_and_save + file, file, "a file is there that is no file of --save-matches");
  }
  const std::string poses = Write("flight/trajectory.tum", "1 0 0 0 0 0 0 1\n");
  ExpectKept(run + data, poses, "is a file of the data set");
  fs::create_directories(Path("flight/colmap/0"));
  const std::string model = Write("flight/colmap/0/cameras.txt", "# Camera list\n");
  const std::string points = Write("flight/points.ply", "ply\nformat ascii 1.0\n");
  ExpectKept(run + Path("out") + " --map " + data, points, "is a file of the data set");
  fs::remove(points);
  ExpectKept(run + Path("out") + " --map " + data, model, "is a file of the data set");
  EXPECT_FALSE(fs::exists(Path("out")));
}

// What a run wrote before in another format would be taken for the new one's; what no run wrote
// stays.
TEST_F(FilesOfInputsTest, TrajectoriesOfAnEarlierRunGo) {
  const std::string data = Data();
  const std::string run = "run " + data + " --method klt --threads 1 --imu off -o ";
  const auto names = [&] {
    std::set<std::string> found;
    for (const auto& entry : fs::directory_iterator(Path("out"))) {
      found.insert(entry.path().filename().string());
    }
    return found;
  };
  const std::set<std::string> others = {"covariance.csv", "metrics.json", "report.html"};
  const auto expect = [&](const std::string& options, std::set<std::string> expected) {
    const Outcome outcome = Run(run + Path("out") + " " + options);
    ASSERT_EQ(outcome.exit_code, 0) << outcome.error;
    expected.insert(others.begin(), others.end());
    EXPECT_EQ(names(), expected) << options;
  };
  expect("", {"trajectory.tum", "keyframes.tum", "trajectory_optimized.tum"});
  expect("--loops off", {"trajectory.tum", "keyframes.tum"});
  expect("--loops off --trajectory-format euroc", {"trajectory.csv", "keyframes.csv"});
  Write("out/trajectory.tum", "somebody's\n");
  expect("--trajectory-format kitti",
         {"trajectory.txt", "keyframes.txt", "trajectory_optimized.txt", "trajectory.tum"});
  // Among the data set's files another format's place is no result either.
  ASSERT_EQ(Run(run + data).exit_code, 0);
  const std::string truth = Write("flight/trajectory.csv", "1000000000,1,0,0,1,0,0,0\n");
  ExpectKept(run + data + " --trajectory-format euroc", truth, "is a file of the data set");
}

TEST_F(FilesOfInputsTest, ButResultsAmongThemAre) {
  const std::string data = Data();
  const std::string run = "run " + data + " --method klt --threads 1 -o " + data + "/out --map " +
                          data + "/map --save-matches " + data + "/m.h5";
  for (int i = 0; i < 2; ++i) {
    const Outcome outcome = Run(run);
    EXPECT_EQ(outcome.exit_code, 0) << outcome.error;
  }
}

TEST_F(FilesOfInputsTest, AreNotReplacedByOtherCommands) {
  fs::create_directories(Path("weights"));
  const std::string weights = Write("weights/superpoint.safetensors", "weights");
  const std::string option = " --weights " + Path("weights") + " ";
  fs::create_directories(Path("images"));
  ExpectRefused("extract " + Path("images") + option + "-o " + weights, weights);
  ExpectRefused(
      "match " + Write("f.h5", "") + option + "--pairs " + Write("p.txt", "") + " -o " + weights,
      weights);
  ExpectRefused("bench" + option + "--output " + weights, weights);
  const std::string notes = Write("notes.txt", "notes");
  ExpectKept("extract " + Path("images") + " -o " + notes, notes,
             "a file is there that is not an HDF5 file");
  const std::string metrics = Write("metrics.json", "{}");
  const std::string trajectory = Write("e.tum", "1 0 0 0 0 0 0 1\n2 1 0 0 0 0 0 1\n");
  ExpectKept("evaluate " + trajectory + " " + trajectory + " --plot " + metrics, metrics,
             "a file is there that is not an SVG file");
}

// Files of the same kind that somebody else made are kept; a command's own are replaced.
TEST_F(FilesOfInputsTest, AreNotReplacedWhereSomebodyElseMadeThem) {
  const auto expect_own = [&](const std::string& arguments, const std::string& file) {
    SCOPED_TRACE(arguments);
    fs::remove(file);
    for (int i = 0; i < 2; ++i) {
      const Outcome outcome = Run(arguments);
      EXPECT_EQ(outcome.exit_code, 0) << outcome.error;
    }
  };
  const std::string foreign = Write("other.yaml", Camchain(320, 240));
  const std::string kalibr =
      "calibration " + Calibration("chain.yaml") + " --write kalibr -o " + foreign;
  ExpectKept(kalibr, foreign, "a file is there that is not a calibration that gluevo wrote");
  expect_own(kalibr, foreign);
  fs::create_directories(Path("rig/cam1"));
  const std::string sensor = Write("rig/cam1/sensor.yaml", "sensor_type: camera\n");
  const std::string euroc =
      "calibration " + Calibration("chain.yaml") + " --write euroc -o " + Path("rig");
  ExpectKept(euroc, sensor, "a file is there that is not a calibration that gluevo wrote");
  EXPECT_FALSE(fs::exists(Path("rig/cam0/sensor.yaml")));
  expect_own(euroc, sensor);
  const std::string tensors = Write("tensors.safetensors", "somebody's");
  const std::string bench =
      "bench --network superglue --layers 1 --keypoints 8 --rounds 1 --threads 1 --output " +
      tensors;
  ExpectKept(bench, tensors, "a file is there that is not a file of gluevo bench");
  expect_own(bench, tensors);
  const std::string image = Path("a.png");
  const std::string photo = Path("photo.png");
  for (const std::string& file : {image, photo}) {
    cv::imwrite(file, cv::Mat(64, 64, CV_8UC1, cv::Scalar(90)));
  }
  const std::string match = "match " + image + " " + image + " --draw ";
  ExpectKept(match + photo, photo, "a file is there that is not a drawing of gluevo match");
  expect_own(match + photo, photo);
  EXPECT_EQ(cv::imread(photo).cols, 128);
}

}  // namespace
}  // namespace gluevo::apps
