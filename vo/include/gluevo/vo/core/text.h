#pragma once

#include <cstddef>
#include <iomanip>
#include <sstream>
#include <string>

// Numbers as messages show them.
namespace gluevo::vo {

/// So many digits, however large or small the number is: "0.0123457", "1e+09".
inline std::string ShortText(double value, int digits = 6) {
  std::ostringstream text;
  text << std::setprecision(digits) << value;
  return text.str();
}

/// So many digits behind the point: "3.50".
inline std::string FixedText(double value, int decimals) {
  std::ostringstream text;
  text << std::fixed << std::setprecision(decimals) << value;
  return text.str();
}

/// "1 frame", "2 frames", "0 matches" (`plural` where it is not the noun and an s).
template <typename Count>
std::string Counted(Count count, const std::string& noun, const std::string& plural = "") {
  return std::to_string(count) + " " +
         (count == Count{1} ? noun
          : plural.empty()  ? noun + "s"
                            : plural);
}

}  // namespace gluevo::vo
