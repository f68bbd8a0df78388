#include "gluevo/vo/io/trajectory_file.h"

#include <Eigen/LU>
#include <array>
#include <cstdio>
#include <iomanip>
#include <sstream>

#include "gluevo/nn/error.h"
#include "gluevo/nn/output_file.h"
#include "text_file.h"

namespace gluevo::vo {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kTumFields = 8;
constexpr std::size_t kEurocFields = 8;
constexpr std::size_t kKittiFields = 12;

std::vector<TextLine> ReadDataLines(const fs::path& path) {
  std::vector<TextLine> lines = ReadLines(path, /*skip_comments=*/true);
  if (lines.empty()) {
    throw Error(path.string() + ": an empty trajectory");
  }
  return lines;
}

TrajectoryFormat FormatOf(const fs::path& path, const TextLine& line) {
  if (SplitFields(line.text, ',').size() >= kEurocFields) {
    return TrajectoryFormat::kEuroc;
  }
  const std::size_t fields = SplitFields(line.text, ' ').size();
  if (fields == kKittiFields) {
    return TrajectoryFormat::kKitti;
  }
  if (fields == kTumFields) {
    return TrajectoryFormat::kTum;
  }
  throw Error(At(path, line) +
              ": not a trajectory: expected 8 numbers (TUM: t x y z qx qy qz qw), " +
              "12 (KITTI) or 8 or more between commas (EuRoC)");
}

template <std::size_t kCount>
std::array<double, kCount> ParseNumbers(const fs::path& path, const TextLine& line,
                                        const std::vector<std::string_view>& fields,
                                        std::size_t first) {
  std::array<double, kCount> values;
  for (std::size_t i = 0; i < kCount; ++i) {
    const auto value = ParseNumber(fields[first + i]);
    if (!value) {
      throw Error(At(path, line) + ": " + Quoted(fields[first + i]) + " is not a finite number");
    }
    values[i] = *value;
  }
  return values;
}

Eigen::Quaterniond CheckedQuaternion(const fs::path& path, const TextLine& line,
                                     const Eigen::Quaterniond& q) {
  if (std::abs(q.norm() - 1.0) > 0.01) {
    throw Error(At(path, line) + ": a quaternion of length " + std::to_string(q.norm()) +
                ", expected 1");
  }
  return q.normalized();
}

void CheckOrder(const fs::path& path, const TextLine& line, const Trajectory& trajectory,
                int64_t timestamp_ns) {
  if (!trajectory.empty() && timestamp_ns <= trajectory.back().timestamp_ns) {
    throw Error(At(path, line) + ": a time that is not after the one before");
  }
}

Trajectory ReadTum(const fs::path& path, const std::vector<TextLine>& lines) {
  Trajectory trajectory;
  for (const TextLine& line : lines) {
    const auto fields = SplitFields(line.text, ' ');
    if (fields.size() != kTumFields) {
      throw Error(At(path, line) + ": " + std::to_string(fields.size()) +
                  " fields, expected 8: t x y z qx qy qz qw");
    }
    const auto timestamp_ns = ParseSeconds(fields[0]);
    if (!timestamp_ns) {
      throw Error(At(path, line) + ": " + Quoted(fields[0]) + " is not a time in seconds");
    }
    CheckOrder(path, line, trajectory, *timestamp_ns);
    const auto v = ParseNumbers<7>(path, line, fields, 1);
    trajectory.push_back(
        {*timestamp_ns,
         {CheckedQuaternion(path, line, {v[6], v[3], v[4], v[5]}), {v[0], v[1], v[2]}}});
  }
  return trajectory;
}

Trajectory ReadEuroc(const fs::path& path, const std::vector<TextLine>& lines) {
  Trajectory trajectory;
  for (const TextLine& line : lines) {
    const auto fields = SplitFields(line.text, ',');
    if (fields.size() < kEurocFields) {
      throw Error(At(path, line) + ": " + std::to_string(fields.size()) +
                  " fields, expected at least 8: t[ns],x,y,z,qw,qx,qy,qz");
    }
    const auto timestamp_ns = ParseInteger(fields[0]);
    if (!timestamp_ns) {
      throw Error(At(path, line) + ": " + Quoted(fields[0]) + " is not a time in nanoseconds");
    }
    CheckOrder(path, line, trajectory, *timestamp_ns);
    const auto v = ParseNumbers<7>(path, line, fields, 1);
    trajectory.push_back(
        {*timestamp_ns,
         {CheckedQuaternion(path, line, {v[3], v[4], v[5], v[6]}), {v[0], v[1], v[2]}}});
  }
  return trajectory;
}

Rigid3 ParseKittiPose(const fs::path& path, const TextLine& line) {
  const auto fields = SplitFields(line.text, ' ');
  if (fields.size() != kKittiFields) {
    throw Error(At(path, line) + ": " + std::to_string(fields.size()) +
                " fields, expected 12: the rows of [R | t]");
  }
  const auto v = ParseNumbers<kKittiFields>(path, line, fields, 0);
  const Eigen::Map<const Eigen::Matrix<double, 3, 4, Eigen::RowMajor>> matrix(v.data());
  const Eigen::Matrix3d rotation = matrix.leftCols<3>();
  if ((rotation * rotation.transpose() - Eigen::Matrix3d::Identity()).norm() > 0.01 ||
      rotation.determinant() < 0.0) {
    throw Error(At(path, line) + ": the first 3 x 3 numbers are not a rotation");
  }
  return {Eigen::Quaterniond(rotation).normalized(), matrix.col(3)};
}

// poses/NN.txt belongs to sequences/NN/times.txt in KITTI's layout.
std::optional<fs::path> FindKittiTimes(const fs::path& path) {
  const fs::path times =
      fs::absolute(path).parent_path().parent_path() / "sequences" / path.stem() / "times.txt";
  return fs::exists(times) ? std::optional(times) : std::nullopt;
}

std::string FormatSeconds(int64_t nanoseconds) {
  constexpr int64_t kSecond = 1'000'000'000;
  const bool negative = nanoseconds < 0;
  const uint64_t magnitude = negative ? uint64_t{0} - static_cast<uint64_t>(nanoseconds)
                                      : static_cast<uint64_t>(nanoseconds);
  char text[32];
  std::snprintf(text, sizeof(text), "%s%llu.%09llu", negative ? "-" : "",
                static_cast<unsigned long long>(magnitude / kSecond),
                static_cast<unsigned long long>(magnitude % kSecond));
  return text;
}

}  // namespace

