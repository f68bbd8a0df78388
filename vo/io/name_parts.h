#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "stamp_unit.h"

// The numbers in names of images.
namespace gluevo::vo {

/// A name's numbers, and the name with '#' in the place of each, in lower case. "12.5" is one
/// number.
struct NameParts {
  std::string skeleton;
  std::vector<std::string> numbers;
};

/// One of the numbers, of name after name.
using NameColumn = std::vector<std::string>;

NameParts PartsOf(const std::string& name);

/// What the names of one camera's images count.
struct NameNumbers {
  std::vector<int64_t> values;  ///< One a name.
  /// Of stamps; nothing where the values are numbers of images.
  std::optional<StampUnit> unit;
  /// The values are nanoseconds already: decimal seconds, seconds and
  /// nanoseconds, or dates.
  bool in_nanoseconds = false;
  /// How it is written, where that is not usual: "seconds and nanoseconds".
  std::string form;
};

/// Which of the numbers goes up from name to name, in the order of names. All parts have the same
/// skeleton. Nothing where none does, or several do.
std::optional<NameNumbers> NumbersOf(const std::vector<NameParts>& parts);

/// Names in the order people number them: "2" before "10".
bool NumbersBefore(const std::string& a, const std::string& b);

/// The runs of letters and of digits in a name, in lower case.
struct NameWord {
  std::string text;
  std::size_t begin = 0;
};
using NameWords = std::vector<NameWord>;

NameWords WordsOf(const std::string& name);

}  // namespace gluevo::vo
