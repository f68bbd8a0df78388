// The doctor's verdicts on a rendered flight, whole and with one thing spoilt at a time.

#include "gluevo/vo/doctor/doctor.h"

#include <gtest/gtest.h>

#include <fstream>
#include <functional>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <string>

#include "checks.h"
#include "gluevo/nn/error.h"
#include "gluevo/vo/simulation/simulation.h"
#include "temporary_folder.h"

namespace gluevo::vo {
namespace {

namespace fs = std::filesystem;

void Replace(const fs::path& path, const std::string& from, const std::string& to) {
  std::ifstream stream(path);
  std::string text{std::istreambuf_iterator<char>(stream), {}};
  const std::size_t at = text.find(from);
  ASSERT_NE(at, std::string::npos) << from;
  text.replace(at, from.size(), to);
  std::ofstream(path) << text;
}

class DoctorTest : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    flight_folder = new TemporaryFolder;
    simulation::SimulationOptions options;
    options.width = 320;
    options.height = 240;
    options.duration_s = 1.2;
    simulation::Simulate(options, flight_folder->path() / "flight");
  }
  static void TearDownTestSuite() { delete flight_folder; }

  /// A copy of the flight, 12 pairs in EuRoC's layout.
  fs::path Copy() const {
    fs::remove_all(folder_.path() / "copy");
    fs::copy(flight_folder->path() / "flight", folder_.path() / "copy",
             fs::copy_options::recursive);
    return folder_.path() / "copy";
  }
  static void ChangeImages(const fs::path& camera,
                           const std::function<cv::Mat(const cv::Mat&)>& change) {
    for (const fs::directory_entry& entry : fs::directory_iterator(camera / "data")) {
      cv::imwrite(entry.path().string(),
                  change(cv::imread(entry.path().string(), cv::IMREAD_GRAYSCALE)));
    }
  }
  static Diagnosis Look(const fs::path& root) {
    DoctorOptions options;
    options.pairs = 4;
    return Examine(root, {}, options);
  }
  static Finding FindingOf(const Diagnosis& diagnosis, const std::string& topic) {
    for (const Finding& finding : diagnosis.findings) {
      if (finding.topic == topic) {
        return finding;
      }
    }
    ADD_FAILURE() << "no finding " << topic;
    return {};
  }
  static std::string All(const Diagnosis& diagnosis) {
    std::string text;
    for (const Finding& finding : diagnosis.findings) {
      text += NameOf(finding.verdict) + ' ' + finding.topic + ": " + finding.value + '\n';
    }
    return text;
  }

 private:
  inline static TemporaryFolder* flight_folder = nullptr;
  TemporaryFolder folder_;
};

TEST_F(DoctorTest, FindsNothingWrongWithAGoodDataSet) {
  const Diagnosis diagnosis = Look(Copy());
  EXPECT_EQ(diagnosis.Count(Verdict::kWrong), 0U) << All(diagnosis);
  EXPECT_EQ(diagnosis.Count(Verdict::kSuspicious), 0U) << All(diagnosis);
  EXPECT_EQ(FindingOf(diagnosis, "rate").value, "10.0 pairs a second");
  EXPECT_EQ(FindingOf(diagnosis, "baseline").value, "0.110 m");
  EXPECT_EQ(FindingOf(diagnosis, "IMU").value, "200.0 readings a second");
}

TEST_F(DoctorTest, TellsExchangedCameras) {
  const fs::path root = Copy();
  for (const char* const part : {"data", "data.csv"}) {
    fs::rename(root / "mav0/cam0" / part, root / "kept");
    fs::rename(root / "mav0/cam1" / part, root / "mav0/cam0" / part);
    fs::rename(root / "kept", root / "mav0/cam1" / part);
  }
  const Diagnosis diagnosis = Look(root);
  EXPECT_EQ(FindingOf(diagnosis, "order of the images").verdict, Verdict::kWrong) << All(diagnosis);
}

TEST(DoctorCalibrationTest, TellsExchangedImagesFromAnInvertedTransform) {
  // Points of a box in front of two cameras that are alike, and of EuRoC's, which are not.
  StereoRig alike = simulation::SimulationRig(320, 240);
  alike.cameras[1] = alike.cameras[0];
  alike.body_from_cam[1] =
      alike.body_from_cam[0] * Rigid3{Eigen::Quaterniond::Identity(), {0.1, 0.0, 0.0}};
  for (const StereoRig& rig : {alike, simulation::SimulationRig(320, 240)}) {
    std::vector<PixelMatch> matches;
    std::vector<PixelMatch> exchanged;
    for (int i = 0; i < 100; ++i) {
      const auto row = i / 10;
      const Eigen::Vector3d point(0.1 * (i % 10 - 5), 0.1 * (row - 5), 1.5 + 0.1 * (i % 7));
      const PixelMatch match = {rig.cameras[0].Project(point),
                                rig.cameras[1].Project(rig.right_from_left() * point)};
      matches.push_back(match);
      exchanged.push_back({match.right, match.left});
    }
    EXPECT_EQ(CheckCalibration(rig, {matches}).size(), 3U);
    for (const Finding& finding : CheckCalibration(rig, {matches})) {
      EXPECT_EQ(finding.verdict, Verdict::kGood) << finding.topic << ": " << finding.value;
    }
    EXPECT_EQ(CheckCalibration(rig, {exchanged}).back().topic, "order of the images");
    StereoRig inverted = rig;
    inverted.body_from_cam[1] = rig.body_from_cam[0] * rig.right_from_left();
    EXPECT_EQ(CheckCalibration(inverted, {matches}).back().topic, "direction of the transform");
  }
}

