#include "sinkhorn.h"

#include <algorithm>
#include <limits>

namespace gluevo::nn {
namespace {

constexpr float kLargestFactor = 1e6F;

bool IsExtreme(const Eigen::Map<Eigen::VectorXf>& factors) {
  return !(factors.maxCoeff() < kLargestFactor && factors.minCoeff() > 1.0F / kLargestFactor);
}

// Chunks of rows sum the columns on their own, then the sums are added in order: a result that does
// not depend on the number of threads.
class RowChunks {
 public:
  explicit RowChunks(int64_t rows)
      : rows_(rows),
        chunk_rows_(std::max<int64_t>(16, (rows + kMostChunks - 1) / kMostChunks)),
        count_((rows + chunk_rows_ - 1) / chunk_rows_) {}

  int64_t count() const { return count_; }

  // Calls f(chunk, first row, end of rows).
  template <typename F>
  void ForEach(ThreadPool& pool, const F& f) const {
    pool.ParallelFor(count_, [&](int64_t chunk, int /*worker*/) {
      f(chunk, chunk * chunk_rows_, std::min(rows_, (chunk + 1) * chunk_rows_));
    });
  }

 private:
  static constexpr int64_t kMostChunks = 16;

  int64_t rows_;
  int64_t chunk_rows_;
  int64_t count_;
};

Eigen::Map<Eigen::VectorXf> ConstantVector(int64_t size, float value, Arena& arena) {
  Eigen::Map<Eigen::VectorXf> vector(arena.Allocate<float>({size}).data(), size);
  vector.setConstant(value);
  return vector;
}

}  // namespace

void LogOptimalTransport(TensorView<float> scores, int64_t n1, int iterations,
                         const kernels::Kernels& kernels, Workspace& workspace) {
  const int64_t rows = scores.extent(0);
  const int64_t stride = scores.extent(1);
  const int64_t n0 = rows - 1;
  const int64_t columns = n1 + 1;
  Arena& arena = workspace.arena;

  const RowChunks chunks(rows);
  const TensorView<float> sums = arena.Allocate<float>({chunks.count(), stride});
  const TensorView<float> kernel = arena.Allocate<float>({rows, stride});
  // Keypoints have mass 1, and a dustbin may take all of the other side.
  Eigen::Map<Eigen::VectorXf> mu = ConstantVector(rows, 1.0F, arena);
  Eigen::Map<Eigen::VectorXf> nu = ConstantVector(columns, 1.0F, arena);
  mu[n0] = static_cast<float>(n1);
  nu[n1] = static_cast<float>(n0);
  Eigen::Map<Eigen::VectorXf> a = ConstantVector(rows, 1.0F, arena);
  Eigen::Map<Eigen::VectorXf> b = ConstantVector(stride, 1.0F, arena);
  Eigen::Map<Eigen::VectorXf> u = ConstantVector(rows, 0.0F, arena);
  Eigen::Map<Eigen::VectorXf> v = ConstantVector(stride, 0.0F, arena);
  u = -scores.Matrix().leftCols(columns).rowwise().maxCoeff();

  const auto absorb = [&] {
    u.array() += a.array().log();
    v.array() += b.array().log();
    a.setOnes();
    b.setOnes();
  };
  const auto exponentiate = [&] {
    chunks.ForEach(workspace.pool, [&](int64_t /*chunk*/, int64_t begin, int64_t end) {
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
    chunks.ForEach(workspace.pool, [&](int64_t chunk, int64_t begin, int64_t end) {
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
