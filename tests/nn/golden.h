#pragma once

#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "gluevo/nn/features.h"
#include "gluevo/nn/weights.h"

// Golden files are the outputs of an independent implementation in double precision
// (tests/golden/README.md).
namespace gluevo::nn {

inline Weights ReadGolden(const std::string& name) {
  return ReadWeights(std::string(GLUEVO_TEST_DATA_DIR) + "/" + name + ".safetensors");
}

/// Root of the mean squared difference, over the root of the mean square of the expected values.
template <typename Actual, typename Expected>
double RelativeRms(const Actual& actual, const Expected& expected) {
  EXPECT_EQ(actual.rows(), expected.rows());
  EXPECT_EQ(actual.cols(), expected.cols());
  return (actual.template cast<double>() - expected.template cast<double>()).norm() /
         expected.template cast<double>().norm();
}

/// A layer sums k products of rounded floats, which errs by about sqrt(k) units of 2^-24 of its
/// outputs' size where the signs are random; layers add up likewise. k <= 1152 and some 20 layers
/// (3 matrices a layer of SuperGlue, 10 convolutions of SuperPoint) give 150 units; twice that.
inline constexpr double kNetworkTolerance = 300.0 * 0x1p-24;

}  // namespace gluevo::nn
