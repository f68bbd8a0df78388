#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "gluevo/vo/core/imu.h"
#include "gluevo/vo/inertial/preintegration.h"

namespace gluevo::vo {

/// What an inertial unit has read so far, and what that says of the motion between two times. Times
/// are those of the images' clock; a reading that its unit stamps with t was taken at t less the
/// time offset (Kalibr's timeshift_cam_imu).
class ImuReadings {
 public:
  /// `noise`: that in use, see StartInMotion(). Throws Error naming a figure that is not positive.
  explicit ImuReadings(const ImuNoise& noise);

  /// The next samples. Throws Error where they are not in order of time, or not behind those that
  /// there are; nothing is taken then.
  void Add(std::span<const ImuSample> samples);
  /// Drops what is not needed for times from this one on.
  void ForgetBefore(int64_t time_ns);

  /// With stamps of the images' clock.
  const std::vector<ImuSample>& samples() const { return samples_; }
  const ImuNoise& noise() const { return noise_; }
  /// Of what is measured from now on. Throws Error as the constructor.
  void set_noise(const ImuNoise& noise);
  double time_offset_s() const { return 1e-9 * static_cast<double>(time_offset_ns_); }
  /// Of samples so far and those to come: to whole nanoseconds.
  void set_time_offset_s(double time_offset_s);
  /// Whether samples reach from one time to the other, at most 0.1 s apart.
  bool Cover(int64_t begin_ns, int64_t end_ns) const;
  /// The motion as they see it (Preintegrate), or, where they do not cover the time, AcrossGap().
  /// Throws Error where begin_ns is not before end_ns.
  Preintegration Between(int64_t begin_ns, int64_t end_ns, const ImuBias& bias) const;

 private:
  /// Those between, and one beyond each end.
  std::vector<ImuSample> Around(int64_t begin_ns, int64_t end_ns) const;

  ImuNoise noise_;
  int64_t time_offset_ns_ = 0;
  std::vector<ImuSample> samples_;
};

}  // namespace gluevo::vo
