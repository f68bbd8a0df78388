#include "kernels/reference.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>

namespace gluevo::nn::kernels {
namespace {

// One output value of the convolution before pooling.
float ConvolveAt(const Conv3x3& p, int64_t out_block, int64_t out_channel, int64_t y, int64_t x) {
  const int64_t in_block_width = p.gray ? 1 : kBlock;
  const float* w = p.weights + out_block * p.in.blocks * 9 * in_block_width * kBlock;
  double sum = p.bias[out_block * kBlock + out_channel];
  for (int64_t block = 0; block < p.in.blocks; ++block) {
    for (int64_t ky = 0; ky < 3; ++ky) {
      for (int64_t kx = 0; kx < 3; ++kx) {
        const float* pixel = p.gray ? p.in.data + (y + ky) * (p.in.width + 2) + x + kx
                                    : p.in.pixel(block, y + ky - 1, x + kx - 1);
        for (int64_t c = 0; c < in_block_width; ++c, w += kBlock) {
          sum += static_cast<double>(pixel[c]) * w[out_channel];
        }
      }
    }
  }
  if (p.relu) {
    sum = std::max(sum, 0.0);
  }
  if (p.scale != nullptr) {
    const int64_t channel = out_block * kBlock + out_channel;
    sum = sum * p.scale[channel] + p.shift[channel];
  }
  return static_cast<float>(sum);
}

void ReferenceConv3x3(const Conv3x3& p) {
  const int64_t step = p.pool ? 2 : 1;
  for (int64_t block = 0; block < p.out.blocks; ++block) {
    for (int64_t y = p.row_begin; y + step <= p.row_end; y += step) {
      for (int64_t x = p.column_begin; x + step <= p.column_end; x += step) {
        for (int64_t c = 0; c < kBlock; ++c) {
          float value = ConvolveAt(p, block, c, y, x);
          if (p.pool) {
            value = std::max({value, ConvolveAt(p, block, c, y, x + 1),
                              ConvolveAt(p, block, c, y + 1, x),
                              ConvolveAt(p, block, c, y + 1, x + 1)});
          }
          p.out.pixel(block, y / step, x / step)[c] = value;
        }
      }
    }
  }
}

void ReferenceMatMul(const MatMul& p) {
  const int64_t k = p.k0 + p.k1;
  for (int64_t row = p.row_begin; row < p.row_end; ++row) {
    for (int64_t column = 0; column < p.columns; ++column) {
      const float* b = p.b + column / kBlock * k * kBlock + column % kBlock;
      double sum = p.bias != nullptr ? p.bias[column] : 0.0;
      for (int64_t i = 0; i < p.k0; ++i) {
        const float a = p.a0[row * p.a0_stride + i / kBlock * p.a0_block_stride + i % kBlock];
        sum += static_cast<double>(a) * b[i * kBlock];
      }
      for (int64_t i = 0; i < p.k1; ++i) {
        sum += static_cast<double>(p.a1[row * p.a1_stride + i]) * b[(p.k0 + i) * kBlock];
      }
      if (p.relu) {
        sum = std::max(sum, 0.0);
      }
      if (p.residual != nullptr) {
        sum += p.residual[row * p.c_stride + column];
      }
      p.c[row * p.c_stride + column] = static_cast<float>(sum);
    }
  }
}

void ReferenceAttention(const Attention& p) {
  const int64_t v_stride = BlocksOf(p.head_dim) * kBlock;
  for (int64_t row = p.row_begin; row < p.row_end; ++row) {
    const auto score = [&](int64_t key) {
      const float* k = p.k_packed + key / kBlock * p.head_dim * kBlock + key % kBlock;
      double sum = 0.0;
      for (int64_t d = 0; d < p.head_dim; ++d) {
        sum += static_cast<double>(p.q[row * p.q_stride + d]) * k[d * kBlock];
      }
      return sum;
    };
    double largest = -std::numeric_limits<double>::infinity();
    for (int64_t key = 0; key < p.keys; ++key) {
      p.scratch[key] = static_cast<float>(score(key));
      largest = std::max<double>(largest, p.scratch[key]);
    }
    double total = 0.0;
    for (int64_t key = 0; key < p.keys; ++key) {
      total += std::exp(p.scratch[key] - largest);
    }
    for (int64_t d = 0; d < p.head_dim; ++d) {
      double sum = 0.0;
      for (int64_t key = 0; key < p.keys; ++key) {
        sum += std::exp(p.scratch[key] - largest) * p.v[key * v_stride + d];
      }
      p.out[row * p.out_stride + d] = static_cast<float>(sum / total);
    }
  }
}

void ReferenceDetectorSoftmax(const DetectorSoftmax& p) {
  for (int64_t cell_y = p.cell_row_begin; cell_y < p.cell_row_end; ++cell_y) {
    for (int64_t cell_x = 0; cell_x < p.cell_columns; ++cell_x) {
      const float* logits = p.logits + (cell_y * p.cell_columns + cell_x) * p.stride;
      const double largest = *std::max_element(logits, logits + 65);
      double total = 0.0;
      for (int i = 0; i < 65; ++i) {
        total += std::exp(logits[i] - largest);
      }
      for (int i = 0; i < 64; ++i) {
        p.scores[(cell_y * 8 + i / 8) * p.cell_columns * 8 + cell_x * 8 + i % 8] =
            static_cast<float>(std::exp(logits[i] - largest) / total);
      }
    }
  }
}

void ReferenceSinkhornRows(const SinkhornRows& p) {
  for (int64_t row = p.row_begin; row < p.row_end; ++row) {
    const float* z = p.z + row * p.stride;
    double largest = -std::numeric_limits<double>::infinity();
    for (int64_t j = 0; j < p.columns; ++j) {
      largest = std::max(largest, static_cast<double>(z[j]) + p.v[j]);
    }
    double sum = 0.0;
    for (int64_t j = 0; j < p.columns; ++j) {
      sum += std::exp(static_cast<double>(z[j]) + p.v[j] - largest);
    }
    p.u[row] = static_cast<float>(p.log_mu[row] - largest - std::log(sum));
    const double weight = std::exp(static_cast<double>(p.log_mu[row])) / sum;
    for (int64_t j = 0; j < p.columns; ++j) {
      p.column_sums[j] = static_cast<float>(
          p.column_sums[j] + weight * std::exp(static_cast<double>(z[j]) + p.v[j] - largest));
    }
  }
}

double ReferencePeakFlops(double seconds) {
  const auto start = std::chrono::steady_clock::now();
  double sum = 1.0;
  double count = 0.0;
  double elapsed = 0.0;
  while (elapsed < seconds) {
    for (int i = 0; i < 10000; ++i) {
      sum = sum * 0.999999 + 1e-6;
    }
    count += 20000.0;
    elapsed = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  }
  // The sum stays near 1; its use keeps the loop.
  return sum > 0.0 ? count / elapsed : 0.0;
}

}  // namespace

const Kernels& ReferenceKernels() {
  static constexpr Kernels kKernels = {
      .isa = Isa::kReference,
      .conv3x3 = ReferenceConv3x3,
      .matmul = ReferenceMatMul,
      .attention = ReferenceAttention,
      .detector_softmax = ReferenceDetectorSoftmax,
      .sinkhorn_rows = ReferenceSinkhornRows,
      .peak_flops = ReferencePeakFlops,
  };
  return kKernels;
}

}  // namespace gluevo::nn::kernels
