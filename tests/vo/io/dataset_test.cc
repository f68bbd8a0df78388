#include "gluevo/vo/io/dataset.h"

#include <gtest/gtest.h>

#include <fstream>
#include <functional>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <string>
#include <vector>

#include "gluevo/nn/error.h"
#include "gluevo/vo/io/trajectory_file.h"
#include "message_of.h"
#include "temporary_folder.h"

namespace gluevo::vo {
namespace {

namespace fs = std::filesystem;

constexpr int kWidth = 32;
constexpr int kHeight = 24;

void WriteText(const fs::path& path, const std::string& text) {
  fs::create_directories(path.parent_path());
  std::ofstream(path, std::ios::binary) << text;
}

/// An image of one gray value, its own in every image.
void WriteImage(const fs::path& path, int value, int width = kWidth, int height = kHeight) {
  fs::create_directories(path.parent_path());
  ASSERT_TRUE(cv::imwrite(path.string(), cv::Mat(height, width, CV_8UC1, cv::Scalar(value))));
}

void Shorten(const fs::path& path) { fs::resize_file(path, fs::file_size(path) / 2); }

std::string SensorYaml(double x, const std::string& model = "radial-tangential") {
  return "%YAML:1.0\n# comment\nsensor_type: camera\nT_BS:\n  cols: 4\n  rows: 4\n"
         "  data: [0.0, -1.0, 0.0, " +
         std::to_string(x) +
         ",\n         1.0, 0.0, 0.0, 0.2,\n         0.0, 0.0, 1.0, 0.3,\n"
         "         0.0, 0.0, 0.0, 1.0]\nrate_hz: 20\nresolution: [32, 24]\n"
         "camera_model: pinhole\nintrinsics: [20.5, 20.25, 15.75, 11.5] #fu, fv, cu, cv\n"
         "distortion_model: " +
         model + "\ndistortion_coefficients: [-0.28, 0.07, 0.0002, 1.8e-05]\n";
}

class DatasetTest : public testing::Test {
 protected:
  const fs::path& folder() const { return folder_.path(); }

  /// The message of the Error that opening throws, which must be one line.
  static std::string ErrorOf(const fs::path& path, const DatasetOptions& options = {}) {
    return MessageOf([&] { OpenDataset(path, options); });
  }
  static void ExpectContains(const std::string& message, const std::vector<std::string>& parts) {
    for (const std::string& part : parts) {
      EXPECT_NE(message.find(part), std::string::npos) << "\"" << part << "\" in: " << message;
    }
  }

  /// Four pairs at 100, 200, 300 and 400; each camera has one more image without a mate.
  fs::path MakeEuroc() const {
    const fs::path mav0 = folder() / "euroc" / "mav0";
    for (int camera = 0; camera < 2; ++camera) {
      const fs::path root = mav0 / ("cam" + std::to_string(camera));
      std::string csv = "#timestamp [ns],filename\r\n";
      for (int time : {100, 200, 300, 400, 500 + 50 * camera}) {
        const std::string name = std::to_string(time) + (time == 200 ? ".jpg" : ".png");
        WriteImage(root / "data" / name, time / 4 + camera);
        csv += std::to_string(time) + "," + name + "\r\n";
      }
      WriteText(root / "data.csv", csv);
      WriteText(root / "sensor.yaml", SensorYaml(camera == 0 ? 0.1 : 0.21));
    }
    WriteText(mav0 / "state_groundtruth_estimate0" / "data.csv",
              "#timestamp,p\n100,1,2,3,1,0,0,0,9,9,9\n400,1,2,4,1,0,0,0,9,9,9\n");
    return folder() / "euroc";
  }

  /// Frames 0, 1 and 3 of a sequence of five.
  fs::path MakeKittiOdometry() const {
    const fs::path root = folder() / "kitti" / "sequences" / "06";
    for (const char* const name : {"000000.png", "000001.png", "000003.png"}) {
      WriteImage(root / "image_0" / name, 10);
      WriteImage(root / "image_1" / name, 20);
    }
    WriteText(root / "calib.txt",
              "P0: 20 0 16 0 0 21 12 0 0 0 1 0\nP1: 20 0 16 -10 0 21 12 0 0 0 1 0\n");
    WriteText(root / "times.txt", "0.0\n1.036000e-01\n0.2072\n0.3108\n0.4144\n");
    return root;
  }

  /// Frames 2 and 4 of a drive of six rows, in a folder of the day.
  fs::path MakeKittiRaw(int width = kWidth, int height = kHeight,
                        const std::string& end_of_line = "\n") const {
    const fs::path day = folder() / "raw" / "2011_09_26";
    const fs::path root = day / "2011_09_26_drive_0001_sync";
    for (const char* const name : {"0000000002.png", "0000000004.png"}) {
      WriteImage(root / "image_00" / "data" / name, 10, width, height);
      WriteImage(root / "image_01" / "data" / name, 20, width, height);
    }
    std::string times;
    for (const char* const time :
         {"23:59:59.500000001", "23:59:59.600000001", "23:59:59.900000001", "23:59:59.950000001"}) {
      times += std::string("2011-09-30 ") + time + end_of_line;
    }
    times += "2011-10-01 00:00:00.250000123" + end_of_line;
    WriteText(root / "image_00" / "timestamps.txt", times);
    WriteText(day / "calib_cam_to_cam.txt",
              "calib_time: 09-Jan-2012 13:57:47\ncorner_dist: 9.950000e-02\n"
              "S_00: 40 30\nK_00: 25 0 20 0 26 15 0 0 1\nD_00: -0.3 0.2 0.001 0.002 -0.05\n"
              "R_00: 1 0 0 0 1 0 0 0 1\nT_00: 0 0 0\nS_rect_00: 32 24\n"
              "P_rect_00: 20 0 16 0 0 20 12 0 0 0 1 0\n"
              "S_01: 40 30\nK_01: 25.5 0 20.5 0 26.5 15.5 0 0 1\n"
              "D_01: -0.31 0.21 0.0011 0.0021 -0.06\n"
              "R_01: 0 -1 0 1 0 0 0 0 1\nT_01: -0.5 0.01 0.02\nS_rect_01: 32 24\n"
              "P_rect_01: 20 0 16 -10.8 0 20 12 0 0 0 1 0\n");
    return root;
  }

  fs::path MakePlain(const std::vector<std::string>& names) const {
    const fs::path root = folder() / "plain";
    for (const std::string& name : names) {
      WriteImage(root / "left" / name, 10);
      WriteImage(root / "right" / name, 20);
    }
    return root;
  }

