#pragma once

#include <cmath>

namespace gluevo::vo {

/// Huber's loss of a squared norm, halved, and what it weighs the squares with there.
struct Robust {
  double cost;
  double weight;
};

inline Robust Huber(double squared_norm, double threshold) {
  if (squared_norm <= threshold * threshold) {
    return {0.5 * squared_norm, 1.0};
  }
  const double norm = std::sqrt(squared_norm);
  return {threshold * (norm - 0.5 * threshold), threshold / norm};
}

}  // namespace gluevo::vo
