#include <Eigen/Core>
#include <algorithm>

#include "checks.h"
#include "gluevo/vo/core/text.h"
#include "gluevo/vo/io/imu_data.h"

namespace gluevo::vo {
namespace {

double MedianLength(const std::vector<ImuSample>& samples, Eigen::Vector3d ImuSample::*sensor) {
  std::vector<double> lengths;
  lengths.reserve(samples.size());
  for (const ImuSample& sample : samples) {
    lengths.push_back((sample.*sensor).norm());
  }
  return Median(std::move(lengths));
}

Finding CheckRate(const ImuData& imu) {
  Finding finding = {Verdict::kGood, "IMU", FixedText(imu.rate_hz, 1) + " readings a second",
                     "50 to 2000 a second"};
  if (imu.rate_hz < 50.0 || imu.rate_hz > 2000.0) {
    finding.verdict =
        imu.rate_hz < 1.0 || imu.rate_hz > 1e4 ? Verdict::kWrong : Verdict::kSuspicious;
  }
  return finding;
}

/// A body that is carried feels gravity, 9.8 m/s^2, most of the time, and turns at less than a
/// turn a second.
Findings CheckUnits(const ImuData& imu) {
  const double acceleration = MedianLength(imu.samples, &ImuSample::specific_force);
  const double rate = MedianLength(imu.samples, &ImuSample::angular_velocity);
  Finding gravity = {Verdict::kGood, "accelerations",
                     FixedText(acceleration, 2) + " m/s^2 (median)", "8.8 to 10.8, mostly gravity"};
  if (acceleration < 8.8 || acceleration > 10.8) {
    gravity.verdict =
        acceleration < 5.0 || acceleration > 15.0 ? Verdict::kWrong : Verdict::kSuspicious;
  }
  return {gravity,
          {UpTo(rate, 3.0, 10.0), "turning rates", FixedText(rate, 3) + " rad/s (median)",
           "up to 3: degrees a second, or exchanged with accelerations?"}};
}

Finding CheckOverlap(const ImuData& imu, const std::vector<int64_t>& times_ns) {
  const auto within = std::count_if(times_ns.begin(), times_ns.end(), [&](int64_t time) {
    return time >= imu.samples.front().timestamp_ns && time <= imu.samples.back().timestamp_ns;
  });
  const double share = 100.0 * static_cast<double>(within) / static_cast<double>(times_ns.size());
  return {share >= 95.0 ? Verdict::kGood
          : share > 0.0 ? Verdict::kSuspicious
                        : Verdict::kWrong,
          "IMU and images", FixedText(share, 0) + " % of the images within its readings",
          "95 % at the least: are both of one clock and unit?"};
}

}  // namespace

Findings CheckImu(const std::optional<ImuData>& imu, const std::vector<int64_t>& times_ns) {
  if (!imu) {
    return {{Verdict::kGood, "IMU", "none found", ""}};
  }
  Findings findings;
  if (!imu->samples.empty()) {
    findings = CheckUnits(*imu);
    findings.insert(findings.begin(), CheckRate(*imu));
    if (!times_ns.empty()) {
      findings.push_back(CheckOverlap(*imu, times_ns));
    }
  }
  for (const std::string& note : imu->notes) {
    findings.push_back({Verdict::kGood, "IMU readings", note, ""});
  }
  for (const std::string& warning : imu->warnings) {
    findings.push_back({Verdict::kSuspicious, "IMU readings", warning, ""});
  }
  if (!imu->refused.empty()) {
    findings.push_back({Verdict::kWrong, "IMU file", imu->refused,
                        "timestamp [ns],w_x,w_y,w_z,a_x,a_y,a_z, or KITTI's oxts"});
  }
  return findings;
}

}  // namespace gluevo::vo
