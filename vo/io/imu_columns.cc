#include "imu_columns.h"

#include <algorithm>

#include "gluevo/vo/core/angle.h"

namespace gluevo::vo {
namespace {

enum class Sensor { kGyroscope, kAccelerometer };

bool Has(const Words& words, std::initializer_list<const char*> parts) {
  return std::any_of(words.begin(), words.end(), [&](const std::string& word) {
    return std::any_of(parts.begin(), parts.end(),
                       [&](const char* part) { return word.find(part) != std::string::npos; });
  });
}

/// The sensor that the words before an axis name; nothing for biases, deviations and other things.
std::optional<Sensor> SensorOf(const Words& words) {
  if (Has(words, {"bias", "cov", "std", "sigma", "var", "mag", "quat", "orient", "pos", "temp"})) {
    return std::nullopt;
  }
  const auto any = [&](std::initializer_list<const char*> whole) {
    return std::any_of(words.begin(), words.end(),
                       [&](const std::string& word) { return IsOneOf(word, whole); });
  };
  const bool turns = Has(words, {"gyr", "angular", "omega"}) || any({"w", "g", "av", "rate"});
  const bool moves = Has(words, {"acc", "force"}) || any({"a", "la"});
  if (turns == moves) {
    return std::nullopt;
  }
  return turns ? Sensor::kGyroscope : Sensor::kAccelerometer;
}

/// "x" to "z" as 0 to 2, where a name ends with an axis that stands alone ("w_RS_S_x") or behind a
/// word ("wx", "gyroX"), which then takes its place.
std::optional<std::size_t> TakeAxis(Words& words) {
  constexpr std::string_view kAxes = "xyz";
  if (words.empty()) {
    return std::nullopt;
  }
  std::string& last = words.back();
  const std::size_t axis = kAxes.find(last.back());
  if (axis == std::string_view::npos) {
    return std::nullopt;
  }
  last.pop_back();
  if (last.empty()) {
    words.pop_back();
  }
  return axis;
}

std::optional<double> RadiansOf(const Words& unit) {
  if (Has(unit, {"rad"})) {
    return 1.0;
  }
  return Has(unit, {"deg"}) || (unit.size() == 1 && unit[0] == "dps") ? std::optional(kDegree)
                                                                      : std::nullopt;
}

std::optional<double> MetresOf(const Words& unit) {
  if (unit.empty()) {
    return std::nullopt;
  }
  constexpr double kThousandth = 1e-3;
  const std::string& first = unit.front();
  return IsOneOf(first, {"g", "gs", "g0"}) ? std::optional(kStandardGravity)
         : first == "mg"                   ? std::optional(kThousandth * kStandardGravity)
         : IsOneOf(first, {"m", "ms"}) || first.starts_with("m/") || first.starts_with("met")
             ? std::optional(1.0)
             : std::nullopt;
}

/// rostopic writes the time of recording first, and that of the reading under header.stamp.
void PreferStampOfHeader(const std::vector<ColumnName>& names, TimeColumn& time) {
  for (std::size_t i = 0; i < names.size(); ++i) {
    const Words& words = names[i].words;
    const bool is_stamp = words.size() >= 2 && words.back() == "stamp" &&
                          std::find(words.begin(), words.end(), "header") != words.end();
    if (is_stamp && !time.nanoseconds) {
      time.time = i;
      return;
    }
  }
}

using Places = std::array<std::optional<std::size_t>, 3>;

bool AnyOf(const Places& places) {
  return std::any_of(places.begin(), places.end(), [](const auto& place) { return !!place; });
}

bool AllOf(const Places& places) {
  return std::all_of(places.begin(), places.end(), [](const auto& place) { return !!place; });
}

std::array<std::size_t, 3> Whole(const Places& places) {
  return {places[0].value_or(0), places[1].value_or(0), places[2].value_or(0)};
}

}  // namespace

std::size_t ImuColumns::Count() const {
  std::size_t last = std::max(time, nanoseconds.value_or(0));
  last = std::max(last, *std::max_element(rates.begin(), rates.end()));
  return std::max(last, *std::max_element(forces.begin(), forces.end())) + 1;
}

ImuHeader ImuHeaderOf(std::string_view header) {
  const std::vector<ColumnName> names = SplitHeader(header);
  Places rates;
  Places forces;
  for (std::size_t i = 0; i < names.size(); ++i) {
    Words words = names[i].words;
    const std::optional<std::size_t> axis = TakeAxis(words);
    const std::optional<Sensor> sensor = axis ? SensorOf(words) : std::nullopt;
    if (!sensor) {
      continue;
    }
    std::optional<std::size_t>& place = (*sensor == Sensor::kGyroscope ? rates : forces)[*axis];
    place = place.value_or(i);
  }
  ImuHeader result;
  if (!AnyOf(rates) && !AnyOf(forces)) {
    return result;
  }
  const std::optional<TimeColumn> time = TimeColumnOf(names);
  if (!time || !AllOf(rates) || !AllOf(forces)) {
    result.missing = !time           ? "time"
                     : !AllOf(rates) ? "turning rates (wx, wy, wz)"
                                     : "accelerations (ax, ay, az)";
    return result;
  }
  ImuColumns columns;
  static_cast<TimeColumn&>(columns) = *time;
  PreferStampOfHeader(names, columns);
  columns.rates = Whole(rates);
  columns.forces = Whole(forces);
  columns.radians = RadiansOf(names[columns.rates[0]].unit);
  columns.metres = MetresOf(names[columns.forces[0]].unit);
  result.columns = columns;
  return result;
}

}  // namespace gluevo::vo
