// An output that is one of the inputs is refused before anything is done.

#include <gtest/gtest.h>

#include <opencv2/imgcodecs.hpp>

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
  std::string Calibration(const std::string& name) const {
    std::string text;
    for (const std::string camera : {"0", "1"}) {
      text += "cam" + camera +
              ":\n  camera_model: pinhole\n  distortion_model: radtan\n"
              "  distortion_coeffs: [0, 0, 0, 0]\n  intrinsics: [100, 100, 80, 60]\n"
              "  resolution: [160, 120]\n";
    }
    return Write(name, text +
                           "  T_cn_cnm1: [[1, 0, 0, -0.1], [0, 1, 0, 0], [0, 0, 1, 0], "
                           "[0, 0, 0, 1]]\n");
  }
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

}  // namespace
}  // namespace gluevo::apps
