#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>
#include <fstream>
#include <sstream>

#include "checks.h"

namespace gluevo::vo {
namespace {

namespace fs = std::filesystem;

struct Imu {
  std::vector<int64_t> times_ns;
  std::vector<Eigen::Vector3d> rates;          // As in the file, meant to be rad/s.
  std::vector<Eigen::Vector3d> accelerations;  // Meant to be m/s^2.
  std::size_t bad_lines = 0;
};

/// EuRoC: "timestamp [ns],w x y z,a x y z" a line.
Imu ReadEurocImu(const fs::path& file) {
  Imu imu;
  std::ifstream stream(file);
  for (std::string line; std::getline(stream, line);) {
    if (line.empty() || line[0] == '#' || line == "\r") {
      continue;
    }
    std::replace(line.begin(), line.end(), ',', ' ');
    std::istringstream fields(line);
    int64_t time = 0;
    std::array<double, 6> v = {};
    fields >> time;
    for (double& value : v) {
      fields >> value;
    }
    if (!fields) {
      ++imu.bad_lines;
      continue;
    }
    imu.times_ns.push_back(time);
    imu.rates.emplace_back(v[0], v[1], v[2]);
    imu.accelerations.emplace_back(v[3], v[4], v[5]);
  }
  return imu;
}

/// Numbers of a line or a small file.
std::vector<double> NumbersIn(std::istream& stream) {
  std::vector<double> numbers;
  for (double value = 0.0; stream >> value;) {
    numbers.push_back(value);
  }
  return numbers;
}

/// KITTI raw: a file a reading, with accelerations ax ay az at 11 and rates wx wy wz at 17, and
/// timestamps.txt with "YYYY-MM-DD HH:MM:SS.nnnnnnnnn" a line. Times count within the day.
Imu ReadOxts(const fs::path& folder) {
  constexpr std::size_t kAccelerations = 11;
  constexpr std::size_t kRates = 17;
  std::vector<fs::path> files;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder / "data")) {
    if (entry.path().extension() == ".txt") {
      files.push_back(entry.path());
    }
  }
  std::sort(files.begin(), files.end());
  Imu imu;
  std::ifstream times(folder / "timestamps.txt");
  std::string date;
  std::string time;
  for (const fs::path& file : files) {
    std::ifstream stream(file);
    const std::vector<double> v = NumbersIn(stream);
    times >> date >> time;
    std::replace(time.begin(), time.end(), ':', ' ');
    std::istringstream parts(time);
    const std::vector<double> hms = NumbersIn(parts);
    if (v.size() < kRates + 3 || hms.size() != 3 || !times) {
      ++imu.bad_lines;
      continue;
    }
    constexpr double kMinute = 60.0;
    imu.times_ns.push_back(std::llround(1e9 * (kMinute * (kMinute * hms[0] + hms[1]) + hms[2])));
    imu.accelerations.emplace_back(v[kAccelerations], v[kAccelerations + 1], v[kAccelerations + 2]);
    imu.rates.emplace_back(v[kRates], v[kRates + 1], v[kRates + 2]);
  }
  return imu;
}

std::vector<double> Norms(const std::vector<Eigen::Vector3d>& vectors) {
  std::vector<double> norms;
  norms.reserve(vectors.size());
  for (const Eigen::Vector3d& vector : vectors) {
    norms.push_back(vector.norm());
  }
  return norms;
}

Finding CheckRate(const Imu& imu) {
  std::vector<double> steps;
  std::size_t backwards = 0;
  for (std::size_t i = 1; i < imu.times_ns.size(); ++i) {
    const double step = static_cast<double>(imu.times_ns[i] - imu.times_ns[i - 1]) * 1e-9;
    steps.push_back(step);
    backwards += step <= 0.0 ? 1 : 0;
  }
  const double step = Median(steps);
  const double rate = step > 0.0 ? 1.0 / step : 0.0;
  Finding finding = {Verdict::kGood, "IMU", Number(rate, 1) + " readings a second",
                     "50 to 2000 a second, in order of time"};
  if (backwards > 0) {
    finding.value += ", " + std::to_string(backwards) + " not after the one before";
  }
  if (rate < 50.0 || rate > 2000.0 || backwards > 0) {
    finding.verdict = rate < 1.0 || rate > 1e4 ? Verdict::kWrong : Verdict::kSuspicious;
  }
  return finding;
}