  fs::path Camchain() const {
    const fs::path path = folder() / "camchain.yaml";
    WriteText(path,
              "cam0:\n  camera_model: pinhole\n  distortion_model: equidistant\n"
              "  distortion_coeffs: [0.01, 0.02, 0.03, 0.04]\n  intrinsics: [20, 21, 16, 12]\n"
              "  resolution: [32, 24]\n  rostopic: /cam0\n"
              "cam1:\n  T_cn_cnm1:\n  - [1.0, 0.0, 0.0, -0.1]\n  - [0.0, 1.0, 0.0, 0.01]\n"
              "  - [0.0, 0.0, 1.0, 0.02]\n  - [0.0, 0.0, 0.0, 1.0]\n"
              "  camera_model: pinhole\n  distortion_model: radtan\n"
              "  distortion_coeffs: [0.1, 0.2, 0.3, 0.4]\n  intrinsics: [22, 23, 15, 11]\n"
              "  resolution: [32, 24]\n");
    return path;
  }

 private:
  TemporaryFolder folder_;
};

void Replace(const fs::path& path, const std::string& from, const std::string& to) {
  std::ifstream stream(path, std::ios::binary);
  std::string text{std::istreambuf_iterator<char>(stream), {}};
  const std::size_t at = text.find(from);
  ASSERT_NE(at, std::string::npos) << from << " in " << path;
  WriteText(path, text.replace(at, from.size(), to));
}

TEST_F(DatasetTest, ReadsEuroc) {
  const fs::path root = MakeEuroc();
  for (const fs::path& path : {root, root / "", root / "mav0", root / "mav0" / ""}) {
    const Dataset dataset = OpenDataset(path, {});
    EXPECT_EQ(dataset.format, DatasetFormat::kEuroc);
    ASSERT_EQ(dataset.entries.size(), 4U);
    EXPECT_EQ(dataset.entries[1].timestamp_ns, 200);
    EXPECT_EQ(dataset.rig.body_frame, "imu (body)");
    const Camera& camera = dataset.rig.cameras[0];
    EXPECT_EQ(camera.width, kWidth);
    EXPECT_EQ(camera.height, kHeight);
    EXPECT_EQ(camera.fx, 20.5);
    EXPECT_EQ(camera.fy, 20.25);
    EXPECT_EQ(camera.cx, 15.75);
    EXPECT_EQ(camera.cy, 11.5);
    EXPECT_EQ(camera.distortion, Distortion::kRadialTangential);
    EXPECT_EQ(camera.coefficients, (DistortionCoefficients{-0.28, 0.07, 0.0002, 1.8e-05, 0.0}));
    EXPECT_NEAR(dataset.rig.baseline(), 0.11, 1e-12);
    // T_BS takes x of the camera to y of the body.
    EXPECT_TRUE((dataset.rig.body_from_cam[0] * Eigen::Vector3d(1.0, 0.0, 0.0))
                    .isApprox(Eigen::Vector3d(0.1, 1.2, 0.3)));
    ASSERT_TRUE(dataset.groundtruth);
    EXPECT_EQ(dataset.groundtruth->back().world_from_body.translation, Eigen::Vector3d(1, 2, 4));

    const StereoFrame frame = dataset.Read(2);
    EXPECT_EQ(frame.timestamp_ns, 300);
    EXPECT_EQ(frame.images[0].type(), CV_8UC1);
    EXPECT_EQ(frame.images[0].at<unsigned char>(5, 5), 75);
    EXPECT_EQ(frame.images[1].at<unsigned char>(5, 5), 76);
    EXPECT_EQ(dataset.Read(1).images[0].size(), cv::Size(kWidth, kHeight));
  }
}

TEST_F(DatasetTest, KittiTakesNoReadingsOfAnInertialUnit) {
  DatasetOptions options;
  options.imu = "readings.csv";
  const std::string odometry = ErrorOf(MakeKittiOdometry(), options);
  ExpectContains(odometry, {"has no inertial unit", "expected no --imu FILE"});
  EXPECT_EQ(odometry.find("oxts"), std::string::npos) << odometry;
  ExpectContains(ErrorOf(MakeKittiRaw(), options), {"has its own inertial readings (oxts)"});
}

TEST_F(DatasetTest, ChoosesFrames) {
  const fs::path root = MakeEuroc();
  const auto times = [&](int start, int count, int stride) {
    DatasetOptions options;
    options.start = start;
    options.count = count;
    options.stride = stride;
    const Dataset dataset = OpenDataset(root, options);
    EXPECT_EQ(dataset.groundtruth->size(), 2U);  // Stays whole.
    std::vector<int64_t> result;
    for (const Dataset::Entry& entry : dataset.entries) {
      result.push_back(entry.timestamp_ns);
    }
    return result;
  };
  EXPECT_EQ(times(0, -1, 1), (std::vector<int64_t>{100, 200, 300, 400}));
  EXPECT_EQ(times(1, 2, 1), (std::vector<int64_t>{200, 300}));
  EXPECT_EQ(times(0, -1, 3), (std::vector<int64_t>{100, 400}));
  EXPECT_EQ(times(3, 9, 2), (std::vector<int64_t>{400}));
  DatasetOptions options;
  options.start = 4;
  ExpectContains(ErrorOf(root, options), {"first frame 4", "at most 3", "--start"});
  options = {.start = -1};
  ExpectContains(ErrorOf(root, options), {"--start"});
  options = {.start = 0, .count = 0};
  ExpectContains(ErrorOf(root, options), {"--count"});
  options = {.start = 0, .count = 1, .stride = 0};
  ExpectContains(ErrorOf(root, options), {"--stride"});
}

TEST_F(DatasetTest, NamesWhatIsWrongWithEuroc) {
  const auto broken = [&](const std::function<void(const fs::path&)>& breaking) {
    fs::remove_all(folder() / "euroc");
    const fs::path root = MakeEuroc();
    breaking(root / "mav0");
    return ErrorOf(root);
  };
  ExpectContains(ErrorOf(folder() / "missing"), {"missing: no such folder"});
  ExpectContains(broken([](const fs::path& mav0) { fs::remove_all(mav0 / "cam1"); }),
                 {"mav0/cam1: no such folder"});
  ExpectContains(broken([](const fs::path& mav0) { fs::remove_all(mav0 / "cam0"); }),
                 {"mav0/cam0: no such folder"});
  ExpectContains(broken([](const fs::path& mav0) { fs::remove(mav0 / "cam1" / "data.csv"); }),
                 {"cam1/data.csv: no such file"});
  ExpectContains(broken([](const fs::path& mav0) { fs::remove_all(mav0 / "cam1" / "data"); }),
                 {"cam1/data/100.png: no such image", "none of the others"});
  ExpectContains(broken([](const fs::path& mav0) { fs::remove(mav0 / "cam0" / "sensor.yaml"); }),
                 {"cam0/sensor.yaml: no such file"});
  const auto csv = [&](const std::string& text) {
    return broken([&](const fs::path& mav0) { WriteText(mav0 / "cam0" / "data.csv", text); });
  };
  ExpectContains(csv("#t\n100\n"), {"cam0/data.csv:2: "});
  ExpectContains(csv("soon,100.png\n"), {"cam0/data.csv:1: "});
  ExpectContains(csv("100,100.png\n100,100.png\n"), {"cam0/data.csv:2: ", "twice"});
  ExpectContains(csv(""), {"no image of cam0 has the same time as one of cam1"});
  const auto yaml = [&](const std::string& from, const std::string& to) {
    return broken([&](const fs::path& mav0) { Replace(mav0 / "cam1" / "sensor.yaml", from, to); });
  };
  ExpectContains(yaml("intrinsics", "extrinsics"), {"cam1/sensor.yaml: no intrinsics"});
  ExpectContains(yaml("20.5,", ""), {"intrinsics has 3 numbers, expected 4"});
  ExpectContains(yaml("20.5", ".nan"), {"sensor.yaml: intrinsics is not a list of finite numbers"});
  ExpectContains(yaml("20.5", "-20.5"), {"sensor.yaml", "focal lengths"});
  ExpectContains(yaml("[32, 24]", "[32, -24]"), {"sensor.yaml: the image height"});
  ExpectContains(yaml("[32, 24]", "[1e99, 24]"), {"sensor.yaml: the image width"});
  ExpectContains(yaml("pinhole", "omni"), {"intrinsics has 4 numbers, expected 5"});
  ExpectContains(yaml("pinhole", "linear"), {"sensor.yaml: camera model \"linear\""});
  ExpectContains(yaml("radial-tangential", "fog"), {"distortion model \"fog\""});
  ExpectContains(yaml("radial-tangential", "[1]"), {"distortion_model is not a name"});
  ExpectContains(yaml("-0.28, 0.07, ", ""), {"distortion_coefficients has 2 coefficients"});
  ExpectContains(yaml("0.0, -1.0, 0.0", "0.0, -1.1, 0.0"), {"T_BS is not a rigid transform"});
  ExpectContains(yaml("0.0, -1.0, 0.0", "0.0, 1.0, 0.0"), {"T_BS is not a rigid transform"});
  ExpectContains(yaml("0.0, 0.0, 0.0, 1.0]", "0.0, 0.0, 1.0, 1.0]"), {"last row of T_BS"});
  ExpectContains(yaml("0.0, 0.0, 0.0, 1.0]", "1.0]"), {"T_BS has 13 numbers"});
  ExpectContains(yaml("[32, 24]", "[32, 24"), {"sensor.yaml:", "not YAML"});
  ExpectContains(yaml("0.21", "0.10"), {"in the same place"});
}

TEST_F(DatasetTest, ReadsEurocsTimesInOtherUnits) {
  const auto open = [&](const std::string& first, const std::string& second) {
    const fs::path root = MakeEuroc();
    for (const char* const camera : {"cam0", "cam1"}) {
      WriteText(root / "mav0" / camera / "data.csv",
                "#timestamp [ns],filename\n" + first + ",100.png\n" + second + ",300.png\n");
    }
    const Dataset dataset = OpenDataset(root, {});
    EXPECT_EQ(dataset.entries.at(1).timestamp_ns, 1500000000050000000);
    return dataset.notes.empty() ? "" : dataset.notes.front();
  };
  ExpectContains(open("1500000000000000", "1500000000050000"), {"cam0/data.csv", "microseconds"});
  ExpectContains(open("1500000000.000000", "1500000000.050000"), {"in seconds"});
  EXPECT_EQ(open("1500000000000000000.0", "1500000000050000000.0"), "");
  ExpectContains(MessageOf([&] { open("1.5e+18", "1.5e+18"); }), {"twice", "too few digits"});
}

TEST_F(DatasetTest, KittiImagesOfAnotherSizeThanTheCalibrationsAreWarnedOf) {
  const fs::path root = MakeKittiOdometry();
  EXPECT_TRUE(OpenDataset(root, {}).warnings.empty());
  WriteText(root / "calib.txt",
            "P0: 40 0 31 0 0 42 23 0 0 0 1 0\nP1: 40 0 31 -20 0 42 23 0 0 0 1 0\n");
  const Dataset dataset = OpenDataset(root, {});
  ASSERT_FALSE(dataset.warnings.empty());
  ExpectContains(dataset.warnings.front(), {"calib.txt", "principal point"});
}

TEST_F(DatasetTest, LeavesOutWhatIsMissingAndSaysSo) {
  const fs::path euroc = MakeEuroc();
  fs::remove(euroc / "mav0" / "cam1" / "data" / "300.png");
  const Dataset without_file = OpenDataset(euroc, {});
  EXPECT_EQ(without_file.entries.size(), 3U);
  EXPECT_EQ(without_file.images_left_out, 4);  // The mate, and one of each without any.
  ASSERT_GE(without_file.warnings.size(), 2U);
  ExpectContains(without_file.warnings[0], {"1 image ", "cam1/data.csv", "cam1/data/300.png"});
  ExpectContains(without_file.warnings[1], {"2 of 5 left and 1 of 4 right images", "no mate",
                                            "50 ns apart", "--pair-tolerance"});

  const fs::path kitti = MakeKittiOdometry();
  fs::remove(kitti / "image_1" / "000001.png");
  const Dataset without_mate = OpenDataset(kitti, {});
  EXPECT_EQ(without_mate.entries.size(), 2U);
  EXPECT_EQ(without_mate.images_left_out, 1);
  ExpectContains(without_mate.warnings.at(0), {"1 of 3 left images", "image_0/000001.png"});
}

TEST_F(DatasetTest, PairsEurocsStampsThatAreNearlyTheSame) {
  const fs::path root = MakeEuroc();
  WriteText(root / "mav0" / "cam1" / "data.csv",
            "#timestamp [ns],filename\n105,100.png\n195,200.jpg\n310,300.png\n411,400.png\n");
  const Dataset dataset = OpenDataset(root, {});
  ASSERT_EQ(dataset.entries.size(), 3U);  // A tenth of the step is 10.
  EXPECT_EQ(dataset.entries[1].timestamp_ns, 200);
  EXPECT_EQ(dataset.entries[1].images[1].filename(), "200.jpg");
  ExpectContains(dataset.notes.at(0), {"differ by up to 10 ns"});
  DatasetOptions options;
  options.pair_tolerance_s = 11e-9;
  EXPECT_EQ(OpenDataset(root, options).entries.size(), 4U);
  options.pair_tolerance_s = 0.0;
  ExpectContains(ErrorOf(root, options),
                 {"no image of cam0 has the same time as one of cam1", "apart", "at most 0 ns"});
  options.pair_tolerance_s = -1.0;
  ExpectContains(ErrorOf(root, options), {"--pair-tolerance"});
}

TEST_F(DatasetTest, ReadsKittisColourCamerasWithCamera0AsTheBody) {
  const fs::path root = MakeKittiOdometry();
  fs::rename(root / "image_0", root / "image_2");
  fs::rename(root / "image_1", root / "image_3");
  WriteText(root / "calib.txt",
            "P0: 20 0 16 0 0 21 12 0 0 0 1 0\nP1: 20 0 16 -10 0 21 12 0 0 0 1 0\n"
            "P2: 20 0 16 2 0 20 12 0 0 0 1 0\nP3: 20 0 16 -8 0 20 12 0 0 0 1 0\n");
  const Dataset dataset = OpenDataset(root, {});
  EXPECT_EQ(dataset.format, DatasetFormat::kKittiOdometry);
  EXPECT_EQ(dataset.entries.size(), 3U);
  EXPECT_EQ(dataset.rig.body_frame, "camera 0");
  EXPECT_TRUE(dataset.rig.body_from_cam[0].translation.isApprox(Eigen::Vector3d(-0.1, 0, 0)));
  EXPECT_TRUE(dataset.rig.right_from_left().translation.isApprox(Eigen::Vector3d(-0.5, 0, 0)));
}

TEST_F(DatasetTest, ReadsKitti360) {
  const fs::path drive = folder() / "kitti_360" / "data_2d_raw" / "drive_sync";
  for (const char* const camera : {"image_00", "image_01"}) {
    for (const char* const name : {"0000000000.png", "0000000001.png"}) {
      WriteImage(drive / camera / "data_rect" / name, 10);
    }
    WriteText(drive / camera / "timestamps.txt",
              "2013-05-28 08:46:02.100\n2013-05-28 08:46:02.203\n");
  }
  WriteText(folder() / "kitti_360" / "calibration" / "perspective.txt",
            "calib_time: 28-May-2013\nS_00: 32 24\nS_rect_00: 32 24\n"
            "P_rect_00: 20 0 16 0 0 20 12 0 0 0 1 0\nP_rect_01: 20 0 16 -12 0 20 12 0 0 0 1 0\n");
  const Dataset dataset = OpenDataset(drive, {});
  EXPECT_EQ(dataset.format, DatasetFormat::kKittiRaw);
  ASSERT_EQ(dataset.entries.size(), 2U);
  EXPECT_EQ(dataset.entries[1].timestamp_ns, 103000000);
  EXPECT_NEAR(dataset.rig.baseline(), 0.6, 1e-12);

  // Its own poses are numbered, and not of every frame.
  const fs::path poses = folder() / "kitti_360" / "data_poses" / "drive_sync" / "poses.txt";
  WriteText(poses, "1 1 0 0 5 0 1 0 6 0 0 1 7\n");
  const Dataset with_truth = OpenDataset(drive, {.groundtruth = poses});
  ASSERT_TRUE(with_truth.groundtruth.has_value());
  ASSERT_EQ(with_truth.groundtruth->size(), 1U);
  EXPECT_EQ(with_truth.groundtruth->front().timestamp_ns, 103000000);
  ExpectContains(with_truth.warnings.back(), {"cam0_to_world.txt"});
  EXPECT_EQ(ReadTrajectory(poses).front().timestamp_ns, 103000000);
  // Rows of times may be blank.
  for (const char* const camera : {"image_00", "image_01"}) {
    WriteImage(drive / camera / "data_rect" / "0000000003.png", 10);
    WriteText(drive / camera / "timestamps.txt",
              "2013-05-28 08:46:02.100\n2013-05-28 08:46:02.203\n\n2013-05-28 08:46:02.400\n");
  }
  WriteText(poses,
            "1 1 0 0 5 0 1 0 6 0 0 1 7\n2 1 0 0 5 0 1 0 6 0 0 1 7\n3 1 0 0 8 0 1 0 6 0 0 1 7\n");
  for (const Trajectory& truth :
       {*OpenDataset(drive, {.groundtruth = poses}).groundtruth, ReadTrajectory(poses)}) {
    ASSERT_EQ(truth.size(), 2U);
    EXPECT_EQ(truth[1].timestamp_ns, 300000000);
    EXPECT_EQ(truth[1].world_from_body.translation.x(), 8.0);
  }
  WriteText(poses, "7 1 0 0 5 0 1 0 6 0 0 1 7\n");
  ExpectContains(MessageOf([&] { ReadTrajectory(poses); }),
                 {"poses.txt", "frame 7", "times of 4 frames"});
  ExpectContains(ErrorOf(drive, {.groundtruth = poses}),
                 {"no pose of the data set's frames 0 to 3"});
}

TEST_F(DatasetTest, CamerasOfAnotherCalibrationAreWhereTheDataSetHasThem) {
  const fs::path euroc = MakeEuroc();
  const Dataset own = OpenDataset(euroc, {});
  WriteText(folder() / "stereo.yaml",
            "image_width: 32\nimage_height: 24\nK1: [20, 0, 16, 0, 20, 12, 0, 0, 1]\n"
            "K2: [20, 0, 16, 0, 20, 12, 0, 0, 1]\nD1: [0, 0, 0, 0, 0]\nD2: [0, 0, 0, 0, 0]\n"
            "R: [1, 0, 0, 0, 1, 0, 0, 0, 1]\nT: [-0.1, 0, 0]\n");
  const Dataset dataset = OpenDataset(euroc, {.calibration = folder() / "stereo.yaml"});
  EXPECT_EQ(dataset.rig.body_frame, own.rig.body_frame);
  EXPECT_TRUE(dataset.rig.body_from_cam[0].Matrix().isApprox(own.rig.body_from_cam[0].Matrix()));
  EXPECT_TRUE(
      dataset.rig.right_from_left().translation.isApprox(Eigen::Vector3d(-0.1, 0.0, 0.0), 1e-9));
}

TEST_F(DatasetTest, WarnsOfTheFileOfTheCameraThatIsMeant) {
  const fs::path euroc = MakeEuroc();
  Replace(euroc / "mav0" / "cam1" / "sensor.yaml", "0.0, -1.0, 0.0", "0.0, -0.99, 0.0");
  const Dataset dataset = OpenDataset(euroc, {});
  std::string named;
  for (const std::string& warning : dataset.warnings) {
    named += warning.find("the rotation in T_BS") != std::string::npos ? warning : "";
  }
  ExpectContains(named, {"cam1/sensor.yaml: the rotation in T_BS"});
  EXPECT_EQ(named.find("cam0"), std::string::npos) << named;
}

TEST_F(DatasetTest, SaysWhereTheDataSetIsAndWhatIsNone) {
  const fs::path euroc = MakeEuroc();
  ExpectContains(ErrorOf(folder()), {"did you mean", euroc.string()});
  ExpectContains(ErrorOf(euroc / "mav0" / "cam0" / "data"), {"did you mean", "euroc/mav0?"});
  fs::create_directories(folder() / "bags");
  WriteText(folder() / "bags" / "V1.bag", "#ROSBAG V2.0\n");
  ExpectContains(ErrorOf(folder() / "bags" / "V1.bag"), {"V1.bag: a ROS bag, not a folder"});
  // Two folders below.
  fs::create_directories(folder() / "all" / "sets");
  fs::rename(euroc, folder() / "all" / "sets" / "V1");
  ExpectContains(ErrorOf(folder() / "all"), {"did you mean", "all/sets/V1?"});
  fs::remove_all(folder() / "all");
  ExpectContains(ErrorOf(folder() / "bags"), {"V1.bag in it is a ROS bag", "extracted"});
  WriteText(folder() / "a.zip", "PK\x03\x04");
  ExpectContains(ErrorOf(folder() / "a.zip"), {"a zip archive, not a folder"});
}

TEST_F(DatasetTest, NamesImagesThatCannotBeRead) {
  const fs::path root = MakeEuroc();
  const fs::path data = root / "mav0" / "cam1" / "data";
  const auto read_error = [&](std::size_t index) {
    const Dataset dataset = OpenDataset(root, {});
    return MessageOf([&] { dataset.Read(index); });
  };
  EXPECT_EQ(read_error(0), "no error");
  WriteImage(data / "100.png", 1, kWidth, kHeight + 1);
  ExpectContains(read_error(0),
                 {"cam1/data/100.png", "32 x 25", "expected 32 x 24", "cam0/sensor.yaml"});
  Shorten(data / "200.jpg");
  ExpectContains(read_error(1), {"cam1/data/200.jpg"});
  WriteText(data / "300.png", "no image");
  ExpectContains(read_error(2), {"cam1/data/300.png"});
  WriteText(data / "400.png", "");
  ExpectContains(read_error(3), {"cam1/data/400.png"});
  const Dataset dataset = OpenDataset(root, {});
  fs::remove(data / "400.png");
  ExpectContains(MessageOf([&] { dataset.Read(3); }), {"cam1/data/400.png: no such image"});
}

TEST_F(DatasetTest, ReadsSixteenBitsAndColourAsGray) {
  const fs::path root = MakeEuroc();
  const fs::path data = root / "mav0" / "cam0" / "data";
  cv::imwrite((data / "100.png").string(), cv::Mat(kHeight, kWidth, CV_16UC1, cv::Scalar(77 << 8)));
  cv::imwrite((data / "300.png").string(),
              cv::Mat(kHeight, kWidth, CV_8UC3, cv::Scalar(50, 50, 50)));
  const Dataset dataset = OpenDataset(root, {});
  EXPECT_EQ(dataset.Read(0).images[0].at<unsigned char>(1, 1), 77);
  EXPECT_EQ(dataset.Read(2).images[0].at<unsigned char>(1, 1), 50);
}

TEST_F(DatasetTest, ReadsTumVi) {
  const fs::path root = MakeEuroc();
  const fs::path mav0 = root / "mav0";
  for (const char* const camera : {"cam0", "cam1"}) {
    WriteText(mav0 / camera / "sensor.yaml",
              SensorYaml(camera[3] == '0' ? 0.0 : 1.0, "equidistant"));
  }
  EXPECT_EQ(OpenDataset(root, {}).rig.cameras[1].distortion, Distortion::kEquidistant);

  // Without sensor.yaml, and with the motion capture system's poses of the IMU.
  fs::remove(mav0 / "cam0" / "sensor.yaml");
  fs::remove(mav0 / "cam1" / "sensor.yaml");
  fs::rename(mav0 / "state_groundtruth_estimate0", mav0 / "mocap0");
  const std::string camera =
      "  camera_model: pinhole\n  distortion_model: equidistant\n"
      "  distortion_coeffs: [0.003, 0.0007, -0.002, 0.0002]\n  intrinsics: [20, 21, 16, 12]\n"
      "  resolution: [32, 24]\n";
  WriteText(root / "dso" / "camchain.yaml",
            "cam0:\n  T_cam_imu:\n  - [1.0, 0.0, 0.0, 0.5]\n  - [0.0, 1.0, 0.0, 0.0]\n"
            "  - [0.0, 0.0, 1.0, 0.0]\n  - [0.0, 0.0, 0.0, 1.0]\n" +
                camera +
                "cam1:\n  T_cam_imu:\n  - [1.0, 0.0, 0.0, 0.4]\n  - [0.0, 1.0, 0.0, 0.0]\n"
                "  - [0.0, 0.0, 1.0, 0.0]\n  - [0.0, 0.0, 0.0, 1.0]\n" +
                camera);
  for (const fs::path& path : {root, mav0}) {
    const Dataset dataset = OpenDataset(path, {});
    EXPECT_EQ(dataset.rig.cameras[0].coefficients[2], -0.002);
    EXPECT_EQ(dataset.rig.body_frame, "imu (body)");
    EXPECT_TRUE(dataset.rig.body_from_cam[0].translation.isApprox(Eigen::Vector3d(-0.5, 0, 0)));
    EXPECT_TRUE(
        dataset.rig.right_from_left().translation.isApprox(Eigen::Vector3d(-0.1, 0.0, 0.0)));
    EXPECT_TRUE(dataset.groundtruth);
  }
}

TEST_F(DatasetTest, ReadsKittiOdometry) {
  const fs::path root = MakeKittiOdometry();
  WriteText(root / "image_0" / "._000000.png", "a trace of another system");
  WriteText(root / "image_0" / "list.txt", "");
  for (const fs::path& path : {root, root / ""}) {
    const Dataset dataset = OpenDataset(path, {});
    EXPECT_EQ(dataset.format, DatasetFormat::kKittiOdometry);
    ASSERT_EQ(dataset.entries.size(), 3U);
    EXPECT_EQ(dataset.entries[1].timestamp_ns, 103600000);
    EXPECT_EQ(dataset.entries[2].timestamp_ns, 310800000);  // Number 3 has row 3.
    EXPECT_EQ(dataset.rig.body_frame, "left camera");
    EXPECT_EQ(dataset.rig.cameras[1].fy, 21.0);
    EXPECT_EQ(dataset.rig.cameras[1].distortion, Distortion::kNone);
    EXPECT_TRUE(dataset.rig.right_from_left().translation.isApprox(Eigen::Vector3d(-0.5, 0, 0)));
    EXPECT_FALSE(dataset.groundtruth);
    EXPECT_EQ(dataset.Read(2).images[1].at<unsigned char>(0, 0), 20);
  }
  std::string poses;
  for (int i = 0; i < 5; ++i) {
    poses += "1 0 0 " + std::to_string(i) + " 0 1 0 0 0 0 1 0\n";
  }
  WriteText(folder() / "kitti" / "poses" / "06.txt", poses);
  DatasetOptions options;
  options.count = 1;
  EXPECT_EQ(OpenDataset(root, options).groundtruth->at(4).timestamp_ns, 414400000);
  WriteText(folder() / "other.txt", poses);
  options.groundtruth = folder() / "other.txt";
  EXPECT_EQ(OpenDataset(root, options).groundtruth->size(), 5U);
}

TEST_F(DatasetTest, NamesWhatIsWrongWithKittiOdometry) {
  const auto broken = [&](const std::function<void(const fs::path&)>& breaking) {
    fs::remove_all(folder() / "kitti");
    const fs::path root = MakeKittiOdometry();
    breaking(root);
    return ErrorOf(root);
  };
  ExpectContains(broken([](const fs::path& root) { fs::remove_all(root / "image_1"); }),
                 {"06/image_1: no such folder"});
  ExpectContains(broken([](const fs::path& root) { fs::remove_all(root / "image_0"); }),
                 {"06/image_0: no such folder"});
  ExpectContains(broken([](const fs::path& root) {
                   fs::remove_all(root / "image_1");
                   WriteImage(root / "image_1" / "000004.png", 1);
                 }),
                 {"image_0: no image has the same number as one in ", "image_1"});
  ExpectContains(broken([](const fs::path& root) {
                   fs::remove_all(root / "image_1");
                   WriteText(root / "image_1" / "000000.raw", "");
                 }),
                 {"image_1: no images in it", "\".raw\" (1)", ".png"});
  ExpectContains(broken([](const fs::path& root) { WriteImage(root / "image_0" / "1.png", 1); }),
                 {"1.png: has the same number"});
  ExpectContains(broken([](const fs::path& root) { fs::remove(root / "calib.txt"); }),
                 {"calib.txt: no such file"});
  ExpectContains(broken([](const fs::path& root) { fs::remove(root / "times.txt"); }),
                 {"times.txt: no such file"});
  ExpectContains(broken([](const fs::path& root) { WriteText(root / "times.txt", "0\n1\n2\n"); }),
                 {"times.txt: has 3 times, none for", "000003.png"});
  ExpectContains(
      broken([](const fs::path& root) { WriteText(root / "times.txt", "0\n1\n1\n2\n"); }),
      {"times.txt:3: "});
  ExpectContains(broken([](const fs::path& root) {
                   for (const char* const name : {"000000.png", "000001.png", "000003.png"}) {
                     Shorten(root / "image_0" / name);
                   }
                 }),
                 {"image_0/000000.png"});
  const auto calibration = [&](const std::string& from, const std::string& to) {
    return broken([&](const fs::path& root) { Replace(root / "calib.txt", from, to); });
  };
  ExpectContains(calibration("P1", "P2"), {"calib.txt: no P1"});
  ExpectContains(calibration("P0: 20 ", "P0: "), {"calib.txt: P0 has 11 numbers, expected 12"});
  ExpectContains(calibration("P0: 20 ", "P0: none "), {"calib.txt: no P0"});
  ExpectContains(calibration("-10", "10"), {"calib.txt: P1 has a baseline of -0.5"});
  ExpectContains(calibration("-10", "0"), {"calib.txt: P1 has a baseline of"});
  ExpectContains(calibration("P0: 20", "P0: 0"), {"calib.txt: P0", "focal lengths"});
  ExpectContains(calibration("P0: ", "P0 "), {"calib.txt:1: "});
  DatasetOptions options;
  options.calibration = Camchain();
  ExpectContains(ErrorOf(MakeKittiOdometry(), options), {"--calibration"});
}

TEST_F(DatasetTest, ReadsRectifiedKittiRaw) {
  for (const char* const end_of_line : {"\n", "\r\n", "\r"}) {
    const Dataset dataset = OpenDataset(MakeKittiRaw(kWidth, kHeight, end_of_line), {});
    EXPECT_EQ(dataset.format, DatasetFormat::kKittiRaw);
    ASSERT_EQ(dataset.entries.size(), 2U);
    // After the first row, which has no image: 400 ms, and 750.000122 ms over the end of a month.
    EXPECT_EQ(dataset.entries[0].timestamp_ns, 400000000);
    EXPECT_EQ(dataset.entries[1].timestamp_ns, 750000122);
    EXPECT_EQ(dataset.rig.body_frame, "left camera");
    EXPECT_EQ(dataset.rig.cameras[0].fx, 20.0);
    EXPECT_EQ(dataset.rig.cameras[0].distortion, Distortion::kNone);
    EXPECT_TRUE(dataset.rig.right_from_left().translation.isApprox(Eigen::Vector3d(-0.54, 0, 0)));
    EXPECT_TRUE(dataset.rig.right_from_left().rotation.isApprox(Eigen::Quaterniond::Identity()));
  }
}

TEST_F(DatasetTest, ReadsUnrectifiedKittiRaw) {
  const fs::path root = MakeKittiRaw(40, 30);
  const Dataset dataset = OpenDataset(root / "", {});
  const Camera& right = dataset.rig.cameras[1];
  EXPECT_EQ(right.width, 40);
  EXPECT_EQ(right.height, 30);
  EXPECT_EQ(right.fx, 25.5);
  EXPECT_EQ(right.fy, 26.5);
  EXPECT_EQ(right.cx, 20.5);
  EXPECT_EQ(right.cy, 15.5);
  EXPECT_EQ(right.distortion, Distortion::kRadialTangential);
  EXPECT_EQ(right.coefficients, (DistortionCoefficients{-0.31, 0.21, 0.0011, 0.0021, -0.06}));
  // R_01 and T_01 take points of camera 0 to camera 1: x to y.
  EXPECT_TRUE((dataset.rig.right_from_left() * Eigen::Vector3d(1.0, 0.0, 0.0))
                  .isApprox(Eigen::Vector3d(-0.5, 1.01, 0.02)));
  EXPECT_EQ(dataset.Read(0).images[1].cols, 40);
}

TEST_F(DatasetTest, FindsTheCalibrationUpToThreeFoldersAbove) {
  const fs::path root = MakeKittiRaw();
  const fs::path day = root.parent_path();
  const fs::path name = "calib_cam_to_cam.txt";
  fs::rename(day / name, root / name);
  EXPECT_NO_THROW(OpenDataset(root, {}));
  fs::rename(root / name, folder() / name);  // raw, day, drive.
  EXPECT_NO_THROW(OpenDataset(root, {}));
  fs::remove(folder() / name);
  ExpectContains(ErrorOf(root), {"no calib_cam_to_cam.txt"});
}

TEST_F(DatasetTest, NamesWhatIsWrongWithKittiRaw) {
  const auto broken = [&](const std::function<void(const fs::path&)>& breaking) {
    fs::remove_all(folder() / "raw");
    const fs::path root = MakeKittiRaw();
    breaking(root);
    return ErrorOf(root);
  };
  ExpectContains(broken([](const fs::path& root) { fs::remove_all(root / "image_01"); }),
                 {"image_01/data: no such folder"});
  ExpectContains(broken([](const fs::path& root) { fs::remove_all(root / "image_00"); }),
                 {"image_00/data: no such folder"});
  const auto times = [&](const std::string& from, const std::string& to) {
    return broken(
        [&](const fs::path& root) { Replace(root / "image_00" / "timestamps.txt", from, to); });
  };
  ExpectContains(
      broken([](const fs::path& root) { fs::remove(root / "image_00" / "timestamps.txt"); }),
      {"image_00/timestamps.txt: no such file"});
  ExpectContains(times("2011-10-01 00:00:00.250000123\n", ""),
                 {"timestamps.txt: has no time in row 5 of 4", "0000000004.png"});
  // A row without a time stays a row.
  EXPECT_EQ(times("2011-09-30 23:59:59.600000001", ""), "no error");
  ExpectContains(times("2011-09-30 23:59:59.900000001", ""), {"row 3 of 5", "0000000002.png"});
  ExpectContains(times("2011-10-01 ", "2011-09-31 "), {"timestamps.txt:5: "});
  ExpectContains(times("2011-10-01 ", "2011-13-01 "), {"timestamps.txt:5: "});
  ExpectContains(times("00:00:00.25", "00:00:99999999999.25"), {"timestamps.txt:5: "});
  ExpectContains(times("2011-10-01 ", "1317427200"), {"timestamps.txt:5: "});
  ExpectContains(times("2011-10-01 00:00:00.25", "2010-10-01 00:00:00.25"),
                 {"0000000004.png: its time is not after"});
  const auto calibration = [&](const std::string& from, const std::string& to) {
    return broken([&](const fs::path& root) {
      Replace(root.parent_path() / "calib_cam_to_cam.txt", from, to);
    });
  };
  ExpectContains(calibration("S_rect_00: 32 24", "S_rect_00: 33 24"),
                 {"0000000002.png", "32 x 24", "S_00", "S_rect_00"});
  ExpectContains(calibration("P_rect_01", "P_rect_09"), {"calib_cam_to_cam.txt: no P_rect_01"});
  ExpectContains(calibration("-10.8", "10.8"), {"P_rect_01 has a baseline of -0.54"});
  const auto unrectified = [&](const std::string& from, const std::string& to) {
    fs::remove_all(folder() / "raw");
    const fs::path root = MakeKittiRaw(40, 30);
    Replace(root.parent_path() / "calib_cam_to_cam.txt", from, to);
    return ErrorOf(root);
  };
  ExpectContains(unrectified("K_01", "L_01"), {"calib_cam_to_cam.txt: no K_01"});
  ExpectContains(unrectified("R_01: 0 -1", "R_01: 0 -2"), {"R_01 is not a rigid transform"});
  ExpectContains(unrectified("T_01: -0.5 0.01 0.02", "T_01: 0 0 0"), {"in the same place"});
}

TEST_F(DatasetTest, ReadsPlainFoldersWithACamchain) {
  DatasetOptions options;
  options.calibration = Camchain();
  const fs::path root = MakePlain({"1403715273262142976.png", "1403715273312143104.png"});
  WriteImage(root / "left" / "1403715273362142976.png", 1);  // Without a mate: left out.
  const Dataset dataset = OpenDataset(root, options);
  EXPECT_EQ(dataset.format, DatasetFormat::kPlain);
  ASSERT_EQ(dataset.entries.size(), 2U);
  EXPECT_EQ(dataset.entries[1].timestamp_ns, 1403715273312143104);
  EXPECT_EQ(dataset.entries[1].images[1], root / "right" / "1403715273312143104.png");
  EXPECT_EQ(dataset.rig.body_frame, "left camera");
  EXPECT_EQ(dataset.rig.cameras[0].distortion, Distortion::kEquidistant);
  EXPECT_EQ(dataset.rig.cameras[1].distortion, Distortion::kRadialTangential);
  EXPECT_EQ(dataset.rig.cameras[1].cx, 15.0);
  EXPECT_TRUE((dataset.rig.right_from_left() * Eigen::Vector3d::Zero())
                  .isApprox(Eigen::Vector3d(-0.1, 0.01, 0.02)));
  EXPECT_EQ(dataset.Read(0).images[0].at<unsigned char>(0, 0), 10);
}

TEST_F(DatasetTest, TakesPlainTimesFromNames) {
  DatasetOptions options;
  options.calibration = Camchain();
  const auto times = [&](const std::vector<std::string>& names) {
    fs::remove_all(folder() / "plain");
    std::vector<int64_t> result;
    for (const Dataset::Entry& entry : OpenDataset(MakePlain(names), options).entries) {
      result.push_back(entry.timestamp_ns);
    }
    return result;
  };
  EXPECT_EQ(times({"9.5.png", "10.25.png"}), (std::vector<int64_t>{9500000000, 10250000000}));
  EXPECT_EQ(times({"1341847980.722988.png", "1341847981.726650.png"}),
            (std::vector<int64_t>{1341847980722988000, 1341847981726650000}));
  EXPECT_EQ(times({"000010.png", "000011.png"}), (std::vector<int64_t>{0, 100000000}));
  EXPECT_EQ(times({"1403715273262142976.png", "a.png"}), (std::vector<int64_t>{0, 100000000}));
  // Numbered without leading zeros, the second image is the second.
  fs::remove_all(folder() / "plain");
  const Dataset dataset = OpenDataset(MakePlain({"f10.png", "f2.png", "f1.png"}), options);
  EXPECT_EQ(dataset.entries[1].images[0].filename(), "f2.png");
  EXPECT_EQ(dataset.entries[2].images[0].filename(), "f10.png");
  // A gap in the numbers is one in the times.
  EXPECT_EQ(dataset.entries[2].timestamp_ns, 900000000);
}

constexpr const char* kOpenCvCalibration =
    "%YAML:1.0\n---\nimage_width: 32\nimage_height: 24\n"
    "K1: !!opencv-matrix\n   rows: 3\n   cols: 3\n   dt: d\n"
    "   data: [ 2.0e+01, 0., 1.6e+01, 0., 21., 12., 0., 0., 1. ]\n"
    "D1: !!opencv-matrix\n   rows: 1\n   cols: 5\n   dt: d\n"
    "   data: [ -0.28, 0.07, 0.0002, 0., 0.01 ]\n"
    "K2: !!opencv-matrix\n   rows: 3\n   cols: 3\n   dt: d\n"
    "   data: [ 22., 0., 15., 0., 23., 11., 0., 0., 1. ]\n"
    "D2: !!opencv-matrix\n   rows: 1\n   cols: 14\n   dt: d\n"
    "   data: [ -0.2, 0.05, 0., 0., 0., 0., 0., 0., 0., 0., 0., 0., 0., 0. ]\n"
    "R: !!opencv-matrix\n   rows: 3\n   cols: 3\n   dt: d\n"
    "   data: [ 0., -1., 0., 1., 0., 0., 0., 0., 1. ]\n"
    "T: !!opencv-matrix\n   rows: 3\n   cols: 1\n   dt: d\n   data: [ -0.12, 0., 0.01 ]\n";

TEST_F(DatasetTest, ReadsOpenCvsCalibration) {
  DatasetOptions options;
  options.calibration = folder() / "stereo.yml";
  const fs::path root = MakePlain({"1.png"});
  WriteText(*options.calibration, kOpenCvCalibration);
  const StereoRig rig = OpenDataset(root, options).rig;
  EXPECT_EQ(rig.cameras[0].fx, 20.0);
  EXPECT_EQ(rig.cameras[0].coefficients, (DistortionCoefficients{-0.28, 0.07, 0.0002, 0.0, 0.01}));
  EXPECT_EQ(rig.cameras[1].coefficients[1], 0.05);
  EXPECT_EQ(rig.cameras[1].cy, 11.0);
  EXPECT_EQ(rig.body_frame, "left camera");
  EXPECT_TRUE((rig.right_from_left() * Eigen::Vector3d(1.0, 0.0, 0.0))
                  .isApprox(Eigen::Vector3d(-0.12, 1.0, 0.01)));

  const auto changed = [&](const std::string& from, const std::string& to) {
    WriteText(*options.calibration, kOpenCvCalibration);
    Replace(*options.calibration, from, to);
    return ErrorOf(root, options);
  };
  EXPECT_EQ(changed("K1", "M1"), "no error");
  EXPECT_EQ(changed("image_width: 32\nimage_height: 24", "image_size: [ 32, 24 ]"), "no error");
  ExpectContains(changed("K2", "Q2"), {"stereo.yml: no matrices of two cameras", "Q2"});
  ExpectContains(changed("D2", "Q2"), {"stereo.yml: no distortion coefficients beside K2", "Q2"});
  ExpectContains(changed("T:", "U:"), {"stereo.yml: no R and T"});
  EXPECT_EQ(changed("image_width", "breadth"), "no error");  // The images tell their size.
  ExpectContains(changed("0., 0., 0. ]\nR", "0., 0., 0.1 ]\nR"), {"D2 has 14 coefficients"});
  ExpectContains(changed("-0.12, 0., 0.01", "-120., 0., 10."),
                 {"stereo.yml: a baseline of 120", "millimetres"});
  ExpectContains(changed("-0.12, 0., 0.01", "0., 0., 0."), {"in the same place"});
  ExpectContains(changed("-1., 0., 1.", "-1., 0., 2."), {"R is not a rigid transform"});
}

TEST_F(DatasetTest, NamesWhatIsWrongWithPlainFolders) {
  const fs::path root = MakePlain({"1.png"});
  ExpectContains(ErrorOf(root), {"--calibration"});
  DatasetOptions options;
  options.calibration = folder() / "missing.yaml";
  ExpectContains(ErrorOf(root, options), {"missing.yaml: no such file"});
  options.calibration = Camchain();
  Replace(*options.calibration, "cam1:", "cam7:");
  ExpectContains(ErrorOf(root, options), {"camchain.yaml: no cam1"});
  Camchain();
  Replace(*options.calibration, "T_cn_cnm1", "T_other");
  ExpectContains(ErrorOf(root, options), {"camchain.yaml: cam1 has no T_cn_cnm1"});
  Camchain();
  fs::rename(root / "right" / "1.png", root / "right" / "2.png");
  ExpectContains(ErrorOf(root, options), {"plain/left", "plain/right", "same number"});
  fs::remove_all(root / "right");
  options.format = DatasetFormat::kPlain;
  ExpectContains(ErrorOf(root, options), {"no two folders"});
}

TEST_F(DatasetTest, SaysWhatItLookedFor) {
  fs::create_directories(folder() / "empty");
  ExpectContains(ErrorOf(folder() / "empty"),
                 {"empty: ", "mav0", "image_0", "image_00", "left and right"});
  WriteText(folder() / "file", "");
  ExpectContains(ErrorOf(folder() / "file"), {"file: a file, not a folder"});
  DatasetOptions options;
  options.format = DatasetFormat::kKittiRaw;
  ExpectContains(ErrorOf(MakeEuroc(), options), {"image_00/data: no such folder"});
}

TEST_F(DatasetTest, EurocTakesAnotherCalibration) {
  DatasetOptions options;
  options.calibration = Camchain();
  EXPECT_EQ(OpenDataset(MakeEuroc(), options).rig.cameras[0].fx, 20.0);
}

TEST(SharedDatasetTest, OpensTheRealOnes) {
  const fs::path data = fs::path(GLUEVO_SHARED_DIR) / "data";
  if (!fs::exists(data)) {
    GTEST_SKIP() << data << " is not there";
  }
  const Dataset euroc = OpenDataset(data / "euroc_V1_01_keyframes", {});
  EXPECT_EQ(euroc.entries.size(), 100U);
  EXPECT_NEAR(euroc.rig.baseline(), 0.110, 0.001);  // As EuRoC's paper says, 11 cm.
  EXPECT_TRUE(euroc.groundtruth);
  EXPECT_EQ(euroc.Read(99).images[1].size(), cv::Size(752, 480));
  const Dataset kitti = OpenDataset(data / "kitti" / "sequences" / "06", {});
  EXPECT_EQ(kitti.entries.size(), 51U);
  EXPECT_NEAR(kitti.rig.baseline(), 0.537, 0.001);  // 379.8145 / 707.0912.
  EXPECT_EQ(kitti.groundtruth->size(), 51U);
  EXPECT_EQ(kitti.Read(50).images[0].size(), cv::Size(1226, 370));
}

}  // namespace
}  // namespace gluevo::vo
