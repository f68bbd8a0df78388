#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cstdint>

#include "gluevo/nn/features.h"

namespace gluevo::nn {

/// Divides by the norm; leaves zeros as they are.
inline void NormalizeRow(float* row, int64_t size) {
  Eigen::Map<Eigen::VectorXf> vector(row, size);
  const float norm = vector.norm();
  if (norm > 0.0F) {
    vector /= norm;
  }
}

/// The four cells, row-major indices into a map of rows x columns cells of 8 x 8 pixels, that
/// bilinear interpolation at a pixel takes, and their weights. The published sampling puts pixel k
/// at ((k - 3.5) / (8 s - 4.5)) (s - 1) of a side of s cells.
struct BilinearTaps {
  std::array<int64_t, 4> cells;
  std::array<float, 4> weights;
};

inline BilinearTaps TapsAt(float x, float y, int64_t rows, int64_t columns) {
  struct Tap {
    int64_t low, high;
    float weight;  // Of high.
  };
  const auto tap = [](float pixel, int64_t cells) {
    const auto side = static_cast<float>(cells);
    const float at = (pixel - 3.5F) / (8.0F * side - 4.5F) * (side - 1.0F);
    const float inside = std::clamp(at, 0.0F, side - 1.0F);
    const auto low = static_cast<int64_t>(inside);
    return Tap{low, std::min(low + 1, cells - 1), inside - static_cast<float>(low)};
  };
  const Tap u = tap(x, columns);
  const Tap v = tap(y, rows);
  return {{v.low * columns + u.low, v.low * columns + u.high, v.high * columns + u.low,
           v.high * columns + u.high},
          {(1.0F - v.weight) * (1.0F - u.weight), (1.0F - v.weight) * u.weight,
           v.weight * (1.0F - u.weight), v.weight * u.weight}};
}

/// Fills unit-length descriptors [N x size] at keypoints [N x 2] of a map of rows x columns cells;
/// `cell(i)` points to the descriptor of cell i.
template <typename Cell>
void SampleCells(const Features::Points& keypoints, int64_t rows, int64_t columns, int64_t size,
                 const Cell& cell, Features::RowMajor& descriptors) {
  using ConstRow = Eigen::Map<const Eigen::RowVectorXf>;
  descriptors.resize(keypoints.rows(), size);
  for (Eigen::Index i = 0; i < keypoints.rows(); ++i) {
    const BilinearTaps taps = TapsAt(keypoints(i, 0), keypoints(i, 1), rows, columns);
    const auto value = [&](int tap) { return ConstRow(cell(taps.cells[tap]), size); };
    descriptors.row(i) = taps.weights[0] * value(0) + taps.weights[1] * value(1) +
                         taps.weights[2] * value(2) + taps.weights[3] * value(3);
    NormalizeRow(&descriptors(i, 0), size);
  }
}

}  // namespace gluevo::nn