TrajectoryFormat RecognizeTrajectoryFormat(const fs::path& path) {
  return FormatOf(path, ReadDataLines(path).front());
}

Trajectory ReadTrajectory(const fs::path& path, const std::optional<fs::path>& times) {
  const std::vector<TextLine> lines = ReadDataLines(path);
  switch (FormatOf(path, lines.front())) {
    case TrajectoryFormat::kTum:
      return ReadTum(path, lines);
    case TrajectoryFormat::kEuroc:
      return ReadEuroc(path, lines);
    case TrajectoryFormat::kKitti:
      break;
  }
  const std::optional<fs::path> times_file = times ? times : FindKittiTimes(path);
  if (!times_file) {
    throw Error(path.string() +
                ": a KITTI file has no times: name its times.txt (--times), or keep it as "
                "poses/NN.txt beside sequences/NN/times.txt");
  }
  return ReadKittiTrajectory(path, ReadTimes(*times_file));
}

Trajectory ReadKittiTrajectory(const fs::path& path, const std::vector<int64_t>& times_ns) {
  const std::vector<TextLine> lines = ReadDataLines(path);
  if (lines.size() != times_ns.size()) {
    throw Error(path.string() + ": " + std::to_string(lines.size()) + " poses for " +
                std::to_string(times_ns.size()) + " times, expected as many");
  }
  Trajectory trajectory;
  for (std::size_t i = 0; i < lines.size(); ++i) {
    trajectory.push_back({times_ns[i], ParseKittiPose(path, lines[i])});
  }
  return trajectory;
}

Trajectory ReadKittiTrajectoryByRow(const fs::path& path) {
  Trajectory trajectory;
  for (const TextLine& line : ReadDataLines(path)) {
    trajectory.push_back(
        {static_cast<int64_t>(trajectory.size()) * 1'000'000'000, ParseKittiPose(path, line)});
  }
  return trajectory;
}

std::vector<int64_t> ReadTimes(const fs::path& path) {
  std::vector<int64_t> times;
  for (const TextLine& line : ReadLines(path, /*skip_comments=*/true)) {
    const auto time = ParseSeconds(line.text);
    if (!time) {
      throw Error(At(path, line) + ": " + Quoted(line.text) + " is not a time in seconds");
    }
    if (!times.empty() && *time <= times.back()) {
      throw Error(At(path, line) + ": a time that is not after the one before");
    }
    times.push_back(*time);
  }
  return times;
}

void WriteTrajectory(const fs::path& path, const Trajectory& trajectory, TrajectoryFormat format,
                     const std::string& header) {
  nn::WriteWholeFile(path, [&](std::ostream& out) {
    // Enough digits that reading gives the same double.
    out << std::setprecision(17);
    if (format != TrajectoryFormat::kKitti) {
      std::istringstream header_lines(header);
      for (std::string line; std::getline(header_lines, line);) {
        out << "# " << line << '\n';
      }
      out << (format == TrajectoryFormat::kTum ? "# t[s] x y z qx qy qz qw\n"
                                               : "# t[ns],x,y,z,qw,qx,qy,qz\n");
    }
    for (const StampedPose& pose : trajectory) {
      const Eigen::Vector3d& t = pose.world_from_body.translation;
      const Eigen::Quaterniond& q = pose.world_from_body.rotation;
      switch (format) {
        case TrajectoryFormat::kTum:
          out << FormatSeconds(pose.timestamp_ns) << ' ' << t.x() << ' ' << t.y() << ' ' << t.z()
              << ' ' << q.x() << ' ' << q.y() << ' ' << q.z() << ' ' << q.w() << '\n';
          break;
        case TrajectoryFormat::kEuroc:
          out << pose.timestamp_ns << ',' << t.x() << ',' << t.y() << ',' << t.z() << ',' << q.w()
              << ',' << q.x() << ',' << q.y() << ',' << q.z() << '\n';
          break;
        case TrajectoryFormat::kKitti: {
          const Eigen::Matrix<double, 3, 4> matrix = pose.world_from_body.Matrix();
          for (int i = 0; i < 12; ++i) {
            out << (i > 0 ? " " : "") << matrix(i / 4, i % 4);
          }
          out << '\n';
          break;
        }
      }
    }
  });
}

}  // namespace gluevo::vo
