#include "gluevo/vo/inertial/preintegration.h"

#include <algorithm>

#include "gluevo/nn/error.h"
#include "gluevo/vo/geometry/manifold.h"

namespace gluevo::vo {
namespace {

using inertial_block::kAccelerometerBias;
using inertial_block::kGyroscopeBias;
using inertial_block::kPosition;
using inertial_block::kRotation;
using inertial_block::kVelocity;

constexpr double kSecondsPerNanosecond = 1e-9;
constexpr int kNoiseSize = 6;  // Gyroscope's and accelerometer's.

/// Two samples that follow each other, with the biases taken away.
struct Step {
  double duration_s;
  Eigen::Vector3d angular_velocity;  // Mean of both.
  Eigen::Vector3d force0;
  Eigen::Vector3d force1;
};

ImuSample Interpolated(const ImuSample& before, const ImuSample& after, int64_t time_ns) {
  const auto span = static_cast<double>(after.timestamp_ns - before.timestamp_ns);
  const double share = static_cast<double>(time_ns - before.timestamp_ns) / span;
  return {time_ns,
          before.angular_velocity + share * (after.angular_velocity - before.angular_velocity),
          before.specific_force + share * (after.specific_force - before.specific_force)};
}

/// The samples within, and one at each end.
std::vector<ImuSample> Within(const std::vector<ImuSample>& samples, int64_t begin_ns,
                              int64_t end_ns) {
  if (begin_ns >= end_ns) {
    throw Error("preintegration: an interval that does not end after it begins");
  }
  const auto unordered = std::adjacent_find(
      samples.begin(), samples.end(),
      [](const ImuSample& a, const ImuSample& b) { return a.timestamp_ns >= b.timestamp_ns; });
  if (unordered != samples.end()) {
    throw Error("preintegration: samples that are not in order of time");
  }
  if (samples.empty() || samples.front().timestamp_ns > begin_ns ||
      samples.back().timestamp_ns < end_ns) {
    throw Error("preintegration: samples that do not cover the interval");
  }
  // The first sample after each end.
  const auto after = [&](int64_t time_ns) {
    return std::upper_bound(
        samples.begin(), samples.end(), time_ns,
        [](int64_t time, const ImuSample& sample) { return time < sample.timestamp_ns; });
  };
  const auto at = [&](int64_t time_ns) {
    const auto next = after(time_ns);
    return next == samples.end() ? samples.back() : Interpolated(*(next - 1), *next, time_ns);
  };
  std::vector<ImuSample> within = {at(begin_ns)};
  for (auto sample = after(begin_ns); sample != samples.end() && sample->timestamp_ns < end_ns;
       ++sample) {
    within.push_back(*sample);
  }
  within.push_back(at(end_ns));
  return within;
}

class Integrator {
 public:
  Integrator(const ImuBias& bias, const ImuNoise& noise) : noise_(noise) { result_.bias = bias; }

  void Add(const ImuSample& sample0, const ImuSample& sample1) {
    const ImuBias& bias = result_.bias;
    Advance(
        {static_cast<double>(sample1.timestamp_ns - sample0.timestamp_ns) * kSecondsPerNanosecond,
         0.5 * (sample0.angular_velocity + sample1.angular_velocity) - bias.gyroscope,
         sample0.specific_force - bias.accelerometer, sample1.specific_force - bias.accelerometer});
  }

  Preintegration Result() const {
    Preintegration result = result_;
    result.by_bias = by_start_.topRightCorner<9, 6>();
    // Rounding must not leave it askew.
    result.covariance = 0.5 * (result_.covariance + result_.covariance.transpose());
    return result;
  }

 private:
  void Advance(const Step& step) {
    const double dt = step.duration_s;
    InertialMotion& motion = result_.motion;
    const Eigen::Vector3d turn = step.angular_velocity * dt;
    const Eigen::Quaterniond next = (motion.rotation * ExpSo3(turn)).normalized();
    Propagate(step, turn, motion.rotation.toRotationMatrix(), next.toRotationMatrix());
    const Eigen::Vector3d acceleration = 0.5 * (motion.rotation * step.force0 + next * step.force1);
    motion.position += motion.velocity * dt + 0.5 * acceleration * dt * dt;
    motion.velocity += acceleration * dt;
    motion.rotation = next;
    result_.duration_s += dt;
  }