TEST_F(DoctorTest, TellsACalibrationThatDoesNotFit) {
  const fs::path root = Copy();
  // The principal point of the right camera 12 pixels lower.
  const StereoRig rig = simulation::SimulationRig(320, 240);
  const auto text = [](const fs::path& path) {
    std::ifstream stream(path);
    return std::string{std::istreambuf_iterator<char>(stream), {}};
  };
  const fs::path sensor = root / "mav0/cam1/sensor.yaml";
  std::string intrinsics = text(sensor);
  intrinsics = intrinsics.substr(intrinsics.find("intrinsics:"));
  intrinsics = intrinsics.substr(0, intrinsics.find(']') + 1);
  const Camera& camera = rig.cameras[1];
  Replace(sensor, intrinsics,
          "intrinsics: [" + std::to_string(camera.fx) + ", " + std::to_string(camera.fy) + ", " +
              std::to_string(camera.cx) + ", " + std::to_string(camera.cy + 12.0) + "]");
  const Diagnosis diagnosis = Look(root);
  EXPECT_EQ(FindingOf(diagnosis, "epipolar error").verdict, Verdict::kWrong) << All(diagnosis);
  EXPECT_EQ(FindingOf(diagnosis, "vertical offset").verdict, Verdict::kWrong) << All(diagnosis);
}

TEST_F(DoctorTest, TellsImagesWithoutContent) {
  const fs::path root = Copy();
  ChangeImages(root / "mav0/cam0", [](const cv::Mat& image) { return cv::Mat(image / 64); });
  const Diagnosis diagnosis = Look(root);
  EXPECT_EQ(FindingOf(diagnosis, "light, left").verdict, Verdict::kWrong) << All(diagnosis);
  EXPECT_EQ(FindingOf(diagnosis, "light, right").verdict, Verdict::kGood) << All(diagnosis);
}

TEST_F(DoctorTest, TellsALensOutOfFocus) {
  const fs::path root = Copy();
  ChangeImages(root / "mav0/cam1", [](const cv::Mat& image) {
    cv::Mat blurred;
    cv::GaussianBlur(image, blurred, {0, 0}, 4.0);
    return blurred;
  });
  const Diagnosis diagnosis = Look(root);
  EXPECT_EQ(FindingOf(diagnosis, "sharpness").verdict, Verdict::kSuspicious) << All(diagnosis);
}

TEST_F(DoctorTest, TellsCopies) {
  const fs::path root = Copy();
  fs::remove_all(root / "mav0/cam1/data");
  fs::copy(root / "mav0/cam0/data", root / "mav0/cam1/data");
  const Diagnosis diagnosis = Look(root);
  EXPECT_EQ(FindingOf(diagnosis, "left and right images that are equal").verdict, Verdict::kWrong)
      << All(diagnosis);
}

TEST_F(DoctorTest, TellsAGapAndAnotherUnitOfTheImu) {
  const fs::path root = Copy();
  // Two frames in the middle are gone from one camera.
  std::ifstream stream(root / "mav0/cam0/data.csv");
  std::string kept;
  int number = 0;
  for (std::string line; std::getline(stream, line); ++number) {
    kept += number == 6 || number == 7 ? "" : line + '\n';
  }
  std::ofstream(root / "mav0/cam0/data.csv") << kept;
  std::ofstream(root / "mav0/imu0/data.csv")
      << "#timestamp [ns],w,w,w,a,a,a\n1500000000000000000,0,0,1,0,0,1\n"
         "1500000000005000000,0,0,1,0,0,1\n1500000000010000000,0,0,1,0,0,1\n";
  const Diagnosis diagnosis = Look(root);
  EXPECT_EQ(FindingOf(diagnosis, "gaps").verdict, Verdict::kSuspicious) << All(diagnosis);
  const Finding gravity = FindingOf(diagnosis, "IMU readings");
  EXPECT_EQ(gravity.verdict, Verdict::kSuspicious);
  EXPECT_NE(gravity.value.find("multiples of g"), std::string::npos) << gravity.value;
  EXPECT_EQ(FindingOf(diagnosis, "IMU and images").verdict, Verdict::kSuspicious);
}

