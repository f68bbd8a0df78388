#pragma once

#include <array>
#include <cstdint>

#include "aliked_network.h"
#include "gluevo/nn/arena.h"

namespace gluevo::nn {

inline kernels::BlockedMap NewMap(Arena& arena, int64_t channels, int64_t height, int64_t width) {
  const int64_t blocks = kernels::BlocksOf(channels);
  return {arena.Allocate<float>({kernels::BlockedMap::Floats(blocks, height, width)}).data(),
          blocks, height, width};
}

/// Pixels of a map, ends excluded.
struct AlikedNetwork::Region {
  int64_t row, row_end, column, column_end;
  int64_t width() const { return column_end - column; }
};

/// Maps between the blocks, and scratch of each thread for a region of 8 x 56 pixels.
struct AlikedNetwork::Buffers {
  std::array<kernels::BlockedMap, 4> pooled;  ///< Inputs of the blocks, but for the first.
  std::array<kernels::BlockedMap, 4> inner;   ///< Between their two convolutions.
  TensorView<float> region;                   ///< [threads][...]
  TensorView<float> row;
  TensorView<float> winograd;

  float* RegionOf(int worker) const { return region.data() + worker * region.extent(1); }
  float* RowOf(int worker) const { return row.data() + worker * row.extent(1); }
  float* WinogradOf(int worker) const { return winograd.data() + worker * winograd.extent(1); }
};

}  // namespace gluevo::nn
