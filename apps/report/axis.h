#pragma once

#include <string>
#include <vector>

namespace gluevo::apps {

/// Maps values to places in a drawing, and knows the round values to label.
struct Axis {
  double low = 0.0;    ///< Value at `begin`.
  double high = 1.0;   ///< Value at `end`; above low.
  double begin = 0.0;  ///< Pixels.
  double end = 1.0;    ///< Pixels; may lie below begin.

  double Place(double value) const { return begin + (value - low) / (high - low) * (end - begin); }
};

/// Labelled values of an axis.
struct Ticks {
  std::vector<double> values;  ///< Multiples of 1, 2 or 5 times a power of ten.
  int decimals = 0;            ///< That all of them need.
};

/// The multiples within [low, high] of the smallest round step that leaves at most `most` of them.
/// `low` must be below `high`.
Ticks RoundTicks(double low, double high, int most);

/// The range of an axis that shows [low, high]: widened where it has no extent (or none that
/// doubles can show), and to round ends of which at most `most` ticks are shown where `round`.
Axis MakeAxis(double low, double high, int most, bool round);

}  // namespace gluevo::apps
