#pragma once

#include <algorithm>
#include <cstdint>

#include "gluevo/nn/thread_pool.h"

namespace gluevo::nn {

/// Calls f(row_begin, row_end, column_begin, column_end, worker) for the regions of a map of
/// height x width pixels that one call of a convolution kernel takes: whole tiles of 4x4 outputs,
/// at most 8 x 56 pixels, whose intermediate values fit the second-level cache.
template <typename F>
void ForRegions(ThreadPool& pool, int64_t height, int64_t width, const F& f) {
  constexpr int64_t kRows = 8;
  constexpr int64_t kTileColumns = 14;
  const int64_t tiles = (width + 3) / 4;
  const int64_t parts = (tiles + kTileColumns - 1) / kTileColumns;
  const int64_t bands = (height + kRows - 1) / kRows;
  pool.ParallelFor(bands * parts, [&](int64_t task, int worker) {
    const int64_t row = task / parts * kRows;
    const int64_t part = task % parts;
    f(row, std::min(row + kRows, height), tiles * part / parts * 4,
      std::min(tiles * (part + 1) / parts * 4, width), worker);
  });
}

}  // namespace gluevo::nn
