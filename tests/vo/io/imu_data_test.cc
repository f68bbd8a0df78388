// What goes wrong between an inertial unit and its file, one line each.

#include "gluevo/vo/io/imu_data.h"

#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <functional>
#include <iomanip>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <sstream>
#include <string>
#include <vector>

#include "gluevo/nn/error.h"
#include "gluevo/vo/io/dataset.h"
#include "imu_faults.h"
#include "imu_source.h"
#include "message_of.h"
#include "temporary_folder.h"

namespace gluevo::vo {
namespace {

namespace fs = std::filesystem;

constexpr int64_t kStepNs = 5'000'000;
constexpr int64_t kSecondNs = 1'000'000'000;
constexpr int kRate = 200;

void WriteText(const fs::path& path, const std::string& text) {
  fs::create_directories(path.parent_path());
  std::ofstream(path, std::ios::binary) << text;
}

/// Hand-held: no two samples are the same.
ImuSample SampleAt(int64_t time_ns) {
  const double t = 1e-9 * static_cast<double>(time_ns);
  return {time_ns,
          {0.3 * std::sin(2.0 * t), 0.2 * std::cos(3.0 * t), 0.1 * std::sin(t)},
          {0.5 * std::sin(5.0 * t), 0.4 * std::cos(4.0 * t), 9.7 + 0.3 * std::sin(6.0 * t)}};
}

std::vector<ImuSample> Samples(int seconds) {
  std::vector<ImuSample> samples;
  samples.reserve(static_cast<std::size_t>(kRate) * seconds + 1);
  for (int i = 0; i <= kRate * seconds; ++i) {
    samples.push_back(SampleAt(i * kStepNs));
  }
  return samples;
}

std::string TextOf(const std::vector<ImuSample>& samples) {
  std::ostringstream text;
  text << std::setprecision(17) << "#timestamp [ns],wx,wy,wz,ax,ay,az\n";
  for (const ImuSample& sample : samples) {
    text << sample.timestamp_ns;
    for (const Eigen::Vector3d& vector : {sample.angular_velocity, sample.specific_force}) {
      text << ',' << vector.x() << ',' << vector.y() << ',' << vector.z();
    }
    text << '\n';
  }
  return text.str();
}

std::string All(const std::vector<std::string>& sentences) {
  std::string all;
  for (const std::string& sentence : sentences) {
    all += sentence;
    all += '\n';
  }
  return all;
}

class ImuDataTest : public testing::Test {
 protected:
  const fs::path& folder() const { return folder_.path(); }

  ImuData Read(const std::vector<ImuSample>& samples) const {
    const fs::path path = folder() / "imu.csv";
    WriteText(path, TextOf(samples));
    return ReadImuTable(path);
  }
  /// Exactly one warning, which has this in it.
  static void ExpectWarning(const ImuData& data, const std::string& part) {
    EXPECT_EQ(data.refused, "");
    ASSERT_EQ(data.warnings.size(), 1U) << All(data.warnings);
    EXPECT_NE(data.warnings[0].find(part), std::string::npos) << data.warnings[0];
  }
  static void ExpectRefused(const ImuData& data, const std::string& part) {
    EXPECT_NE(data.refused.find(part), std::string::npos) << data.refused;
    EXPECT_EQ(data.refused.find('\n'), std::string::npos) << data.refused;
  }

