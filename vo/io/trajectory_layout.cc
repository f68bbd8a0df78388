#include "trajectory_layout.h"

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>

#include "gluevo/nn/error.h"

namespace gluevo::vo {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kPoseFields = 8;
constexpr std::size_t kKittiFields = 12;
constexpr std::size_t kMatrixFields = 16;  // KITTI's rows, and 0 0 0 1.
constexpr std::size_t kFewestNames = 4;
constexpr const char* kTumRow = "t x y z qx qy qz qw";
constexpr const char* kEurocRow = "t[ns],x,y,z,qw,qx,qy,qz";

/// Whether fields from `first` on are the rows of [R | t].
bool IsMatrix(const std::vector<std::string_view>& fields, std::size_t first) {
  std::array<double, kKittiFields> v = {};
  for (std::size_t i = 0; i < v.size(); ++i) {
    const std::optional<double> value =
        first + i < fields.size() ? ParseNumber(fields[first + i]) : std::nullopt;
    if (!value) {
      return false;
    }
    v[i] = *value;
  }
  const Eigen::Map<const Eigen::Matrix<double, 3, 4, Eigen::RowMajor>> matrix(v.data());
  const Eigen::Matrix3d rotation = matrix.leftCols<3>();
  return (rotation * rotation.transpose() - Eigen::Matrix3d::Identity()).norm() <= 0.01;
}

/// Whether in all rows the numbers that TUM's form has there are of length 1, and no rotations of
/// KITTI's: four columns more may follow.
bool HaveQuaternions(const TrajectoryLines& lines) {
  constexpr double kTolerance = 0.01;
  return lines.rows.size() > 1 &&
         std::all_of(lines.rows.begin(), lines.rows.end(), [](const TextLine& line) {
           const auto fields = SplitFields(line.text, ' ');
           Eigen::Vector4d quaternion = Eigen::Vector4d::Zero();
           for (std::size_t i = 0; i < 4 && 4 + i < fields.size(); ++i) {
             quaternion[static_cast<Eigen::Index>(i)] = ParseNumber(fields[4 + i]).value_or(0.0);
           }
           return std::abs(quaternion.norm() - 1.0) <= kTolerance && !IsMatrix(fields, 0);
         });
}

bool IsHomogeneous(const std::vector<std::string_view>& fields, std::size_t first) {
  const auto is = [&](std::size_t i, double value) {
    return ParseNumber(fields[first + i]) == value;
  };
  return fields.size() == first + kMatrixFields && IsMatrix(fields, first) && is(12, 0.0) &&
         is(13, 0.0) && is(14, 0.0) && is(15, 1.0);
}

/// Whether whole numbers that are too small for times stand first, as frames are counted.
bool AreNumbered(const TrajectoryLines& lines, char separator) {
  constexpr int64_t kMostFrames = 10'000'000;
  return std::all_of(lines.rows.begin(), lines.rows.end(), [&](const TextLine& line) {
    const std::optional<int64_t> number = ParseInteger(SplitFields(line.text, separator).front());
    return number && *number >= 0 && *number < kMostFrames;
  });
}

[[noreturn]] void ThrowNoTrajectory(const fs::path& path, const TextLine& line,
                                    std::size_t fields) {
  const bool is_positions = fields == 4 || fields == 3;
  throw Error(At(path, line) +
              ": not a trajectory: " + (is_positions ? "positions without rotations, " : "") +
              "expected 8 numbers (TUM: t x y z qx qy qz qw), 12 (KITTI) or 8 or more between "
              "commas (EuRoC)");
}

/// A tracker may begin with rows that hold no pose.
const TextLine& FirstWholeRow(const TrajectoryLines& lines) {
  const auto whole = [](const TextLine& line) {
    std::string blanks = line.text;
    std::replace_if(
        blanks.begin(), blanks.end(), [](char c) { return c == ',' || c == ';'; }, ' ');
    return SplitFields(blanks, ' ').size() >= kPoseFields;
  };
  const auto first = std::find_if(lines.rows.begin(), lines.rows.end(), whole);
  return first == lines.rows.end() ? lines.rows.front() : *first;
}

void NoteUnusualNames(const PoseColumns& header, std::vector<std::string>& notes) {
  if (header.is_numbered) {
    notes.emplace_back("q0, q1, q2, q3 are taken as the quaternion's w, x, y, z");
  }
  if (header.metres != 1.0) {
    notes.push_back("positions are in " +
                    std::string(header.metres == 0.001  ? "millimetres"
                                : header.metres == 0.01 ? "centimetres"
                                                        : "feet") +
                    ", as the header says: brought to metres");
  }
}

/// Names for each column that are not known may say another order than the usual one.
void CheckUnknownHeader(const fs::path& path, const TextLine& header, std::size_t fields,
                        std::vector<std::string>& notes) {
  if (ColumnsNamed(header.text) == fields) {
    throw Error(At(path, header) + ": names columns that are not known, " + Quoted(header.text) +
                ": expected a time, x y z and qx qy qz qw (in any order, or tx, p_x, q_w, rot_w, "
                "q0 to q3 and the like)");
  }
  notes.push_back("line " + std::to_string(header.number) + ", " + Quoted(header.text) +
                  ", does not tell the columns of a pose: their usual order is taken");
}

}  // namespace