  // Errors after the step by those before it, F, and by the noise in it, G.
  void Propagate(const Step& step, const Eigen::Vector3d& turn, const Eigen::Matrix3d& rotation0,
                 const Eigen::Matrix3d& rotation1) {
    const double dt = step.duration_s;
    const Eigen::Matrix3d turn_by_rate = RightJacobian(turn) * dt;
    const Eigen::Matrix3d by_turn0 = -0.5 * rotation0 * Skew(step.force0);
    const Eigen::Matrix3d by_turn1 = -0.5 * rotation1 * Skew(step.force1);
    const Eigen::Matrix3d turn1_by_turn0 = ExpSo3(turn).conjugate().toRotationMatrix();
    // Of the mean acceleration.
    Eigen::Matrix<double, 3, kInertialTangentSize> by_state;
    by_state.setZero();
    by_state.middleCols<3>(kRotation) = by_turn0 + by_turn1 * turn1_by_turn0;
    by_state.middleCols<3>(kGyroscopeBias) = -by_turn1 * turn_by_rate;
    by_state.middleCols<3>(kAccelerometerBias) = -0.5 * (rotation0 + rotation1);
    Eigen::Matrix<double, 3, kNoiseSize> by_noise;
    by_noise << by_turn1 * turn_by_rate, 0.5 * (rotation0 + rotation1);

    InertialMatrix transition = InertialMatrix::Identity();
    transition.block<3, 3>(kPosition, kVelocity) = dt * Eigen::Matrix3d::Identity();
    transition.middleRows<3>(kPosition) += 0.5 * dt * dt * by_state;
    transition.middleRows<3>(kVelocity) += dt * by_state;
    transition.block<3, 3>(kRotation, kRotation) = turn1_by_turn0;
    transition.block<3, 3>(kRotation, kGyroscopeBias) = -turn_by_rate;
    Eigen::Matrix<double, kInertialTangentSize, kNoiseSize> input;
    input.setZero();
    input.middleRows<3>(kPosition) = 0.5 * dt * dt * by_noise;
    input.middleRows<3>(kVelocity) = dt * by_noise;
    input.block<3, 3>(kRotation, 0) = turn_by_rate;

    by_start_ = transition * by_start_;
    InertialMatrix& covariance = result_.covariance;
    covariance = transition * covariance * transition.transpose();
    covariance += input * NoiseOf(dt).asDiagonal() * input.transpose();
    covariance.diagonal().segment<3>(kGyroscopeBias).array() +=
        noise_.gyroscope_random_walk * noise_.gyroscope_random_walk * dt;
    covariance.diagonal().segment<3>(kAccelerometerBias).array() +=
        noise_.accelerometer_random_walk * noise_.accelerometer_random_walk * dt;
  }

  // Variance of white noise as it is constant for dt.
  Eigen::Matrix<double, kNoiseSize, 1> NoiseOf(double dt) const {
    Eigen::Matrix<double, kNoiseSize, 1> variance;
    variance.head<3>().setConstant(noise_.gyroscope_density * noise_.gyroscope_density / dt);
    variance.tail<3>().setConstant(noise_.accelerometer_density * noise_.accelerometer_density /
                                   dt);
    return variance;
  }

  ImuNoise noise_;
  Preintegration result_;
  InertialMatrix by_start_ = InertialMatrix::Identity();
};

// Both ends move along the readings: the later one adds what is read there, the earlier one leaves
// out what is read there, and turns the frame that all is given in.
Eigen::Matrix<double, 9, 1> ByTimeOffset(const Preintegration& measured, const ImuSample& first,
                                         const ImuSample& last) {
  const InertialMotion& motion = measured.motion;
  const Eigen::Vector3d rate = first.angular_velocity - measured.bias.gyroscope;
  const Eigen::Vector3d force = first.specific_force - measured.bias.accelerometer;
  Eigen::Matrix<double, 9, 1> derivative;
  derivative.segment<3>(kPosition) =
      motion.velocity - measured.duration_s * force - rate.cross(motion.position);
  derivative.segment<3>(kRotation) =
      last.angular_velocity - measured.bias.gyroscope - motion.rotation.conjugate() * rate;
  derivative.segment<3>(kVelocity) =
      motion.rotation * (last.specific_force - measured.bias.accelerometer) - force -
      rate.cross(motion.velocity);
  return derivative;
}

}  // namespace

InertialMotion Preintegration::At(const ImuBias& other, double shift_s) const {
  if (shift_s == 0.0) {
    return At(other);
  }
  const Eigen::Matrix<double, 9, 1> change = shift_s * by_time_offset;
  Preintegration shifted = *this;
  shifted.motion.rotation = motion.rotation * ExpSo3(change.segment<3>(kRotation));
  shifted.motion.velocity += change.segment<3>(kVelocity);
  shifted.motion.position += change.segment<3>(kPosition);
  return shifted.At(other);
}

InertialMotion Preintegration::At(const ImuBias& other) const {
  Eigen::Matrix<double, 6, 1> change;
  change << other.gyroscope - bias.gyroscope, other.accelerometer - bias.accelerometer;
  const Eigen::Matrix<double, 9, 1> correction = by_bias * change;
  return {(motion.rotation * ExpSo3(correction.segment<3>(kRotation))).normalized(),
          motion.velocity + correction.segment<3>(kVelocity),
          motion.position + correction.segment<3>(kPosition)};
}

Preintegration Preintegrate(const std::vector<ImuSample>& samples, int64_t begin_ns, int64_t end_ns,
                            const ImuBias& bias, const ImuNoise& noise) {
  noise.Validate();
  const std::vector<ImuSample> within = Within(samples, begin_ns, end_ns);
  Integrator integrator(bias, noise);
  for (std::size_t i = 1; i < within.size(); ++i) {
    integrator.Add(within[i - 1], within[i]);
  }
  Preintegration result = integrator.Result();
  result.by_time_offset = ByTimeOffset(result, within.front(), within.back());
  return result;
}

}  // namespace gluevo::vo