  /// Pairs at 0, 100, ... 1000 ms in EuRoC's layout.
  fs::path MakeEuroc() const {
    const fs::path mav0 = folder() / "euroc" / "mav0";
    for (int camera = 0; camera < 2; ++camera) {
      const fs::path root = mav0 / ("cam" + std::to_string(camera));
      fs::create_directories(root / "data");
      std::string csv = "#timestamp [ns],filename\n";
      for (int i = 0; i <= 10; ++i) {
        const std::string name = std::to_string(i * kSecondNs / 10) + ".png";
        cv::imwrite((root / "data" / name).string(), cv::Mat(24, 32, CV_8UC1, cv::Scalar(i)));
        csv += std::to_string(i * kSecondNs / 10) + ',' + name + '\n';
      }
      WriteText(root / "data.csv", csv);
      WriteText(root / "sensor.yaml",
                "sensor_type: camera\nT_BS:\n  cols: 4\n  rows: 4\n  data: [1, 0, 0, " +
                    std::to_string(0.1 * camera) +
                    ", 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]\nresolution: [32, 24]\n"
                    "camera_model: pinhole\nintrinsics: [20, 20, 16, 12]\n"
                    "distortion_model: radial-tangential\n"
                    "distortion_coefficients: [0, 0, 0, 0]\n");
    }
    return folder() / "euroc";
  }
  static void AddImuTo(const fs::path& root, const std::vector<ImuSample>& samples) {
    WriteText(root / "mav0/imu0/data.csv", TextOf(samples));
    WriteText(root / "mav0/imu0/sensor.yaml",
              "T_BS:\n  data: [0, -1, 0, 0.1, 1, 0, 0, 0.2, 0, 0, 1, 0.3, 0, 0, 0, 1]\n"
              "rate_hz: 200\ngyroscope_noise_density: 2e-4\ngyroscope_random_walk: 3e-5\n"
              "accelerometer_noise_density: 4e-3\naccelerometer_random_walk: 5e-4\n");
  }

