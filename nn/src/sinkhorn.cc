#include "sinkhorn.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace gluevo::nn {

void LogOptimalTransport(TensorView<float> scores, int64_t n1, int iterations,
                         const kernels::Kernels& kernels, Workspace& workspace) {
  const int64_t rows = scores.extent(0);
  const int64_t stride = scores.extent(1);
  const int64_t n0 = rows - 1;
  const int64_t columns = n1 + 1;
  Arena& arena = workspace.arena;

  // Chunks of rows sum the columns on their own, then the sums are added in order: a result that
  // does not depend on the number of threads.
  constexpr int64_t kMostChunks = 16;
  const int64_t chunk_rows = std::max<int64_t>(16, (rows + kMostChunks - 1) / kMostChunks);
  const int64_t chunks = (rows + chunk_rows - 1) / chunk_rows;
  const TensorView<float> sums = arena.Allocate<float>({chunks, stride});
  const TensorView<float> scratch =
      arena.Allocate<float>({workspace.pool.size(), kernels::kSinkhornRows * stride});
  const TensorView<float> u = arena.Allocate<float>({rows});
  const TensorView<float> v = arena.Allocate<float>({stride});
  const TensorView<float> log_mu = arena.Allocate<float>({rows});

  // Keypoints have mass 1 and a dustbin may take all of the other side; all divided by n0 + n1.
  const float norm = -std::log(static_cast<float>(n0 + n1));
  std::fill_n(log_mu.data(), n0, norm);
  log_mu[n0] = std::log(static_cast<float>(n1)) + norm;
  Eigen::Map<Eigen::VectorXf> log_nu(arena.Allocate<float>({stride}).data(), stride);
  log_nu.setConstant(norm);
  log_nu[n1] = std::log(static_cast<float>(n0)) + norm;
  std::fill_n(u.data(), rows, 0.0F);
  std::fill_n(v.data(), stride, 0.0F);

  for (int iteration = 0; iteration < iterations; ++iteration) {
    workspace.pool.ParallelFor(chunks, [&](int64_t chunk, int worker) {
      float* const column_sums = sums.data() + chunk * stride;
      std::fill_n(column_sums, stride, 0.0F);
      kernels.sinkhorn_rows({.z = scores.data(),
                             .stride = stride,
                             .columns = columns,
                             .v = v.data(),
                             .log_mu = log_mu.data(),
                             .u = u.data(),
                             .column_sums = column_sums,
                             .scratch = scratch.data() + worker * scratch.extent(1),
                             .row_begin = chunk * chunk_rows,
                             .row_end = std::min(rows, (chunk + 1) * chunk_rows)});
    });
    // A column that is far below its rows' largest entries may vanish in single precision; the
    // smallest number lets the next iterations lift it.
    v.Vector() += log_nu - sums.Matrix()
                               .colwise()
                               .sum()
                               .transpose()
                               .array()
                               .max(std::numeric_limits<float>::min())
                               .log()
                               .matrix();
  }

  for (int64_t i = 0; i < rows; ++i) {
    for (int64_t j = 0; j < columns; ++j) {
      scores[i * stride + j] += u[i] + v[j] - norm;
    }
  }
}

}  // namespace gluevo::nn
