#include "random.h"

#include <cmath>
#include <numbers>

namespace gluevo::simulation {

NormalTable::NormalTable() {
  const int count = static_cast<int>(values_.size());
  double x = 0.0;
  // Newton on the distribution function, from the middle outwards: each step starts at its
  // neighbour's solution, on the concave side, where Newton cannot overshoot.
  for (int i = count / 2; i < count; ++i) {
    const double upper_tail = 1.0 - (i + 0.5) / count;
    for (int iteration = 0; iteration < 50; ++iteration) {
      const double density = std::exp(-0.5 * x * x) / std::sqrt(2.0 * std::numbers::pi);
      const double step = (0.5 * std::erfc(x / std::numbers::sqrt2) - upper_tail) / density;
      x += step;
      if (std::abs(step) < 1e-14) break;
    }
    values_[i] = static_cast<float>(x);
    values_[count - 1 - i] = -values_[i];
  }
}

}  // namespace gluevo::simulation
