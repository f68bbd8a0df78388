#include "imu_table.h"

#include <Eigen/Core>
#include <algorithm>

#include "foreign_input.h"
#include "gluevo/nn/error.h"
#include "gluevo/vo/core/median.h"
#include "imu_columns.h"
#include "text_file.h"
#include "trajectory_times.h"

namespace gluevo::vo {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kFields = 7;
constexpr const char* kRow = "t wx wy wz ax ay az (EuRoC: nanoseconds, rad/s, m/s^2)";
/// Inertial units read 100 to 1000 times a second.
constexpr double kTypicalStepS = 0.005;

struct Lines {
  std::vector<TextLine> rows;
  ImuColumns columns;
  bool is_named = false;
};

Lines SplitImuLines(std::string_view text, const fs::path& path) {
  Lines lines;
  for (TextLine& line : SplitLines(text, path, /*skip_comments=*/false)) {
    if (lines.rows.empty() && (IsComment(line.text) || IsHeader(line.text))) {
      const ImuHeader header = ImuHeaderOf(line.text);
      if (!header.missing.empty() && !IsComment(line.text)) {
        throw Error(At(path, line) + ": names no " + header.missing + ", expected " + kRow);
      }
      if (header.columns) {
        lines.columns = *header.columns;
        lines.is_named = true;
      }
      continue;
    }
    if (!IsComment(line.text) && !line.text.empty()) {
      lines.rows.push_back(std::move(line));
    }
  }
  if (lines.rows.empty()) {
    throw Error(path.string() + ": no row of numbers in it, expected " + kRow);
  }
  return lines;
}

std::optional<Eigen::Vector3d> VectorOf(const std::vector<std::string_view>& fields,
                                        const std::array<std::size_t, 3>& columns) {
  Eigen::Vector3d vector;
  for (std::size_t i = 0; i < columns.size(); ++i) {
    const std::optional<double> value =
        columns[i] < fields.size() ? ParseNumber(fields[columns[i]]) : std::nullopt;
    if (!value) {
      return std::nullopt;
    }
    vector[static_cast<Eigen::Index>(i)] = *value;
  }
  return vector;
}

std::optional<ImuSample> ParseRow(const std::vector<std::string_view>& fields,
                                  const ImuColumns& columns, TimeUnit unit) {
  const std::optional<int64_t> time = ParseTime(columns, fields, unit);
  const std::optional<Eigen::Vector3d> rate = VectorOf(fields, columns.rates);
  const std::optional<Eigen::Vector3d> force = VectorOf(fields, columns.forces);
  // 127 years: differences of times fit, too.
  constexpr int64_t kLatestNs = 4'000'000'000'000'000'000;
  if (!time || *time > kLatestNs || *time < -kLatestNs || !rate || !force) {
    return std::nullopt;
  }
  return ImuSample{*time, columns.radians.value_or(1.0) * *rate,
                   columns.metres.value_or(1.0) * *force};
}

TimeUnit UnitOfTimes(const Lines& lines, char separator) {
  if (lines.columns.nanoseconds) {
    return TimeUnit::kSeconds;
  }
  std::vector<std::string_view> times;
  times.reserve(lines.rows.size());
  for (const TextLine& line : lines.rows) {
    const auto fields = SplitFields(line.text, separator);
    if (lines.columns.time < fields.size()) {
      times.push_back(fields[lines.columns.time]);
    }
  }
  return ChooseTimeUnit(times, lines.columns.unit.value_or(TimeUnit::kNanoseconds),
                        lines.columns.unit.has_value(), kTypicalStepS);
}

/// Without a header: accelerations first, as many write them, where only those can be gravity.
void FitOrder(bool is_named, ImuTable& table) {
  std::vector<double> rates;
  std::vector<double> forces;
  rates.reserve(table.samples.size());
  forces.reserve(table.samples.size());
  for (const ImuSample& sample : table.samples) {
    rates.push_back(sample.angular_velocity.norm());
    forces.push_back(sample.specific_force.norm());
  }
  // A body that is carried feels gravity most of the time.
  constexpr double kLeast = 8.0;
  constexpr double kMost = 12.0;
  const double rate = Median(std::move(rates));
  if (rate < kLeast || rate > kMost || Median(std::move(forces)) > 0.5 * kLeast) {
    return;
  }
  for (ImuSample& sample : table.samples) {
    std::swap(sample.angular_velocity, sample.specific_force);
  }
  (is_named ? table.warnings : table.notes)
      .emplace_back(is_named ? "turning rates and accelerations are exchanged in it, against its "
                               "header: gravity is in the former"
                             : "accelerations stand before turning rates in it: gravity tells");
}

/// Counts of rows that are left out.
void CheckRows(const fs::path& path, const TextLine* first_bad, std::size_t bad, std::size_t rows,
               ImuTable& table) {
  if (bad == 0) {
    return;
  }
  constexpr std::size_t kTenth = 10;
  if (table.samples.empty() || bad * kTenth > rows) {
    throw Error(At(path, *first_bad) + ": " + Quoted(first_bad->text) +
                " is no row of readings, expected " + kRow +
                (bad > 1 ? "; so are " + std::to_string(bad - 1) + " of the others" : ""));
  }
  table.warnings.push_back(std::to_string(bad) + " of " + std::to_string(rows) +
                           " rows cannot be read and are left out (the first is line " +
                           std::to_string(first_bad->number) + ")");
}

}  // namespace

ImuTable ParseImuTable(std::string_view text, const fs::path& path) {
  if (const std::string what = WhatBytesAre(text); !what.empty()) {
    throw Error(path.string() + ": " + what + ", expected a table: " + kRow);
  }
  const Lines lines = SplitImuLines(text, path);
  const TextLine& first = lines.rows.front();
  const char separator = SeparatorOf(path, first);
  const std::size_t fields = SplitFields(first.text, separator).size();
  const std::size_t expected = std::max(kFields, lines.columns.Count());
  if (fields < expected) {
    throw Error(At(path, first) + ": " + std::to_string(fields) + " fields, expected at least " +
                std::to_string(expected) + ": " + kRow);
  }
  ImuTable table;
  table.is_radians_said = lines.columns.radians.has_value();
  table.is_metres_said = lines.columns.metres.has_value();
  const TimeUnit unit = UnitOfTimes(lines, separator);
  if (unit != lines.columns.unit.value_or(TimeUnit::kNanoseconds) && !lines.columns.nanoseconds) {
    table.notes.push_back("its times are taken as " + NameOf(unit));
  }
  table.samples.reserve(lines.rows.size());
  std::size_t bad = 0;
  const TextLine* first_bad = nullptr;
  for (const TextLine& line : lines.rows) {
    if (const auto sample = ParseRow(SplitFields(line.text, separator), lines.columns, unit)) {
      table.samples.push_back(*sample);
    } else {
      first_bad = bad++ == 0 ? &line : first_bad;
    }
  }
  CheckRows(path, first_bad, bad, lines.rows.size(), table);
  FitOrder(lines.is_named, table);
  return table;
}

}  // namespace gluevo::vo
