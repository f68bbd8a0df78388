#include "axis.h"

#include <algorithm>
#include <cmath>

namespace gluevo::apps {
namespace {

// The smallest of 1, 2, 5, 10, 20, ... (and their tenths) that is at least `least`.
double RoundStep(double least) {
  const double power = std::pow(10.0, std::floor(std::log10(least)));
  for (const double factor : {1.0, 2.0, 5.0}) {
    // A step that rounding made a little too small will do.
    if (factor * power >= least * (1.0 - 1e-9)) {
      return factor * power;
    }
  }
  return 10.0 * power;
}

}  // namespace

Ticks RoundTicks(double low, double high, int most) {
  Ticks ticks;
  const double least_steps = std::max(1, most - 1);
  double step = RoundStep((high - low) / least_steps);
  // Half a millionth of a step forgives the rounding of the ends.
  constexpr double kSlack = 5e-7;
  const auto first = [&] { return std::ceil(low / step - kSlack); };
  const auto last = [&] { return std::floor(high / step + kSlack); };
  while (last() - first() + 1.0 > most) {
    step = RoundStep(step * 1.5);
  }
  for (double i = first(); i <= last(); i += 1.0) {
    ticks.values.push_back(i * step);
  }
  ticks.decimals = std::max(0, static_cast<int>(-std::floor(std::log10(step) + 1e-9)));
  return ticks;
}

Axis MakeAxis(double low, double high, int most, bool round) {
  const double magnitude = std::max({std::abs(low), std::abs(high), 1e-9});
  if (!(high - low > 1e-9 * magnitude)) {
    const double middle = 0.5 * (low + high);
    const double half = std::max(0.5e-6 * magnitude, 1e-9);
    high = middle + half;
    low = low >= 0.0 ? std::max(0.0, middle - half) : middle - half;
  }
  if (round) {
    const double step = RoundStep((high - low) / std::max(1, most - 1));
    constexpr double kSlack = 5e-7;
    low = std::floor(low / step + kSlack) * step;
    high = std::ceil(high / step - kSlack) * step;
  }
  Axis axis;
  axis.low = low;
  axis.high = high;
  return axis;
}

}  // namespace gluevo::apps
