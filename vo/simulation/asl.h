#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "gluevo/vo/geometry/stereo_rig.h"
#include "imu.h"

namespace gluevo::simulation {

/// The text files of EuRoC's ASL layout. All throw Error naming the file that cannot be written.

/// camN/sensor.yaml
void WriteAslCamera(const std::filesystem::path& file, const vo::StereoRig& rig, int camera,
                    double rate_hz, const std::string& comment);
/// camN/data.csv; images are called TIMESTAMP.png.
void WriteAslImageList(const std::filesystem::path& file, const std::vector<int64_t>& times_ns);
/// imu0/sensor.yaml
void WriteAslImu(const std::filesystem::path& file, const vo::ImuNoise& noise);
/// imu0/data.csv
void WriteAslImuSamples(const std::filesystem::path& file, const std::vector<int64_t>& times_ns,
                        const std::vector<ImuSample>& samples);

/// A row of state_groundtruth_estimate0/data.csv.
struct AslState {
  int64_t time_ns = 0;
  Motion motion;
  Eigen::Vector3d gyroscope_bias;
  Eigen::Vector3d accelerometer_bias;
};
void WriteAslGroundtruth(const std::filesystem::path& file, const std::vector<AslState>& states);

}  // namespace gluevo::simulation
