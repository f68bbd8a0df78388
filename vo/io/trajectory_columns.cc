#include "trajectory_columns.h"

#include <algorithm>
#include <string>
#include <vector>

#include "column_names.h"

namespace gluevo::vo {
namespace {

enum class Kind { kPosition, kQuaternion, kOther };

/// What the words before an axis say; nothing for "" and words that say nothing ("RS", "pose").
std::optional<Kind> KindOf(const Words& words) {
  for (const std::string& word : words) {
    if (IsOneOf(word, {"q", "quat", "quaternion", "orientation", "rot", "rotation", "attitude", "r",
                       "o", "ori"})) {
      return Kind::kQuaternion;
    }
    if (IsOneOf(word, {"p", "pos", "position", "t", "trans", "translation", "location"})) {
      return Kind::kPosition;
    }
    if (IsOneOf(word, {"v",     "vel", "velocity", "twist",   "linear",     "angular", "b",
                       "bias",  "ba",  "bg",       "bw",      "a",          "acc",     "accel",
                       "omega", "w",   "gyro",     "cov",     "covariance", "std",     "sigma",
                       "euler", "rpy", "mag",      "gravity", "d",          "e"})) {
      return Kind::kOther;
    }
  }
  return std::nullopt;
}

/// Metres of a unit of length; nothing for words that are none.
std::optional<double> LengthOf(const Words& words) {
  for (const std::string& word : words) {
    if (IsOneOf(word, {"m", "meter", "meters", "metre", "metres"})) {
      return 1.0;
    }
    if (IsOneOf(word, {"cm", "centimeter", "centimeters", "centimetre", "centimetres"})) {
      return 0.01;
    }
    if (IsOneOf(word, {"mm", "millimeter", "millimeters", "millimetre", "millimetres"})) {
      return 0.001;
    }
    if (IsOneOf(word, {"ft", "foot", "feet"})) {
      return 0.3048;
    }
  }
  return std::nullopt;
}

/// "x_mm": the unit behind the name becomes its unit.
void TakeLength(ColumnName& name) {
  if (name.unit.empty() && name.words.size() > 1 && LengthOf({name.words.back()})) {
    name.unit = {name.words.back()};
    name.words.pop_back();
  }
}

/// q0 to q3, which are w x y z, and qi, qj, qk, qr: 0 to 3 for x to w.
std::optional<std::size_t> AxisOfQuaternion(const Words& words, bool& is_numbered) {
  std::string name;
  for (const std::string& word : words) {
    name += word;
  }
  const std::string prefix = name.substr(0, name.size() - std::min<std::size_t>(1, name.size()));
  if (!IsOneOf(prefix, {"q", "quat", "quaternion"})) {
    return std::nullopt;
  }
  constexpr std::string_view kNumbers = "1230";
  constexpr std::string_view kUnits = "ijkr";
  const std::size_t number = kNumbers.find(name.back());
  const std::size_t unit = kUnits.find(name.back());
  is_numbered = is_numbered || number != std::string_view::npos;
  return number != std::string_view::npos ? std::optional(number)
         : unit != std::string_view::npos ? std::optional(unit)
                                          : std::nullopt;
}

/// "x" to "w" as 0 to 3, where a name ends with an axis that stands alone ("q_RS_x") or behind a
/// word for it ("qx"), which then takes its place.
std::optional<std::size_t> TakeAxis(Words& words) {
  constexpr std::string_view kAxes = "xyzw";
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
  } else if (!KindOf({last})) {
    return std::nullopt;
  }
  return axis;
}

template <std::size_t kSize>
using Places = std::array<std::optional<std::size_t>, kSize>;

template <std::size_t kSize>
bool Fill(Places<kSize>& places, std::size_t axis, std::size_t column) {
  if (axis >= kSize || places[axis]) {
    return false;
  }
  places[axis] = column;
  return true;
}

template <std::size_t kSize>
bool Complete(const Places<kSize>& places) {
  return std::all_of(places.begin(), places.end(), [](const auto& place) { return place; });
}

}  // namespace

std::size_t PoseColumns::Count() const {
  std::size_t last = std::max(time, nanoseconds.value_or(0));
  last = std::max(last, *std::max_element(position.begin(), position.end()));
  return std::max(last, *std::max_element(rotation.begin(), rotation.end())) + 1;
}

PoseColumns ColumnsWithWFirst() {
  PoseColumns columns;
  columns.rotation = {5, 6, 7, 4};
  return columns;
}

std::size_t ColumnsNamed(std::string_view header) {
  const std::vector<ColumnName> names = SplitHeader(header);
  const bool is_timed =
      !names.empty() && (IsTime(names.front().words) || IsTime(names.back().words));
  return is_timed ? names.size() : 0;
}

std::optional<PoseColumns> ColumnsOfHeader(std::string_view header) {
  std::vector<ColumnName> names = SplitHeader(header);
  PoseColumns columns;
  const std::optional<TimeColumn> time = TimeColumnOf(names);
  // "rx ry rz" beside "qx qy qz qw" are angles.
  const bool has_q = std::any_of(names.begin(), names.end(), [](const ColumnName& name) {
    return !name.words.empty() && name.words.front().starts_with('q');
  });
  Places<3> position;
  Places<4> rotation;
  for (std::size_t i = 0; i < names.size(); ++i) {
    TakeLength(names[i]);
    Words words = names[i].words;
    if (IsTime(words)) {
      continue;
    }
    if (const auto axis = AxisOfQuaternion(words, columns.is_numbered)) {
      Fill(rotation, *axis, i);
      continue;
    }
    if (const std::optional<std::size_t> axis = TakeAxis(words)) {
      if (has_q && words.size() == 1 && IsOneOf(words[0], {"r", "o"})) {
        continue;
      }
      const std::optional<Kind> kind = KindOf(words);
      const bool is_position =
          kind.value_or(Kind::kPosition) == Kind::kPosition && Fill(position, *axis, i);
      // "x y z x y z w": the second x is the quaternion's.
      if (!is_position && (kind == Kind::kQuaternion || (!kind && words.empty()))) {
        Fill(rotation, *axis, i);
      }
    }
  }
  if (!time || !Complete(position) || !Complete(rotation)) {
    return std::nullopt;
  }
  static_cast<TimeColumn&>(columns) = *time;
  columns.metres = LengthOf(names[*position[0]].unit).value_or(1.0);
  std::transform(position.begin(), position.end(), columns.position.begin(),
                 [](const auto& place) { return *place; });
  std::transform(rotation.begin(), rotation.end(), columns.rotation.begin(),
                 [](const auto& place) { return *place; });
  return columns;
}

}  // namespace gluevo::vo
