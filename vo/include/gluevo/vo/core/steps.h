#pragma once

#include <algorithm>
#include <cstddef>
#include <utility>
#include <vector>

#include "gluevo/vo/core/median.h"

namespace gluevo::vo {

/// The differences between values that follow each other in order of size, equal ones once.
template <typename Value>
std::vector<Value> StepsBetween(std::vector<Value> values) {
  std::sort(values.begin(), values.end());
  values.erase(std::unique(values.begin(), values.end()), values.end());
  std::vector<Value> steps;
  for (std::size_t i = 1; i < values.size(); ++i) {
    steps.push_back(values[i] - values[i - 1]);
  }
  return steps;
}

/// Their median: 0 of values that are fewer than two or all the same.
template <typename Value>
Value MedianStep(std::vector<Value> values) {
  return Median(StepsBetween(std::move(values)));
}

}  // namespace gluevo::vo
