#include "gluevo/vo/simulation/simulation.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <iterator>
#include <map>
#include <opencv2/imgcodecs.hpp>
#include <sstream>

#include "gluevo/nn/error.h"
#include "gluevo/vo/io/hdf5_file.h"
#include "imu.h"
#include "path.h"
#include "temporary_folder.h"

namespace gluevo::simulation {
namespace {

SimulationOptions Small() {
  SimulationOptions options;
  options.width = 160;
  options.height = 100;
  options.duration_s = 0.4;
  options.rate_hz = 7.0;  // Its frames fall between the inertial samples.
  return options;
}

std::string Bytes(const std::filesystem::path& file) {
  std::ifstream stream(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(stream), {}};
}

std::map<std::string, std::string> AllFiles(const std::filesystem::path& directory) {
  std::map<std::string, std::string> files;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(directory)) {
    if (entry.is_regular_file()) {
      files[std::filesystem::relative(entry.path(), directory).string()] = Bytes(entry.path());
    }
  }
  return files;
}

std::vector<std::vector<double>> ReadCsv(const std::filesystem::path& file) {
  std::ifstream stream(file);
  std::vector<std::vector<double>> rows;
  for (std::string line; std::getline(stream, line);) {
    if (line.empty() || line[0] == '#') continue;
    std::istringstream cells(line);
    rows.emplace_back();
    for (std::string cell; std::getline(cells, cell, ',');) {
      // Times as seconds after 1.5e18 ns, which a double could not hold to the nanosecond.
      rows.back().push_back(
          rows.back().empty() ? static_cast<double>(std::stoll(cell) - 1500000000000000000LL) / 1e9
                              : std::stod(cell));
    }
  }
  return rows;
}

std::string ErrorOf(const SimulationOptions& options) {
  try {
    options.Validate();
  } catch (const Error& error) {
    return error.what();
  }
  return "";
}

TEST(SimulationTest, BytesDependOnTheSeedAndNotOnTheThreads) {
  const TemporaryFolder folder;
  SimulationOptions options = Small();
  options.threads = 1;
  Simulate(options, folder.path() / "one");
  options.threads = 2;
  Simulate(options, folder.path() / "two");
  options.seed = 2;
  Simulate(options, folder.path() / "other");
  const auto one = AllFiles(folder.path() / "one");
  EXPECT_EQ(one, AllFiles(folder.path() / "two"));
  // 2 pairs; 2 lists, 4 tables of sensors (two cameras, imu0's two), ground truth.
  EXPECT_EQ(one.size(), 4U + 2U + 4U + 1U);
  for (const auto& [name, bytes] : AllFiles(folder.path() / "other")) {
    ASSERT_TRUE(one.contains(name)) << name;
    if (name.ends_with(".png")) {
      EXPECT_NE(bytes, one.at(name)) << name;
    }
  }
}

TEST(SimulationTest, WritesTheListedImagesAndTruePoses) {
  const TemporaryFolder folder;
  int last = 0;
  int all = 0;
  Simulate(Small(), folder.path() / "out" / "", [&](int done, int of) {
    EXPECT_EQ(done, last + 1);
    last = done;
    all = of;
  });
  EXPECT_EQ(last, all);
  const std::filesystem::path mav = folder.path() / "out" / "mav0";
  const auto states = ReadCsv(mav / "state_groundtruth_estimate0" / "data.csv");
  const SimulationPath path = MakeSimulationPath("hall_loop");
  std::map<double, vo::Rigid3> truth;
  for (const auto& row : states) {
    ASSERT_EQ(row.size(), 17U);
    const vo::Rigid3 expected = path(row[0]);
    truth[row[0]] = expected;
    EXPECT_NEAR(row[1], expected.translation.x(), 1e-9);
    EXPECT_NEAR(row[2], expected.translation.y(), 1e-9);
    EXPECT_NEAR(row[3], expected.translation.z(), 1e-9);
    const Eigen::Quaterniond rotation(row[4], row[5], row[6], row[7]);
    EXPECT_LT(rotation.angularDistance(expected.rotation), 1e-7);
  }
  for (const char* camera : {"cam0", "cam1"}) {
    std::ifstream list(mav / camera / "data.csv");
    std::string line;
    std::getline(list, line);
    int images = 0;
    while (std::getline(list, line)) {
      const std::string name = line.substr(line.find(',') + 1);
      EXPECT_EQ(name, line.substr(0, line.find(',')) + ".png");
      const cv::Mat image =
          cv::imread((mav / camera / "data" / name).string(), cv::IMREAD_UNCHANGED);
      EXPECT_EQ(image.size(), cv::Size(160, 100));
      EXPECT_EQ(image.type(), CV_8UC1);
      const double time = static_cast<double>(std::stoll(name) - 1500000000000000000LL) / 1e9;
      EXPECT_NEAR(time, images / 7.0, 1e-9);
      EXPECT_TRUE(truth.contains(time)) << "no ground truth at " << name;
      ++images;
    }
    EXPECT_EQ(images, 2);
  }
  EXPECT_FALSE(std::filesystem::exists(folder.path() / "out.part"));
}

TEST(SimulationTest, LeavesWhatIsThereAlone) {
  const TemporaryFolder folder;
  std::filesystem::create_directory(folder.path() / "out");
  try {
    Simulate(Small(), folder.path() / "out");
    FAIL() << "nothing thrown";
  } catch (const Error& error) {
    EXPECT_EQ(std::string(error.what()), (folder.path() / "out").string() +
                                             ": exists already, expected the name of a new folder");
  }
  std::ofstream(folder.path() / "file") << "text";
  EXPECT_THROW(Simulate(Small(), folder.path() / "file" / "below"), Error);
  int entries = 0;
  for ([[maybe_unused]] const auto& entry : std::filesystem::directory_iterator(folder.path())) {
    ++entries;
  }
  EXPECT_EQ(entries, 2);
}

TEST(SimulationTest, FliesATrajectoryByItsOwnClock) {
  const TemporaryFolder folder;
  const std::filesystem::path file = folder.path() / "flight.txt";
  {
    std::ofstream stream(file);
    // 3 s at rest, then 1 m/s along x; the head turned by 90 degrees.
    for (int i = 0; i < 100; ++i) {
      stream << 1403636580 + i / 10 << '.' << i % 10 << "5 " << 4.0 + 0.1 * std::max(0, i - 30)
             << " -2 0.5 0.7071068 0 0 0.7071068\n";
    }
  }
  SimulationOptions options = Small();
  options.trajectory = file;
  options.from_takeoff = true;
  options.start_s = 2.0;
  Simulate(options, folder.path() / "out");
  const auto states =
      ReadCsv(folder.path() / "out" / "mav0" / "state_groundtruth_estimate0" / "data.csv");
  // The last pose at rest is at 0.05 + 3.0 s; 2 s later the body flies.
  EXPECT_NEAR(states[0][0], 1403636580.05 + 5.0 - 1.5e9, 1e-6);
  EXPECT_NEAR(states[0][1], 6.0, 1e-3);
  EXPECT_NEAR(states[0][2], -2.0, 1e-3);
  EXPECT_NEAR(states[0][3], 0.5, 1e-3);
  EXPECT_NEAR(states[0][8], 1.0, 1e-2);  // Velocity along x.

  options.duration_s = 5.0;
  try {
    Simulate(options, folder.path() / "late");
    FAIL() << "nothing thrown";
  } catch (const Error& error) {
    EXPECT_EQ(std::string(error.what()),
              file.string() +
                  ": ends 9.90 s after its first pose, expected more than the start of 5.00 s and "
                  "the duration of 5.00 s");
  }
  EXPECT_FALSE(std::filesystem::exists(folder.path() / "late.part"));
}

TEST(SimulationTest, AddsDepthMapsAndCorrespondences) {
  const TemporaryFolder folder;
  SimulationOptions options = Small();
  options.depth = options.correspondences = true;
  options.image = {3.0, 1.0, 0.3, 15.0, 0.5};
  options.start_s = 3.0;
  options.threads = 1;
  Simulate(options, folder.path() / "one");
  options.threads = 2;
  Simulate(options, folder.path() / "two");
  const auto files = AllFiles(folder.path() / "one");
  EXPECT_TRUE(files == AllFiles(folder.path() / "two"));
  EXPECT_EQ(files.size(), 8U + 2U + 4U + 1U + 1U);

  const std::filesystem::path mav = folder.path() / "one" / "mav0";
  const vo::internal::H5InputFile file(mav / "correspondences.h5");
  const std::vector<std::string> groups = file.GroupsWith("pixel");
  ASSERT_EQ(groups.size(), 2U);
  const vo::StereoRig rig = SimulationRig(160, 100);
  const SimulationPath path = MakeSimulationPath("hall_loop");
  int in_right = 0;
  int in_next = 0;
  for (std::size_t frame = 0; frame < groups.size(); ++frame) {
    const auto column = [&](const char* name) {
      return file.ReadFloats(groups[frame] + "/" + name);
    };
    const std::vector<float> pixel = column("pixel");
    const std::vector<float> point = column("point");
    const std::vector<float> right = column("right");
    const std::vector<float> next = column("next");
    EXPECT_EQ(pixel.size(), 2U * 20 * 12);  // Columns at 4 to 156, rows at 4 to 92.
    const cv::Mat depth = cv::imread((mav / "cam0" / "depth" / (groups[frame] + ".tiff")).string(),
                                     cv::IMREAD_UNCHANGED);
    ASSERT_EQ(depth.type(), CV_32FC1);
    const double now = 3.0 + static_cast<double>(frame) / 7.0;
    const auto expect_at = [&](const Eigen::Vector3d& world, double time, int camera,
                               const float* seen) {
      const Eigen::Vector3d in_cam = (path(time) * rig.body_from_cam[camera]).Inverse() * world;
      const Eigen::Vector2d projected = rig.cameras[camera].Project(in_cam);
      EXPECT_NEAR(projected.x(), seen[0], 0.02);
      EXPECT_NEAR(projected.y(), seen[1], 0.02);
      return in_cam.z();
    };
    for (std::size_t i = 0; i < pixel.size() / 2; ++i) {
      const Eigen::Vector3d world(point[3 * i], point[3 * i + 1], point[3 * i + 2]);
      const double z = expect_at(world, now, 0, &pixel[2 * i]);
      EXPECT_NEAR(
          depth.at<float>(static_cast<int>(pixel[2 * i + 1]), static_cast<int>(pixel[2 * i])), z,
          1e-4);
      if (right[2 * i] > -0.9F) {
        expect_at(world, now, 1, &right[2 * i]);
        ++in_right;
      }
      if (next[2 * i] > -0.9F) {
        expect_at(world, now + 1.0 / 7.0, 0, &next[2 * i]);
        ++in_next;
      }
    }
    if (frame == 1) {
      EXPECT_TRUE(std::all_of(next.begin(), next.end(), [](float v) { return v == -1.0F; }));
    }
  }
  EXPECT_GT(in_right, 300);
  EXPECT_GT(in_next, 120);
}

TEST(SimulationTest, ReplacesWhatAKilledRunLeft) {
  const TemporaryFolder folder;
  std::filesystem::create_directories(folder.path() / "out.part" / "mav0" / "cam7" / "data");
  Simulate(Small(), folder.path() / "out");
  EXPECT_TRUE(std::filesystem::exists(folder.path() / "out" / "mav0" / "cam1" / "data.csv"));
  EXPECT_FALSE(std::filesystem::exists(folder.path() / "out" / "mav0" / "cam7"));
  EXPECT_FALSE(std::filesystem::exists(folder.path() / "out.part"));
}

TEST(SimulationTest, CanBeEndedBeforeItsFirstImage) {
  struct Ended {};
  const TemporaryFolder folder;
  SimulationOptions options = Small();
  options.threads = 2;
  options.checkpoint = [] { throw Ended(); };
  const auto show = [](int, int) { ADD_FAILURE() << "the room was made first"; };
  EXPECT_THROW(Simulate(options, folder.path() / "out", show), Ended);
  EXPECT_TRUE(std::filesystem::is_empty(folder.path()));
}

TEST(SimulationTest, RefusesOptionsOutOfRange) {
  SimulationOptions options;
  EXPECT_EQ(ErrorOf(options), "");
  options.path = "moon";
  EXPECT_EQ(ErrorOf(options),
            "unknown path \"moon\" to simulate, expected one of: hall_loop, figure_eight, "
            "corridor, hover, fast_yaw, rest, straight, spin, planar, street");
  for (const double bad : {0.0, -1.0, std::nan(""), HUGE_VAL}) {
    options = {};
    options.duration_s = bad;
    EXPECT_NE(ErrorOf(options).find("duration"), std::string::npos) << bad;
    options = {};
    options.rate_hz = bad;
    EXPECT_NE(ErrorOf(options).find("rate"), std::string::npos) << bad;
  }
  options = {};
  options.start_s = -1.0;
  EXPECT_NE(ErrorOf(options).find("start"), std::string::npos);
  options = {};
  options.from_takeoff = true;
  EXPECT_NE(ErrorOf(options).find("take-off"), std::string::npos);
  options = {};
  options.image.noise = std::nan("");
  EXPECT_NE(ErrorOf(options).find("noise"), std::string::npos);
  options = {};
  options.height = 0;
  EXPECT_NE(ErrorOf(options).find("pixels"), std::string::npos);
  options = {};
  options.threads = -1;
  EXPECT_NE(ErrorOf(options).find("threads"), std::string::npos);
}

TEST(SimulationRigTest, ScalesWithTheImage) {
  const vo::StereoRig full = SimulationRig(752, 480);
  const vo::StereoRig half = SimulationRig(376, 240);
  EXPECT_EQ(full.cameras[0].fx, 458.654);
  EXPECT_NEAR(full.baseline(), 0.11, 0.001);  // EuRoC's baseline is 11 cm.
  // A pixel of the half-size image covers 2 x 2 of the full-size one: centre x at 2 x + 0.5.
  const Eigen::Vector3d point(0.4, -0.3, 1.2);
  for (int camera = 0; camera < 2; ++camera) {
    const Eigen::Vector2d in_full = full.cameras[camera].Project(point);
    const Eigen::Vector2d in_half = half.cameras[camera].Project(point);
    EXPECT_NEAR(in_full.x(), 2.0 * in_half.x() + 0.5, 1e-9);
    EXPECT_NEAR(in_full.y(), 2.0 * in_half.y() + 0.5, 1e-9);
  }
}

TEST(SimulationPathTest, StartsAtRestAndClosesItsLoop) {
  const SimulationPath path = MakeSimulationPath("hall_loop");
  EXPECT_LT((path(0.0).translation - path(20.0).translation).norm(), 1e-9);
  EXPECT_LT(path(0.0).rotation.angularDistance(path(20.0).rotation), 1e-7);
  const Motion start = MotionAt(path, 0.0);
  EXPECT_LT(start.velocity_in_world.norm(), 1e-5);
  EXPECT_LT(start.angular_velocity_in_body.norm(), 1e-5);
  // At rest the unit feels what holds it up: 9.81 m/s^2 upwards.
  EXPECT_LT((start.world_from_body.rotation * start.specific_force_in_body -
             Eigen::Vector3d(0.0, 0.0, 9.81))
                .norm(),
            0.01);
  // The body looks along z with x up: level within its nodding.
  for (int i = 0; i < 200; ++i) {
    const double time = 0.1 * i;
    const Eigen::Matrix3d rotation = path(time).rotation.toRotationMatrix();
    EXPECT_GT(rotation.col(0).z(), 0.98);
    EXPECT_LT(std::abs(rotation.col(2).z()), 0.1);
    EXPECT_LT(MotionAt(path, time).velocity_in_world.norm(), 1.8);
    EXPECT_LT(MotionAt(path, time).angular_velocity_in_body.norm(), 1.3);
  }
}

// Dead reckoning from the ideal inertial samples comes back to the path. The midpoint rule at
// 200 Hz errs by h^2 / 24 * (jerk's rate, below 3 m/s^4) per second of velocity: over 5 s below
// 0.1 mm in position from that; gravity through the attitude's error of the same order
// ((5e-3)^2 / 24 * 5 s * 10 rad/s^3 = 5e-5 rad) adds 9.81 * 5e-5 * 5^2 / 6 = 2 mm at most.
TEST(SimulationImuTest, IntegratesBackToThePath) {
  const SimulationPath path = MakeSimulationPath("hall_loop");
  vo::ImuNoise none;
  none.gyroscope_density = none.gyroscope_random_walk = 0.0;
  none.accelerometer_density = none.accelerometer_random_walk = 0.0;
  const std::vector<ImuSample> samples = SimulateImu(path, 5 * kImuRateHz + 1, none, 4);
  Eigen::Quaterniond rotation = path(0.0).rotation;
  Eigen::Vector3d position = path(0.0).translation;
  Eigen::Vector3d velocity = Eigen::Vector3d::Zero();
  constexpr double kStep = 1.0 / kImuRateHz;
  for (std::size_t i = 0; i + 1 < samples.size(); ++i) {
    const auto gyroscope = [&](std::size_t k) {
      return Eigen::Vector3d(samples[k].angular_velocity - samples[k].gyroscope_bias);
    };
    const auto force = [&](std::size_t k) {
      return Eigen::Vector3d(samples[k].specific_force - samples[k].accelerometer_bias);
    };
    const Eigen::Vector3d turn = 0.5 * (gyroscope(i) + gyroscope(i + 1)) * kStep;
    const Eigen::Quaterniond next =
        rotation * Eigen::Quaterniond(Eigen::AngleAxisd(turn.norm(), turn.stableNormalized()));
    const Eigen::Vector3d acceleration = 0.5 * (rotation * force(i) + next * force(i + 1)) -
                                         Eigen::Vector3d(0.0, 0.0, kSimulationGravity);
    position += velocity * kStep + 0.5 * acceleration * kStep * kStep;
    velocity += acceleration * kStep;
    rotation = next;
  }
  EXPECT_LT((position - path(5.0).translation).norm(), 3e-3);
  EXPECT_LT(rotation.angularDistance(path(5.0).rotation), 1e-4);
}

TEST(SimulationImuTest, NoiseHasEurocsSpread) {
  // A body at rest: what is left is the noise, of density * sqrt(200 Hz) a sample.
  const SimulationPath still = [](double) { return vo::Rigid3(); };
  vo::ImuNoise noise;
  noise.gyroscope_random_walk = noise.accelerometer_random_walk = 0.0;
  const std::vector<ImuSample> samples = SimulateImu(still, 4000, noise, 5);
  double gyroscope = 0.0;
  double accelerometer = 0.0;
  for (const ImuSample& sample : samples) {
    gyroscope += (sample.angular_velocity - sample.gyroscope_bias).squaredNorm() / 3.0;
    accelerometer += (sample.specific_force - sample.accelerometer_bias -
                      Eigen::Vector3d(0.0, 0.0, kSimulationGravity))
                         .squaredNorm() /
                     3.0;
  }
  // 12000 draws: their deviation is known to 1 / sqrt(24000) = 0.65 %; four times that.
  EXPECT_NEAR(std::sqrt(gyroscope / 4000.0), 1.6968e-4 * std::sqrt(200.0), 0.026 * 2.4e-3);
  EXPECT_NEAR(std::sqrt(accelerometer / 4000.0), 2.0e-3 * std::sqrt(200.0), 0.026 * 2.83e-2);
}

TEST(SimulationTest, MoversFillTheirShareAndNothingElseChanges) {
  const TemporaryFolder folder;
  SimulationOptions options = Small();
  options.duration_s = 3.0;
  options.start_s = 2.0;
  options.image.noise = 0.0;
  Simulate(options, folder.path() / "still");
  options.movers = 2;
  options.movers_cover = 0.3;
  Simulate(options, folder.path() / "moving");
  options.threads = 1;
  Simulate(options, folder.path() / "again");
  EXPECT_EQ(AllFiles(folder.path() / "moving"), AllFiles(folder.path() / "again"));

  double most = 0.0;
  int changed = 0;
  int strays = 0;
  for (const auto& entry :
       std::filesystem::directory_iterator(folder.path() / "moving/mav0/cam0/movers")) {
    const std::string name = entry.path().filename().string();
    const auto read = [&](const std::string& set) {
      return cv::imread((folder.path() / set / "mav0/cam0/data" / name).string(),
                        cv::IMREAD_GRAYSCALE);
    };
    const cv::Mat mask = cv::imread(entry.path().string(), cv::IMREAD_GRAYSCALE);
    const cv::Mat still = read("still");
    const cv::Mat moving = read("moving");
    ASSERT_EQ(mask.size(), still.size()) << name;
    most = std::max(most, cv::countNonZero(mask) / static_cast<double>(mask.total()));
    // A pixel's samples reach half a pixel around its centre: beside the mask's edge both may show,
    // and a box's sharp corner may reach between the centres of pixels.
    for (int y = 2; y + 2 < mask.rows; ++y) {
      for (int x = 2; x + 2 < mask.cols; ++x) {
        const int around = cv::countNonZero(mask(cv::Rect(x - 2, y - 2, 5, 5)));
        const bool differs = still.at<uchar>(y, x) != moving.at<uchar>(y, x);
        strays += around == 0 && differs ? 1 : 0;
        changed += around == 25 && differs ? 1 : 0;
      }
    }
  }
  EXPECT_GT(most, 0.15);
  EXPECT_LT(most, 2 * 0.3);  // Both of them at once.
  EXPECT_GT(changed, 1000);
  // A face that is seen edge on may be a sliver between centres.
  EXPECT_LT(strays, 5);
}

TEST(SimulationTest, MoversAreChecked) {
  SimulationOptions options;
  options.movers = -1;
  EXPECT_NE(ErrorOf(options).find("movers"), std::string::npos);
  options.movers = 1;
  options.movers_cover = 0.9;
  EXPECT_NE(ErrorOf(options).find("mover fills"), std::string::npos);
  options.movers_cover = 0.5;
  EXPECT_EQ(ErrorOf(options), "");
  options.correspondences = true;
  EXPECT_NE(ErrorOf(options).find("no movers"), std::string::npos);
}

}  // namespace
}  // namespace gluevo::simulation