TEST_F(DoctorTest, LooksOnWhereTheDataSetDoesNotOpen) {
  const fs::path root = Copy();
  std::ofstream(root / "mav0/cam0/sensor.yaml") << "camera_model: none\n";
  const Diagnosis diagnosis = Look(root);
  EXPECT_NE(FindingOf(diagnosis, "opening").value.find("sensor.yaml"), std::string::npos);
  EXPECT_EQ(FindingOf(diagnosis, "disparity").verdict, Verdict::kGood) << All(diagnosis);
  EXPECT_EQ(FindingOf(diagnosis, "image size").value, "320 x 240 left, 320 x 240 right");
  EXPECT_EQ(Look(root / "nowhere").Count(Verdict::kWrong), 1U);
}

TEST_F(DoctorTest, TellsAnImageThatCannotBeRead) {
  const fs::path root = Copy();
  const fs::path image = fs::directory_iterator(root / "mav0/cam0/data")->path();
  fs::resize_file(image, fs::file_size(image) / 2);
  DoctorOptions options;
  options.pairs = 12;
  const Finding images = FindingOf(Examine(root, {}, options), "images");
  EXPECT_EQ(images.verdict, Verdict::kWrong);
  EXPECT_NE(images.value.find(image.filename().string()), std::string::npos) << images.value;
}

TEST_F(DoctorTest, RefusesOptionsOutOfTheirRange) {
  DoctorOptions options;
  options.pairs = 0;
  EXPECT_THROW(Examine(Copy(), {}, options), Error);
}

TEST(DoctorRigTest, TellsMillimetresAndAnInvertedTransform) {
  StereoRig rig = simulation::SimulationRig(320, 240);
  const auto verdict = [&](const std::string& topic) {
    for (const Finding& finding : CheckRig(rig)) {
      if (finding.topic == topic) {
        return finding.verdict;
      }
    }
    return Verdict::kWrong;
  };
  EXPECT_EQ(verdict("baseline"), Verdict::kGood);
  EXPECT_EQ(verdict("right camera"), Verdict::kGood);
  std::swap(rig.body_from_cam[0], rig.body_from_cam[1]);
  EXPECT_EQ(verdict("right camera"), Verdict::kSuspicious);
  const Rigid3 left = rig.body_from_cam[0];
  rig.body_from_cam[1] = left * Rigid3{Eigen::Quaterniond::Identity(), {110.0, 0.0, 0.0}};
  EXPECT_EQ(verdict("baseline"), Verdict::kWrong);
}

TEST(DoctorImuTest, ReadsKittisOxts) {
  const TemporaryFolder folder;
  fs::create_directories(folder.path() / "oxts/data");
  for (int i = 0; i < 5; ++i) {
    std::ofstream(folder.path() / "oxts/data" / (std::to_string(i) + ".txt"))
        << "49 8 115 0 0 0 0 0 0 0 0 0.1 0.2 9.8 0.1 0.2 9.8 0 0 0.3 0 0 0.3 1 1 4 11 6 6 6\n";
    std::ofstream(folder.path() / "oxts/timestamps.txt", std::ios::app)
        << "2011-09-26 13:02:25.9" << i << "0000000\n";
  }
  const Findings findings = CheckImu(FindImu(folder.path()), {});
  ASSERT_GE(findings.size(), 3U);
  EXPECT_EQ(findings[0].value, "100.0 readings a second");
  for (const Finding& finding : findings) {
    EXPECT_EQ(finding.verdict, Verdict::kGood) << finding.topic << ": " << finding.value;
  }
}

TEST(DoctorImuTest, SaysWhyAUnitCannotBeUsed) {
  const TemporaryFolder folder;
  EXPECT_EQ(CheckImu(FindImu(folder.path()), {}).at(0).value, "none found");
  fs::create_directories(folder.path() / "imu0");
  std::ofstream(folder.path() / "imu0/data.csv") << "1,2,3\n";
  const Findings findings = CheckImu(FindImu(folder.path()), {});
  ASSERT_EQ(findings.size(), 1U);
  EXPECT_EQ(findings[0].verdict, Verdict::kWrong);
  EXPECT_NE(findings[0].value.find("data.csv:1: 3 fields"), std::string::npos) << findings[0].value;
}

TEST(DoctorStampsTest, TellsRatesThatAreNone) {
  const auto verdict = [](int64_t step) {
    for (const Finding& finding : CheckStamps({0, step, 2 * step, 3 * step})) {
      if (finding.topic == "rate") {
        return finding.verdict;
      }
    }
    return Verdict::kGood;
  };
  EXPECT_EQ(verdict(50'000'000), Verdict::kGood);
  EXPECT_EQ(verdict(50'000), Verdict::kWrong);
  EXPECT_EQ(verdict(2'000'000'000), Verdict::kSuspicious);
  EXPECT_EQ(verdict(100'000'000'000), Verdict::kWrong);
}

}  // namespace
}  // namespace gluevo::vo
