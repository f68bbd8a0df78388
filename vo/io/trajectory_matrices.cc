#include "trajectory_matrices.h"

#include <Eigen/LU>
#include <algorithm>
#include <array>

#include "gluevo/nn/error.h"
#include "trajectory_times.h"

namespace gluevo::vo {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kMatrixFields = 12;
constexpr int64_t kSecondNs = 1'000'000'000;

/// Nothing where the row holds no pose.
std::optional<Rigid3> ParseMatrix(const fs::path& path, const TextLine& line,
                                  const std::string_view* fields, TrajectoryOddities& oddities) {
  if (std::any_of(fields, fields + kMatrixFields, IsNoValue)) {
    oddities.no_pose.Add(line.number);
    return std::nullopt;
  }
  std::array<double, kMatrixFields> v;
  std::transform(fields, fields + kMatrixFields, v.begin(),
                 [&](std::string_view field) { return ParseField(path, line, field); });
  const Eigen::Map<const Eigen::Matrix<double, 3, 4, Eigen::RowMajor>> matrix(v.data());
  const Eigen::Matrix3d rotation = matrix.leftCols<3>();
  if (rotation.isZero(0.0)) {
    oddities.zeros.Add(line.number);
    return std::nullopt;
  }
  if (!((rotation * rotation.transpose() - Eigen::Matrix3d::Identity()).norm() <= 0.01) ||
      rotation.determinant() < 0.0) {
    throw Error(At(path, line) + ": the 3 x 3 numbers of the matrix are not a rotation");
  }
  return Rigid3{Eigen::Quaterniond(rotation).normalized(), matrix.col(3)};
}

/// The unit of the times before the matrices.
TimeUnit UnitOf(const TrajectoryLines& lines, char separator) {
  std::vector<std::string> times;
  times.reserve(lines.rows.size());
  for (const TextLine& line : lines.rows) {
    const auto fields = SplitFields(line.text, separator);
    times.emplace_back(fields.empty() ? std::string_view() : fields.front());
  }
  return ChooseTimeUnit({times.begin(), times.end()}, TimeUnit::kSeconds);
}

}  // namespace

Trajectory ParseMatrices(const fs::path& path, const TrajectoryLines& lines,
                         const TrajectoryLayout& layout, TrajectoryOddities& oddities,
                         std::vector<std::string>& notes) {
  const std::size_t first = layout.matrix_column.value();
  // A frame's number stands for as many seconds.
  const bool has_times = first > 0 && layout.format != TrajectoryFormat::kKitti;
  const TimeUnit unit = has_times ? UnitOf(lines, layout.separator) : TimeUnit::kSeconds;
  std::vector<PoseRow> rows;
  rows.reserve(lines.rows.size());
  int64_t row = -1;
  for (const TextLine& line : lines.rows) {
    ++row;
    const auto fields = SplitFields(line.text, layout.separator);
    if (fields.size() < first + kMatrixFields && IsWithoutPose(fields)) {
      oddities.no_pose.Add(line.number);
      continue;
    }
    if (fields.size() < first + kMatrixFields && row > 0 && &line == &lines.rows.back()) {
      notes.push_back("the last row (line " + std::to_string(line.number) +
                      ") is cut off: left out");
      continue;
    }
    if (fields.size() < first + kMatrixFields) {
      throw Error(At(path, line) + ": " + std::to_string(fields.size()) + " fields, expected " +
                  layout.description);
    }
    const std::optional<int64_t> time = first > 0 ? ParseShifted(fields[0], static_cast<int>(unit))
                                                  : std::optional(row * kSecondNs);
    if (!time) {
      throw Error(At(path, line) + ": " + Quoted(fields[0]) + " is not a time in " + NameOf(unit));
    }
    if (const auto pose = ParseMatrix(path, line, &fields[first], oddities)) {
      rows.push_back({line.number, {*time, *pose}});
    }
  }
  return InOrderOfTime(path, std::move(rows), notes);
}

}  // namespace gluevo::vo