 private:
  TemporaryFolder folder_;
};

TEST_F(ImuDataTest, GoodDataComeAsTheyAre) {
  const ImuData data = Read(Samples(5));
  EXPECT_EQ(data.refused, "");
  EXPECT_TRUE(data.warnings.empty()) << All(data.warnings);
  EXPECT_EQ(data.samples.size(), 1001U);
  EXPECT_DOUBLE_EQ(data.rate_hz, 200.0);
  EXPECT_EQ(data.samples[7].specific_force, SampleAt(7 * kStepNs).specific_force);
  EXPECT_TRUE(std::isinf(data.largest_rate));
  EXPECT_TRUE(std::isinf(data.largest_force));
}

TEST_F(ImuDataTest, SortsAndDropsByTime) {
  std::vector<ImuSample> samples = Samples(5);
  std::swap(samples[100], samples[101]);
  ExpectWarning(Read(samples), "1 sample not in order of time: sorted");
  EXPECT_EQ(Read(samples).samples[100].timestamp_ns, 100 * kStepNs);
  samples = Samples(5);
  samples.insert(samples.begin() + 50, samples[49]);
  samples.insert(samples.begin() + 20, samples[20]);
  samples[20].specific_force.x() += 1.0;
  const ImuData data = Read(samples);
  ExpectWarning(data, "2 samples with the time of another left out");
  EXPECT_EQ(data.samples.size(), 1001U);
  for (ImuSample& sample : samples) {
    sample.timestamp_ns -= sample.timestamp_ns % (4 * kStepNs);
  }
  ExpectRefused(Read(samples), "too few digits");
}

TEST_F(ImuDataTest, CountsGapsAndNamesTheLongest) {
  std::vector<ImuSample> samples = Samples(5);
  samples.erase(samples.begin() + 700, samples.begin() + 750);
  samples.erase(samples.begin() + 200, samples.begin() + 204);
  const ImuData data = Read(samples);
  ExpectWarning(data, "2 gaps without samples, the longest of 255 ms, 3.495 s after the first");
}

TEST_F(ImuDataTest, TellsWhereASensorEnds) {
  std::vector<ImuSample> samples = Samples(5);
  for (int i = 300; i < 320; ++i) {
    samples[i].specific_force.x() = i % 2 == 0 ? 39.2266 : -39.2266;
  }
  const ImuData data = Read(samples);
  ExpectWarning(data, "the accelerometer ends at 39.23 m/s^2, in 20 readings");
  EXPECT_DOUBLE_EQ(data.largest_force, 39.2266);
  EXPECT_TRUE(std::isinf(data.largest_rate));
  samples = Samples(5);
  for (int i = 300; i < 303; ++i) {
    samples[i].angular_velocity.z() = 4.36;
  }
  EXPECT_DOUBLE_EQ(Read(samples).largest_rate, 4.36);
  // At rest readings are often the same, and far from any sensor's range.
  for (ImuSample& sample : samples) {
    sample.angular_velocity = {0.01, 0.02, 0.03};
    sample.specific_force.z() = 9.81;
  }
  EXPECT_TRUE(std::isinf(Read(samples).largest_rate));
  EXPECT_TRUE(std::isinf(Read(samples).largest_force));
}

TEST_F(ImuDataTest, IgnoresAStuckSensor) {
  std::vector<ImuSample> samples = Samples(6);
  for (int i = 400; i < 650; ++i) {
    samples[i].angular_velocity = samples[400].angular_velocity;
    samples[i].specific_force = samples[400].specific_force;
  }
  const ImuData data = Read(samples);
  ExpectWarning(data, "repeats its numbers for over a second, once, for 1.245 s");
  EXPECT_EQ(data.samples.size(), 1201U - 250U);
  // Half a second of the same may be.
  samples = Samples(6);
  for (int i = 400; i < 500; ++i) {
    samples[i].angular_velocity = samples[400].angular_velocity;
    samples[i].specific_force = samples[400].specific_force;
  }
  EXPECT_EQ(Read(samples).samples.size(), 1201U);
  for (ImuSample& sample : samples) {
    sample = {sample.timestamp_ns, {0.0, 0.0, 0.1}, {0.0, 0.0, 9.8}};
  }
  ExpectRefused(Read(samples), "stuck");
}

TEST_F(ImuDataTest, ConvertsUnitsThatGravityTells) {
  for (const double unit : {9.80665, 9.80665e-3}) {
    std::vector<ImuSample> samples = Samples(2);
    for (ImuSample& sample : samples) {
      sample.specific_force /= unit;
    }
    const ImuData data = Read(samples);
    ExpectWarning(data, "of g");
    EXPECT_NEAR(data.samples[9].specific_force.z(), SampleAt(9 * kStepNs).specific_force.z(), 1e-9);
  }
  std::vector<ImuSample> samples = Samples(2);
  for (ImuSample& sample : samples) {
    sample.specific_force.z() -= 9.8;
  }
  ExpectRefused(Read(samples), "gravity taken away");
  for (ImuSample& sample : samples) {
    sample.specific_force = 5.0 * SampleAt(sample.timestamp_ns).specific_force;
  }
  ExpectWarning(Read(samples), "in the median, expected about 9.8");
}

TEST_F(ImuDataTest, ConvertsDegreesThatNoSensorMeasuresAsRadians) {
  std::vector<ImuSample> samples = Samples(10);
  for (ImuSample& sample : samples) {
    sample.angular_velocity *= 3.0 * 180.0 / M_PI;
  }
  const ImuData data = Read(samples);
  ExpectWarning(data, "degrees a second");
  EXPECT_NEAR(data.samples[9].angular_velocity.y(),
              3.0 * SampleAt(9 * kStepNs).angular_velocity.y(), 1e-9);
  // A glitch is none.
  samples = Samples(10);
  samples[5].angular_velocity.x() = 500.0;
  EXPECT_TRUE(Read(samples).warnings.empty());
}

TEST_F(ImuDataTest, RefusesWhatIsTooSlow) {
  std::vector<ImuSample> samples;
  samples.reserve(100);
  for (int i = 0; i < 100; ++i) {
    samples.push_back(SampleAt(i * kSecondNs / 10));
  }
  ExpectRefused(Read(samples), "10.00 samples a second, expected at least 50");
  ExpectRefused(Read({SampleAt(0)}), "0.00 samples a second");
}

TEST_F(ImuDataTest, ReadsCalibrationsOfSeveralTools) {
  const auto read = [&](const std::string& text) {
    WriteText(folder() / "imu.yaml", text);
    return ReadImuCalibration(folder() / "imu.yaml");
  };
  const std::string kalibr =
      "accelerometer_noise_density: 0.0028\naccelerometer_random_walk: 0.00086\n"
      "gyroscope_noise_density: 0.00016\ngyroscope_random_walk: 2.2e-05\nrostopic: /imu0\n"
      "update_rate: 200.0\n";
  for (const std::string& text :
       {kalibr,
        std::string("imu0:\n  T_i_b:\n  - [1.0, 0.0, 0.0, 0.0]\n  - [0.0, 1.0, 0.0, 0.0]\n"
                    "  - [0.0, 0.0, 1.0, 0.0]\n  - [0.0, 0.0, 0.0, 1.0]\n"
                    "  accelerometer_noise_density: 0.0028\n"
                    "  accelerometer_random_walk: 0.00086\n"
                    "  gyroscope_noise_density: 0.00016\n"
                    "  gyroscope_random_walk: 2.2e-05\n"),
        std::string("%YAML:1.0\n---\nacc_n: 0.0028\ngyr_n: 0.00016\nacc_w: 0.00086\n"
                    "gyr_w: 2.2e-05\ng_norm: 9.81\n"),
        std::string("%YAML:1.0\nIMU.NoiseGyro: 0.00016\nIMU.NoiseAcc: 0.0028\n"
                    "IMU.GyroWalk: 2.2e-05\nIMU.AccWalk: 0.00086\n")}) {
    const ImuCalibration calibration = read(text);
    ASSERT_TRUE(calibration.noise) << text;
    EXPECT_EQ(calibration.noise->gyroscope_density, 0.00016);
    EXPECT_EQ(calibration.noise->gyroscope_random_walk, 2.2e-5);
    EXPECT_EQ(calibration.noise->accelerometer_density, 0.0028);
    EXPECT_EQ(calibration.noise->accelerometer_random_walk, 0.00086);
    EXPECT_TRUE(calibration.warnings.empty());
    EXPECT_EQ(calibration.body_from_imu.translation, Eigen::Vector3d::Zero());
  }
  const auto error = [&](const std::string& text) { return MessageOf([&] { read(text); }); };
  EXPECT_NE(error("acc_n: 0.1\n").find("no gyr_n"), std::string::npos);
  EXPECT_NE(error("cam0: {}\n").find("no calibration of an inertial unit"), std::string::npos);
  EXPECT_NE(error("acc_n: 0.1\ngyr_n: 0\nacc_w: 1\ngyr_w: 1\n").find("gyr_n is 0"),
            std::string::npos);
  EXPECT_EQ(read("acc_n: 0.1\ngyr_n: 0.5\nacc_w: 0.1\ngyr_w: 0.01\n").warnings.size(), 1U);
}

TEST_F(ImuDataTest, EurocDataSetsHaveTheirUnit) {
  const fs::path root = MakeEuroc();
  EXPECT_FALSE(OpenDataset(root, {}).imu);
  AddImuTo(root, Samples(1));
  const Dataset dataset = OpenDataset(root, {});
  ASSERT_TRUE(dataset.imu);
  const ImuData& data = *dataset.imu;
  EXPECT_EQ(data.refused, "");
  EXPECT_TRUE(data.warnings.empty()) << All(data.warnings);
  EXPECT_EQ(data.noise.gyroscope_density, 2e-4);
  EXPECT_EQ(data.noise.accelerometer_random_walk, 5e-4);
  // A unit that is mounted turned and apart from the body.
  const ImuSample sample = SampleAt(4 * kStepNs);
  EXPECT_NEAR(data.samples[4].specific_force.x(), -sample.specific_force.y(), 1e-12);
  EXPECT_NEAR(data.samples[4].angular_velocity.y(), sample.angular_velocity.x(), 1e-12);
  EXPECT_LT((data.imu_in_body - Eigen::Vector3d(0.1, 0.2, 0.3)).norm(), 1e-12);
  const std::optional<ImuData> alone = FindImu(root);
  ASSERT_TRUE(alone);
  EXPECT_EQ(alone->samples.size(), data.samples.size());
}

TEST_F(ImuDataTest, TumViHasItsCalibrationBesideTheImages) {
  const fs::path root = MakeEuroc();
  AddImuTo(root, Samples(1));
  fs::remove(root / "mav0/imu0/sensor.yaml");
  WriteText(root / "dso/imu_config.yaml",
            "accelerometer_noise_density: 0.0028\naccelerometer_random_walk: 0.00086\n"
            "gyroscope_noise_density: 0.00016\ngyroscope_random_walk: 2.2e-05\n");
  for (const char* const name : {"", "mav0", "mav0/"}) {
    const Dataset dataset = OpenDataset(root / name, {});
    ASSERT_TRUE(dataset.imu) << name;
    EXPECT_TRUE(dataset.imu->warnings.empty()) << All(dataset.imu->warnings);
    EXPECT_EQ(dataset.imu->noise.accelerometer_density, 0.0028) << name;
  }
}

TEST_F(ImuDataTest, ABrokenUnitDoesNotSpoilTheImages) {
  const fs::path root = MakeEuroc();
  WriteText(root / "mav0/imu0/data.csv", "timestamp,wx\n1,2\n");
  const Dataset broken = OpenDataset(root, {});
  ASSERT_TRUE(broken.imu);
  ExpectRefused(*broken.imu, "imu0/data.csv:1: names no turning rates");
  EXPECT_EQ(broken.entries.size(), 11U);
  fs::remove(root / "mav0/imu0/data.csv");
  ExpectRefused(*OpenDataset(root, {}).imu, "imu0/data.csv: no such file");

  AddImuTo(root, Samples(1));
  WriteText(root / "mav0/imu0/sensor.yaml", "rate_hz: 200\n");
  ExpectWarning(*OpenDataset(root, {}).imu, "the noise of EuRoC's unit (ADIS16448) is assumed");
  DatasetOptions options;
  options.imu_calibration = root / "mav0/imu0/sensor.yaml";
  EXPECT_NE(MessageOf([&] { OpenDataset(root, options); }).find("no calibration of an inertial"),
            std::string::npos);
  options = {};
  options.imu = root / "nowhere.csv";
  EXPECT_NE(MessageOf([&] { OpenDataset(root, options); }).find("nowhere.csv: no such file"),
            std::string::npos);
}

TEST_F(ImuDataTest, TellsHowManyImagesAreCovered) {
  const fs::path root = MakeEuroc();
  std::vector<ImuSample> samples = Samples(1);
  samples.resize(101);
  AddImuTo(root, samples);
  ExpectWarning(*OpenDataset(root, {}).imu,
                "the inertial readings cover 6 of 11 images, number 0 to 5");
  DatasetOptions options;
  options.count = 4;
  EXPECT_TRUE(OpenDataset(root, options).imu->warnings.empty());
  options.start = 6;
  ExpectRefused(*OpenDataset(root, options).imu, "no sample at the time of any image");
}

TEST_F(ImuDataTest, TakesOffTheTimeShiftOfACamchain) {
  const fs::path root = MakeEuroc();
  AddImuTo(root, Samples(1));
  fs::remove(root / "mav0/imu0/sensor.yaml");
  const auto camera = [](const std::string& name, double x) {
    return name + ":\n  T_cam_imu:\n  - [1.0, 0.0, 0.0, " + std::to_string(x) +
           "]\n  - [0.0, 1.0, 0.0, 0.0]\n  - [0.0, 0.0, 1.0, 0.0]\n  - [0.0, 0.0, 0.0, 1.0]\n"
           "  timeshift_cam_imu: 0.02\n  camera_model: pinhole\n  distortion_model: none\n"
           "  intrinsics: [20, 20, 16, 12]\n  resolution: [32, 24]\n";
  };
  DatasetOptions options;
  options.calibration = folder() / "camchain.yaml";
  WriteText(*options.calibration, camera("cam0", 0.0) + camera("cam1", -0.1));
  const Dataset dataset = OpenDataset(root, options);
  ASSERT_TRUE(dataset.imu);
  EXPECT_EQ(dataset.imu->time_shift_s, 0.02);
  // What the unit felt at its time 20 ms, it felt when the images' clock said 0.
  EXPECT_EQ(dataset.imu->samples[4].timestamp_ns, 0);
  EXPECT_EQ(dataset.imu->samples[4].specific_force, SampleAt(4 * kStepNs).specific_force);
}

TEST_F(ImuDataTest, PlainDataTakeATableThatIsNamed) {
  const fs::path root = folder() / "plain";
  for (const char* const side : {"left", "right"}) {
    fs::create_directories(root / side);
    for (int i = 0; i <= 10; ++i) {
      cv::imwrite((root / side / (std::to_string(kSecondNs * (100 + i) / 10) + ".png")).string(),
                  cv::Mat(24, 32, CV_8UC1, cv::Scalar(i)));
    }
  }
  const std::string camera =
      "  camera_model: pinhole\n  distortion_model: none\n  intrinsics: [20, 20, 16, 12]\n"
      "  resolution: [32, 24]\n";
  const std::string chain =
      "cam0:\n" + camera + "cam1:\n" + camera +
      "  T_cn_cnm1: [[1.0, 0.0, 0.0, -0.1], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0], [0.0, "
      "0.0, 0.0, 1.0]]\n";
  DatasetOptions options;
  options.calibration = folder() / "camchain.yaml";
  options.imu = folder() / "imu.csv";
  WriteText(*options.calibration, chain);
  std::vector<ImuSample> samples = Samples(2);
  for (ImuSample& sample : samples) {
    sample.timestamp_ns += 19 * kSecondNs / 2;
  }
  WriteText(*options.imu, TextOf(samples));
  // Nobody says where the unit is.
  ExpectRefused(*OpenDataset(root, options).imu, "expected T_cam_imu");
  std::string with_imu = chain;
  with_imu.insert(with_imu.find("cam1:"),
                  "  T_cam_imu: [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, "
                  "0.0], [0.0, 0.0, 0.0, 1.0]]\n");
  WriteText(*options.calibration, with_imu);
  ExpectWarning(*OpenDataset(root, options).imu, "no calibration of the inertial unit");
  options.imu_calibration = folder() / "imu.yaml";
  WriteText(*options.imu_calibration, "acc_n: 0.1\ngyr_n: 0.01\nacc_w: 0.001\ngyr_w: 0.0001\n");
  const Dataset dataset = OpenDataset(root, options);
  EXPECT_TRUE(dataset.imu->warnings.empty()) << All(dataset.imu->warnings);
  EXPECT_EQ(dataset.imu->refused, "");
  EXPECT_EQ(dataset.imu->noise.accelerometer_density, 0.1);
  options.imu.reset();
  EXPECT_NE(MessageOf([&] { OpenDataset(root, options); }).find("has no readings"),
            std::string::npos);
}

/// A drive of KITTI raw with rectified images, 2 s, and oxts so many times a second.
void MakeDrive(const fs::path& date, int oxts_rate) {
  const fs::path root = date / "drive";
  const auto clock = [](int64_t ns) {
    char text[64];
    std::snprintf(text, sizeof(text), "2011-09-26 13:02:%02d.%09d\n",
                  static_cast<int>(ns / kSecondNs), static_cast<int>(ns % kSecondNs));
    return std::string(text);
  };
  const auto number = [](int i) {
    char text[64];
    std::snprintf(text, sizeof(text), "%010d", i);
    return std::string(text);
  };
  for (const char* const camera : {"image_00", "image_01"}) {
    fs::create_directories(root / camera / "data");
    std::string times;
    for (int i = 0; i < 20; ++i) {
      cv::imwrite((root / camera / "data" / (number(i) + ".png")).string(),
                  cv::Mat(24, 32, CV_8UC1, cv::Scalar(i)));
      times += clock(kSecondNs + i * kSecondNs / 10);
    }
    WriteText(root / camera / "timestamps.txt", times);
  }
  std::string times;
  for (int i = 0; i < 3 * oxts_rate; ++i) {
    WriteText(root / "oxts/data" / (number(i) + ".txt"),
              "49 8 115 0 0 0 0 0 0 0 0 1 2 " + std::to_string(9.5 + 0.001 * i) +
                  " 1 2 9.5 0.1 0.2 0.3 0.1 0.2 0.3 0 0 4 11 6 6 6\n");
    times += clock(kSecondNs / 2 + i * kSecondNs / oxts_rate);
  }
  WriteText(root / "oxts/timestamps.txt", times);
  WriteText(date / "calib_cam_to_cam.txt",
            "S_rect_00: 32 24\nR_rect_00: 1 0 0 0 1 0 0 0 1\nP_rect_00: 20 0 16 0 0 20 12 0 0 0 1 "
            "0\nP_rect_01: 20 0 16 -10 0 20 12 0 0 0 1 0\n");
  // Camera: x right, y down, z forward; laser and unit: x forward, y left, z up.
  WriteText(date / "calib_velo_to_cam.txt", "R: 0 -1 0 0 0 -1 1 0 0\nT: 0.1 0.2 0.3\n");
  WriteText(date / "calib_imu_to_velo.txt", "R: 1 0 0 0 1 0 0 0 1\nT: -0.8 0.3 -0.8\n");
}

TEST_F(ImuDataTest, ReadsOxtsOfAnUnsynchronisedDrive) {
  MakeDrive(folder() / "date", 100);
  const Dataset dataset = OpenDataset(folder() / "date/drive", {});
  ASSERT_TRUE(dataset.imu);
  EXPECT_EQ(dataset.imu->refused, "");
  EXPECT_TRUE(dataset.imu->warnings.empty()) << All(dataset.imu->warnings);
  EXPECT_EQ(dataset.imu->samples.size(), 300U);
  EXPECT_NEAR(dataset.imu->rate_hz, 100.0, 1e-6);
  const ImuSample& first = dataset.imu->samples.front();
  EXPECT_EQ(first.timestamp_ns, -kSecondNs / 2);
  EXPECT_LT((first.specific_force - Eigen::Vector3d(-2.0, -9.5, 1.0)).norm(), 1e-9);
  EXPECT_LT((first.angular_velocity - Eigen::Vector3d(-0.2, -0.3, 0.1)).norm(), 1e-9);
  EXPECT_LT((dataset.imu->imu_in_body - Eigen::Vector3d(-0.2, 1.0, -0.5)).norm(), 1e-9);
  DatasetOptions options;
  options.imu = "imu.csv";
  EXPECT_NE(MessageOf([&] {
              OpenDataset(folder() / "date/drive", options);
            }).find("its own inertial readings"),
            std::string::npos);
  fs::remove(folder() / "date/calib_imu_to_velo.txt");
  ExpectRefused(*OpenDataset(folder() / "date/drive", {}).imu, "calib_imu_to_velo.txt: no such");
}

TEST_F(ImuDataTest, OxtsOfASynchronisedDriveAreTooSlow) {
  MakeDrive(folder() / "date", 10);
  const Dataset dataset = OpenDataset(folder() / "date/drive", {});
  ASSERT_TRUE(dataset.imu);
  ExpectRefused(*dataset.imu, "10.00 samples a second");
  ExpectRefused(*dataset.imu, "\"extract\"");
  EXPECT_EQ(dataset.entries.size(), 20U);
}

TEST(RealImuTest, EurocsKeyFramesHaveAWholeUnit) {
  const fs::path data = fs::path(GLUEVO_SHARED_DIR) / "data";
  if (!fs::exists(data / "euroc_V1_01_keyframes/mav0/imu0")) {
    GTEST_SKIP() << "no EuRoC data in " << data;
  }
  for (const auto& [name, count] :
       {std::pair{"euroc_V1_01_keyframes", 29120U}, std::pair{"euroc_V1_01_start", 431U}}) {
    const Dataset dataset = OpenDataset(data / name, {});
    ASSERT_TRUE(dataset.imu);
    EXPECT_EQ(dataset.imu->refused, "");
    EXPECT_TRUE(dataset.imu->warnings.empty()) << All(dataset.imu->warnings);
    EXPECT_EQ(dataset.imu->samples.size(), count);
    EXPECT_NEAR(dataset.imu->rate_hz, 200.0, 0.01);
    EXPECT_EQ(dataset.imu->noise.gyroscope_density, 1.6968e-4);
    EXPECT_EQ(dataset.imu->imu_in_body, Eigen::Vector3d::Zero());
  }
}

}  // namespace
}  // namespace gluevo::vo
