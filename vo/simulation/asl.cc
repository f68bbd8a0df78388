#include "asl.h"

#include <cerrno>
#include <fstream>
#include <iomanip>
#include <system_error>

#include "gluevo/nn/error.h"

namespace gluevo::simulation {
namespace {

/// A text file that insists on being written.
class TextFile {
 public:
  explicit TextFile(const std::filesystem::path& path) : path_(path), stream_(path) {
    stream_.imbue(std::locale::classic());
    stream_ << std::setprecision(17);
    Check();
  }
  TextFile(const TextFile&) = delete;
  TextFile& operator=(const TextFile&) = delete;
  ~TextFile() = default;

  template <typename T>
  TextFile& operator<<(const T& value) {
    stream_ << value;
    return *this;
  }
  TextFile& operator<<(const Eigen::Vector3d& vector) {
    stream_ << vector.x() << ',' << vector.y() << ',' << vector.z();
    return *this;
  }
  void Close() {
    stream_.close();
    Check();
  }

 private:
  void Check() const {
    if (!stream_) {
      throw Error(path_.string() +
                  ": cannot be written: " + std::generic_category().message(errno));
    }
  }

  std::filesystem::path path_;
  std::ofstream stream_;
};

void WriteTransform(TextFile* file, const vo::Rigid3& body_from_sensor) {
  const Eigen::Matrix<double, 3, 4> rows = body_from_sensor.Matrix();
  *file << "T_BS:\n  cols: 4\n  rows: 4\n  data: [";
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 4; ++column) *file << rows(row, column) << ", ";
    *file << "\n         ";
  }
  *file << "0.0, 0.0, 0.0, 1.0]\n\n";
}

}  // namespace

void WriteAslCamera(const std::filesystem::path& path, const vo::StereoRig& rig, int camera,
                    double rate_hz, const std::string& comment) {
  const vo::Camera& model = rig.cameras[camera];
  TextFile file(path);
  file << "%YAML:1.0\n# " << comment << "\nsensor_type: camera\ncomment: simulated cam" << camera
       << "\n\n# Sensor extrinsics wrt. the body-frame.\n";
  WriteTransform(&file, rig.body_from_cam[camera]);
  file << "rate_hz: " << rate_hz << "\nresolution: [" << model.width << ", " << model.height
       << "]\ncamera_model: pinhole\nintrinsics: [" << model.fx << ", " << model.fy << ", "
       << model.cx << ", " << model.cy << "] #fu, fv, cu, cv\n"
       << "distortion_model: radial-tangential\ndistortion_coefficients: [" << model.coefficients[0]
       << ", " << model.coefficients[1] << ", " << model.coefficients[2] << ", "
       << model.coefficients[3] << "]\n";
  file.Close();
}

void WriteAslImageList(const std::filesystem::path& path, const std::vector<int64_t>& times_ns) {
  TextFile file(path);
  file << "#timestamp [ns],filename\n";
  for (const int64_t time : times_ns) file << time << ',' << time << ".png\n";
  file.Close();
}

void WriteAslImu(const std::filesystem::path& path, const vo::ImuNoise& noise) {
  TextFile file(path);
  file << "%YAML:1.0\nsensor_type: imu\ncomment: simulated imu0\n\n";
  WriteTransform(&file, vo::Rigid3());
  file << "rate_hz: " << kImuRateHz << "\ngyroscope_noise_density: " << noise.gyroscope_density
       << "     # [ rad / s / sqrt(Hz) ]\ngyroscope_random_walk: " << noise.gyroscope_random_walk
       << "     # [ rad / s^2 / sqrt(Hz) ]\naccelerometer_noise_density: "
       << noise.accelerometer_density
       << "     # [ m / s^2 / sqrt(Hz) ]\naccelerometer_random_walk: "
       << noise.accelerometer_random_walk << "     # [ m / s^3 / sqrt(Hz) ]\n";
  file.Close();
}

void WriteAslImuSamples(const std::filesystem::path& path, const std::vector<int64_t>& times_ns,
                        const std::vector<ImuSample>& samples) {
  TextFile file(path);
  file << "#timestamp [ns],w_RS_S_x [rad s^-1],w_RS_S_y [rad s^-1],w_RS_S_z [rad s^-1],"
          "a_RS_S_x [m s^-2],a_RS_S_y [m s^-2],a_RS_S_z [m s^-2]\n";
  for (std::size_t i = 0; i < samples.size(); ++i) {
    file << times_ns[i] << ',' << samples[i].angular_velocity << ',' << samples[i].specific_force
         << '\n';
  }
  file.Close();
}

void WriteAslGroundtruth(const std::filesystem::path& path, const std::vector<AslState>& states) {
  TextFile file(path);
  file << "#timestamp,p_RS_R_x [m],p_RS_R_y [m],p_RS_R_z [m],q_RS_w [],q_RS_x [],q_RS_y [],"
          "q_RS_z [],v_RS_R_x [m s^-1],v_RS_R_y [m s^-1],v_RS_R_z [m s^-1],"
          "b_w_RS_S_x [rad s^-1],b_w_RS_S_y [rad s^-1],b_w_RS_S_z [rad s^-1],"
          "b_a_RS_S_x [m s^-2],b_a_RS_S_y [m s^-2],b_a_RS_S_z [m s^-2]\n";
  for (const AslState& state : states) {
    const Eigen::Quaterniond& rotation = state.motion.world_from_body.rotation;
    file << state.time_ns << ',' << state.motion.world_from_body.translation << ',' << rotation.w()
         << ',' << Eigen::Vector3d(rotation.vec()) << ',' << state.motion.velocity_in_world << ','
         << state.gyroscope_bias << ',' << state.accelerometer_bias << '\n';
  }
  file.Close();
}

}  // namespace gluevo::simulation
