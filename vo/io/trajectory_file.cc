#include "gluevo/vo/io/trajectory_file.h"

#include <algorithm>
#include <cctype>
#include <cmath>

#include "gluevo/nn/error.h"
#include "text_file.h"
#include "trajectory_layout.h"
#include "trajectory_matrices.h"
#include "trajectory_oddities.h"
#include "trajectory_times.h"

namespace gluevo::vo {
namespace {

namespace fs = std::filesystem;

Eigen::Quaterniond ParseQuaternion(const fs::path& path, const TextLine& line,
                                   const Eigen::Quaterniond& q, TrajectoryOddities& oddities) {
  constexpr double kTolerance = 0.01;
  // What is further off is rarely a quaternion.
  constexpr double kShortest = 0.1;
  constexpr double kLongest = 10.0;
  const double length = q.norm();
  if (!(length >= kShortest && length <= kLongest)) {
    throw Error(At(path, line) + ": a quaternion of length " + std::to_string(length) +
                ", expected 1: are the columns in another order?");
  }
  if (std::abs(length - 1.0) > kTolerance) {
    oddities.not_normalized.Add(line.number);
    oddities.shortest = std::min(oddities.shortest, length);
    oddities.longest = std::max(oddities.longest, length);
  }
  return q.normalized();
}

/// The pose of a row of a table; nothing where it has none.
std::optional<PoseRow> ParseRow(const fs::path& path, const TextLine& line,
                                const TrajectoryLayout& layout, TimeUnit unit,
                                TrajectoryOddities& oddities) {
  const auto fields = SplitFields(line.text, layout.separator);
  const PoseColumns& columns = layout.columns;
  if (fields.size() < columns.Count()) {
    if (IsWithoutPose(fields)) {
      oddities.no_pose.Add(line.number);
      return std::nullopt;
    }
    throw Error(At(path, line) + ": " + std::to_string(fields.size()) +
                " fields, expected at least " + std::to_string(columns.Count()) + ": " +
                layout.description);
  }
  const auto no_value = [&](std::size_t column) { return IsNoValue(fields[column]); };
  if (no_value(columns.time) ||
      std::any_of(columns.position.begin(), columns.position.end(), no_value) ||
      std::any_of(columns.rotation.begin(), columns.rotation.end(), no_value)) {
    oddities.no_pose.Add(line.number);
    return std::nullopt;
  }
  const std::optional<int64_t> timestamp_ns = ParseTime(columns, fields, unit);
  if (!timestamp_ns) {
    throw Error(At(path, line) + ": " + Quoted(fields[columns.time]) + " is not a time in " +
                NameOf(unit));
  }
  const auto number = [&](std::size_t column) { return ParseField(path, line, fields[column]); };
  const auto& [x, y, z] = columns.position;
  const auto& [qx, qy, qz, qw] = columns.rotation;
  const Eigen::Vector3d translation =
      columns.metres * Eigen::Vector3d(number(x), number(y), number(z));
  const Eigen::Quaterniond rotation(number(qw), number(qx), number(qy), number(qz));
  if (rotation.coeffs().isZero(0.0)) {
    oddities.zeros.Add(line.number);
    return std::nullopt;
  }
  return PoseRow{line.number,
                 {*timestamp_ns, {ParseQuaternion(path, line, rotation, oddities), translation}}};
}

/// What a program that was killed leaves: too few numbers, or, without a line end, a part of one.
bool IsCutOff(const fs::path& path, const TextLine& line, const TrajectoryLayout& layout,
              TimeUnit unit, bool has_no_end) {
  const auto fields = SplitFields(line.text, layout.separator);
  if (fields.size() < layout.columns.Count() && !IsWithoutPose(fields)) {
    return true;
  }
  if (!has_no_end) {
    return false;
  }
  try {
    TrajectoryOddities oddities;
    ParseRow(path, line, layout, unit, oddities);
    return oddities.not_normalized.rows > 0;
  } catch (const Error&) {
    return true;
  }
}

/// Quaternions that are all of another length, and each of its own, are other numbers.
void CheckLengths(const fs::path& path, std::size_t rows, const TrajectoryOddities& oddities) {
  constexpr std::size_t kFewest = 3;
  constexpr double kSpread = 1.1;
  if (rows >= kFewest && oddities.not_normalized.rows == rows &&
      oddities.longest > kSpread * oddities.shortest) {
    throw Error(path.string() + ":" + std::to_string(oddities.not_normalized.first_line) +
                ": no quaternion of the file has length 1 (" + std::to_string(oddities.shortest) +
                " to " + std::to_string(oddities.longest) + "): are the columns in another order?");
  }
}

Trajectory ParseTable(const fs::path& path, const TrajectoryLines& lines, TrajectoryLayout& layout,
                      TrajectoryOddities& oddities, std::vector<std::string>& notes) {
  std::vector<std::string_view> times;
  times.reserve(lines.rows.size());
  for (const TextLine& line : lines.rows) {
    const auto fields = SplitFields(line.text, layout.separator);
    if (layout.columns.time < fields.size()) {
      times.push_back(fields[layout.columns.time]);
    }
  }
  const TimeUnit unit = layout.columns.nanoseconds
                            ? TimeUnit::kSeconds
                            : ChooseTimeUnit(times, layout.columns.unit.value_or(layout.unit),
                                             layout.columns.unit.has_value());
  if (unit != layout.columns.unit.value_or(layout.unit)) {
    notes.push_back("times are taken as " + NameOf(unit) + ", by their digits and distances");
  }
  FitOrderToUnit(unit, layout, notes);
  std::vector<PoseRow> rows;
  rows.reserve(lines.rows.size());
  for (const TextLine& line : lines.rows) {
    const bool is_last = lines.rows.size() > 1 && &line == &lines.rows.back();
    if (is_last && IsCutOff(path, line, layout, unit, !lines.is_ended)) {
      notes.push_back("the last row (line " + std::to_string(line.number) +
                      ") is cut off: left out");
      continue;
    }
    if (const std::optional<PoseRow> row = ParseRow(path, line, layout, unit, oddities)) {
      rows.push_back(*row);
    }
  }
  CheckLengths(path, rows.size(), oddities);
  return InOrderOfTime(path, std::move(rows), notes);
}

std::string Rows(const TrajectoryOddities::Count& count, const char* one, const char* many) {
  return std::to_string(count.rows) + ' ' + (count.rows == 1 ? one : many) + " (first in line " +
         std::to_string(count.first_line) + ")";
}

}  // namespace

TrajectoryFile ParseTrajectory(std::string_view text, const fs::path& path) {
  const TrajectoryLines lines = SplitTrajectoryLines(text, path);
  TrajectoryFile file;
  TrajectoryLayout layout = LayoutOf(path, lines, file.notes);
  file.format = layout.format;
  file.rows = lines.rows.size();
  TrajectoryOddities oddities;
  file.is_numbered = layout.format == TrajectoryFormat::kKitti && layout.matrix_column == 1;
  file.poses = layout.matrix_column ? ParseMatrices(path, lines, layout, oddities, file.notes)
                                    : ParseTable(path, lines, layout, oddities, file.notes);
  if (file.poses.empty()) {
    throw Error(path.string() + ": a trajectory without a pose: " +
                Rows(oddities.no_pose.rows > 0 ? oddities.no_pose : oddities.zeros, "row has",
                     "rows have") +
                " NaN, nothing or a quaternion of zeros in it");
  }
  if (oddities.no_pose.rows > 0) {
    file.notes.push_back(Rows(oddities.no_pose, "row", "rows") +
                         " of NaN, infinity, words or nothing left out");
  }
  if (oddities.zeros.rows > 0) {
    file.notes.push_back(Rows(oddities.zeros, "row", "rows") +
                         " whose rotation is all zeros left out");
  }
  if (oddities.not_normalized.rows > 0) {
    file.notes.push_back(Rows(oddities.not_normalized, "quaternion is", "quaternions are") +
                         " not of length 1: made so");
  }
  return file;
}

TrajectoryFile ReadTrajectoryFile(const fs::path& path) {
  return ParseTrajectory(ReadText(path), path);
}

}  // namespace gluevo::vo