TrajectoryLines SplitTrajectoryLines(std::string_view text, const fs::path& path) {
  TrajectoryLines lines;
  lines.is_ended = text.ends_with('\n') || text.ends_with('\r');
  for (TextLine& line : SplitLines(text, path, /*skip_comments=*/false)) {
    const bool is_comment = IsComment(line.text);
    if (lines.rows.empty() && (is_comment || IsHeader(line.text))) {
      if (std::optional<PoseColumns> columns = ColumnsOfHeader(line.text)) {
        lines.header = columns;
      } else if (ColumnsNamed(line.text) >= kFewestNames) {
        lines.unknown_header = line;
      }
      continue;
    }
    if (!is_comment && !line.text.empty()) {
      lines.rows.push_back(std::move(line));
    }
  }
  if (lines.rows.empty()) {
    throw Error(path.string() + (text.empty() ? ": an empty trajectory"
                                              : ": an empty trajectory: no row of numbers in it"));
  }
  return lines;
}

TrajectoryLayout LayoutOf(const fs::path& path, const TrajectoryLines& lines,
                          std::vector<std::string>& notes) {
  const TextLine& first = FirstWholeRow(lines);
  TrajectoryLayout layout;
  layout.separator = SeparatorOf(path, first);
  auto fields = SplitFields(first.text, layout.separator);
  if (!fields.empty() && fields.back().empty()) {
    fields.pop_back();  // VINS-Fusion ends its lines with a comma.
  }
  const bool between_commas = layout.separator != ' ';
  const auto table = [&](TrajectoryFormat format, const PoseColumns& columns) {
    layout.format = format;
    layout.columns = columns;
    layout.unit = between_commas ? TimeUnit::kNanoseconds : TimeUnit::kSeconds;
    layout.description = between_commas ? kEurocRow : kTumRow;
    return layout;
  };
  if (lines.header && fields.size() >= lines.header->Count()) {
    layout.is_named = true;
    table(between_commas ? TrajectoryFormat::kEuroc : TrajectoryFormat::kTum, *lines.header);
    layout.description = "what the header names";
    NoteUnusualNames(*lines.header, notes);
    return layout;
  }
  // Between commas 12 may also be EuRoC's eight and more.
  if ((!between_commas && fields.size() == kKittiFields && !HaveQuaternions(lines)) ||
      (fields.size() == kKittiFields && IsMatrix(fields, 0)) || IsHomogeneous(fields, 0)) {
    layout.format = TrajectoryFormat::kKitti;
    layout.matrix_column = 0;
    layout.description = "12: the rows of [R | t]";
    return layout;
  }
  if ((fields.size() == kKittiFields + 1 && IsMatrix(fields, 1)) || IsHomogeneous(fields, 1)) {
    const bool numbered = AreNumbered(lines, layout.separator);
    layout.format = numbered ? TrajectoryFormat::kKitti : TrajectoryFormat::kTum;
    layout.matrix_column = 1;
    layout.description = std::string(numbered ? "a frame's number" : "a time") +
                         " and 12 numbers: the rows of [R | t]";
    return layout;
  }
  if (lines.unknown_header) {
    CheckUnknownHeader(path, *lines.unknown_header, fields.size(), notes);
  }
  if (fields.size() < kPoseFields) {
    ThrowNoTrajectory(path, first, fields.size());
  }
  if (between_commas) {
    return table(TrajectoryFormat::kEuroc, ColumnsWithWFirst());
  }
  if (fields.size() > kPoseFields) {
    notes.push_back("rows of " + std::to_string(fields.size()) +
                    " columns: the first eight are taken as " + kTumRow);
  }
  return table(TrajectoryFormat::kTum, PoseColumns());
}

void FitOrderToUnit(TimeUnit unit, TrajectoryLayout& layout, std::vector<std::string>& notes) {
  if (layout.separator == ' ' || layout.is_named || unit != TimeUnit::kSeconds) {
    return;
  }
  layout.columns = PoseColumns();
  layout.description = "t,x,y,z,qx,qy,qz,qw";
  notes.emplace_back(
      "seconds between commas, with no line that names the columns: read in TUM's order "
      "t,x,y,z,qx,qy,qz,qw");
}

}  // namespace gluevo::vo
