#include "imu.h"

#include <cmath>

#include "random.h"

namespace gluevo::simulation {

std::vector<ImuSample> SimulateImu(const SimulationPath& path, int count, const vo::ImuNoise& noise,
                                   uint64_t seed) {
  const NormalTable normal;
  RandomStream random(seed);
  const auto draw = [&](double deviation) {
    const double x = normal(random.Next());
    const double y = normal(random.Next());
    const double z = normal(random.Next());
    return Eigen::Vector3d(deviation * Eigen::Vector3d(x, y, z));
  };
  // A density of n per root hertz is a deviation of n sqrt(rate) a sample; a walk of w per root
  // hertz moves by w sqrt(1 / rate) between samples.
  const double root_rate = std::sqrt(static_cast<double>(kImuRateHz));
  Eigen::Vector3d gyroscope_bias = draw(0.02);
  Eigen::Vector3d accelerometer_bias = draw(0.05);
  std::vector<ImuSample> samples(count);
  for (int i = 0; i < count; ++i) {
    ImuSample& sample = samples[i];
    sample.time_s = static_cast<double>(i) / kImuRateHz;
    const Motion motion = MotionAt(path, sample.time_s);
    sample.gyroscope_bias = gyroscope_bias;
    sample.accelerometer_bias = accelerometer_bias;
    sample.angular_velocity = motion.angular_velocity_in_body + gyroscope_bias +
                              draw(noise.gyroscope_density * root_rate);
    sample.specific_force = motion.specific_force_in_body + accelerometer_bias +
                            draw(noise.accelerometer_density * root_rate);
    gyroscope_bias += draw(noise.gyroscope_random_walk / root_rate);
    accelerometer_bias += draw(noise.accelerometer_random_walk / root_rate);
  }
  return samples;
}

}  // namespace gluevo::simulation
