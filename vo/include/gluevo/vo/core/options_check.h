#pragma once

#include <cmath>
#include <string>

#include "gluevo/nn/option_error.h"
#include "gluevo/vo/core/text.h"

namespace gluevo::vo {

/// `name`: of the field and, in brackets, of the option of `gluevo` that sets it, where one does.
/// Each throws Error with the option's name, its value and what was expected.
inline void CheckPositive(double value, const std::string& name) {
  if (!(value > 0.0) || !std::isfinite(value)) {
    throw OptionError("option " + name + " is " + ShortText(value) +
                      "; expected a positive number");
  }
}

inline void CheckAtLeast(int value, int minimum, const std::string& name) {
  if (value < minimum) {
    throw OptionError("option " + name + " is " + std::to_string(value) + "; expected at least " +
                      std::to_string(minimum));
  }
}

inline void CheckWithin(double value, double low, double high, const std::string& name) {
  if (!(value >= low && value <= high)) {
    throw OptionError("option " + name + " is " + ShortText(value) + "; expected " +
                      ShortText(low) + " to " + ShortText(high));
  }
}

}  // namespace gluevo::vo
