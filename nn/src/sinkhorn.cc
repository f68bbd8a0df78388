#include "sinkhorn.h"

#include <algorithm>
#include <limits>

namespace gluevo::nn {
namespace {

constexpr float kLargestFactor = 1e6F;

bool IsExtreme(const Eigen::Map<Eigen::VectorXf>& factors) {
  return !(factors.maxCoeff() < kLargestFactor && factors.minCoeff() > 1.0F / kLargestFactor);
}

}  // namespace

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
  const TensorView<float> kernel = arena.Allocate<float>({rows, stride});
  const auto vector = [&](int64_t size, float value) {
    Eigen::Map<Eigen::VectorXf> map(arena.Allocate<float>({size}).data(), size);
    map.setConstant(value);
    return map;
  };
  // Keypoints have mass 1, and a dustbin may take all of the other side.
  Eigen::Map<Eigen::VectorXf> mu = vector(rows, 1.0F);
  Eigen::Map<Eigen::VectorXf> nu = vector(columns, 1.0F);
  mu[n0] = static_cast<float>(n1);
  nu[n1] = static_cast<float>(n0);
  Eigen::Map<Eigen::VectorXf> a = vector(rows, 1.0F);
  Eigen::Map<Eigen::VectorXf> b = vector(stride, 1.0F);
  Eigen::Map<Eigen::VectorXf> u = vector(rows, 0.0F);
  Eigen::Map<Eigen::VectorXf> v = vector(stride, 0.0F);
  u = -scores.Matrix().leftCols(columns).rowwise().maxCoeff();

  const auto for_chunks = [&](const auto& f) {
    workspace.pool.ParallelFor(chunks, [&](int64_t chunk, int /*worker*/) {
      f(chunk, chunk * chunk_rows, std::min(rows, (chunk + 1) * chunk_rows));
    });
  };
  const auto absorb = [&] {
    u.array() += a.array().log();
    v.array() += b.array().log();
    a.setOnes();
    b.setOnes();
  };
  const auto exponentiate = [&] {
    for_chunks([&](int64_t /*chunk*/, int64_t begin, int64_t end) {
      kernels.sinkhorn_exponentials({.z = scores.data(),
                                     .stride = stride,
                                     .columns = columns,
                                     .u = u.data(),
                                     .v = v.data(),
                                     .k = kernel.data(),
                                     .row_begin = begin,
                                     .row_end = end});
    });
  };

  exponentiate();
  for (int iteration = 0; iteration < iterations; ++iteration) {
    if (IsExtreme(a) || IsExtreme(b)) {
      absorb();
      exponentiate();
    }
    for_chunks([&](int64_t chunk, int64_t begin, int64_t end) {
      float* const column_sums = sums.data() + chunk * stride;
      std::fill_n(column_sums, stride, 0.0F);
      kernels.sinkhorn_rows({.k = kernel.data(),
                             .stride = stride,
                             .b = b.data(),
                             .mu = mu.data(),
                             .a = a.data(),
                             .column_sums = column_sums,
                             .row_begin = begin,
                             .row_end = end});
    });
    b.head(columns).array() =
        nu.array() / sums.Matrix().leftCols(columns).colwise().sum().transpose().array().max(
                         std::numeric_limits<float>::min());
  }

  absorb();
  scores.Matrix().leftCols(columns).colwise() += u;
  scores.Matrix().leftCols(columns).rowwise() += v.head(columns).transpose();
}

}  // namespace gluevo::nn