/// A body that is carried feels gravity, 9.8 m/s^2, most of the time, and turns at less than a
/// turn a second.
Findings CheckUnits(const Imu& imu) {
  const double acceleration = Median(Norms(imu.accelerations));
  const double rate = Median(Norms(imu.rates));
  Findings findings;
  Finding gravity = {Verdict::kGood, "accelerations", Number(acceleration, 2) + " m/s^2 (median)",
                     "8.8 to 10.8, mostly gravity"};
  if (acceleration < 8.8 || acceleration > 10.8) {
    gravity.verdict =
        acceleration < 5.0 || acceleration > 15.0 ? Verdict::kWrong : Verdict::kSuspicious;
    const bool exchanged = rate > 8.8 && rate < 10.8;
    gravity.expected += exchanged ? ": rates and accelerations are exchanged"
                        : acceleration > 0.9 && acceleration < 1.1 ? ": these are multiples of g"
                                                                   : "";
  }
  findings.push_back(gravity);
  findings.push_back({UpTo(rate, 3.0, 10.0), "turning rates", Number(rate, 3) + " rad/s (median)",
                      "up to 3: degrees a second, or exchanged with accelerations?"});
  return findings;
}

Finding CheckOverlap(const Imu& imu, const std::vector<int64_t>& times_ns) {
  const auto range = std::minmax_element(imu.times_ns.begin(), imu.times_ns.end());
  const auto within = std::count_if(times_ns.begin(), times_ns.end(), [&](int64_t time) {
    return time >= *range.first && time <= *range.second;
  });
  const double share = 100.0 * static_cast<double>(within) / static_cast<double>(times_ns.size());
  return {share >= 95.0 ? Verdict::kGood
          : share > 0.0 ? Verdict::kSuspicious
                        : Verdict::kWrong,
          "IMU and images", Number(share, 0) + " % of the images within its readings",
          "95 % at the least: are both of one clock and unit?"};
}

/// `times_ns`: of the images, on the same clock; empty where that is not known.
Findings FindingsOf(const Imu& imu, const fs::path& path, const std::string& form,
                    const std::vector<int64_t>& times_ns) {
  Findings findings;
  // A header without '#' is one.
  if (imu.bad_lines > 1 || imu.times_ns.size() < 2) {
    findings.push_back({imu.times_ns.size() < 2 ? Verdict::kWrong : Verdict::kSuspicious,
                        "IMU file",
                        path.string() + ": " + std::to_string(imu.times_ns.size()) + " readings, " +
                            std::to_string(imu.bad_lines) + " that are none",
                        form});
  }
  if (imu.times_ns.size() >= 2) {
    findings.push_back(CheckRate(imu));
    const Findings units = CheckUnits(imu);
    findings.insert(findings.end(), units.begin(), units.end());
    if (!times_ns.empty()) {
      findings.push_back(CheckOverlap(imu, times_ns));
    }
  }
  return findings;
}

}  // namespace

Findings CheckImu(const fs::path& root, const std::vector<int64_t>& times_ns) {
  for (const fs::path& file : {root / "mav0" / "imu0" / "data.csv", root / "imu0" / "data.csv"}) {
    if (fs::is_regular_file(file)) {
      return FindingsOf(ReadEurocImu(file), file, "timestamp [ns],w_x,w_y,w_z,a_x,a_y,a_z",
                        times_ns);
    }
  }
  if (fs::is_directory(root / "oxts" / "data")) {
    return FindingsOf(ReadOxts(root / "oxts"), root / "oxts",
                      "a file of 30 numbers a row of timestamps.txt", {});
  }
  return {{Verdict::kGood, "IMU", "none found", ""}};
}

}  // namespace gluevo::vo
