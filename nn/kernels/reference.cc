#include "kernels/reference.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>
#include <numeric>
#include <vector>

#include "gluevo/nn/elements.h"
#include "kernels/bf16.h"

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

// Channel `part` of an element.
double Channel(float element, int /*part*/) { return element; }
double Channel(Bf16Pair element, int part) {
  return Bfloat16ToFloat(part == 0 ? element.low : element.high);
}

void StoreChannel(float value, float* row, int64_t channel) { row[channel] = value; }
void StoreChannel(float value, Bf16Pair* row, int64_t channel) {
  Bf16Pair& element = row[channel / 2];
  (channel % 2 == 0 ? element.low : element.high) = ToBf16(value);
}

template <typename Element>
double DotProduct(Element a, Element b) {
  double sum = 0.0;
  for (int part = 0; part < kChannelsPer<Element>; ++part) {
    sum += Channel(a, part) * Channel(b, part);
  }
  return sum;
}

template <typename Element>
void ReferenceMatMul(const MatMul<Element>& p) {
  for (int64_t row = 0; row < p.rows; ++row) {
    for (int64_t column = 0; column < BlocksOf(p.columns) * kBlock; ++column) {
      const Element* b =
          p.b + column / kBlock * (p.a0_blocks + p.a1_blocks) * kBlock * kBlock + column % kBlock;
      double sum = p.bias != nullptr ? p.bias[column] : 0.0;
      for (int64_t i = 0; i < p.a0_blocks * kBlock; ++i, b += kBlock) {
        sum += DotProduct(p.a0[i / kBlock * p.a0_block_stride + row * kBlock + i % kBlock], *b);
      }
      for (int64_t i = 0; i < p.a1_blocks * kBlock; ++i, b += kBlock) {
        sum += DotProduct(p.a1[i / kBlock * p.a1_block_stride + row * kBlock + i % kBlock], *b);
      }
      if (p.relu) {
        sum = std::max(sum, 0.0);
      }
      const int64_t at = row * p.c_stride + column / kBlock * p.c_block_stride + column % kBlock;
      if (column < p.columns && p.residual != nullptr) {
        sum += p.residual[at];
      }
      if (column < p.columns && p.c != nullptr) {
        p.c[at] = static_cast<float>(sum);
      }
      if (p.rounded != nullptr) {
        constexpr int64_t kWide = 2 * kBlock;
        StoreChannel(column < p.columns ? static_cast<float>(sum) : 0.0F,
                     p.rounded + column / kWide * p.rounded_block_stride + row * kBlock,
                     column % kWide);
      }
    }
  }
}

template <typename Element>
void ReferenceAttention(const Attention<Element>& p) {
  constexpr int64_t kWide = kChannelsPer<Element> * kBlock;
  std::vector<double> weights(static_cast<std::size_t>(p.keys));
  for (int64_t query = 0; query < p.queries; ++query) {
    for (int64_t key = 0; key < p.keys; ++key) {
      const Element* const k = p.k + key / kBlock * p.head_blocks * kBlock * kBlock + key % kBlock;
      double sum = 0.0;
      for (int64_t i = 0; i < p.head_blocks * kBlock; ++i) {
        sum += DotProduct(p.q[i / kBlock * p.q_block_stride + query * kBlock + i % kBlock],
                          k[i * kBlock]);
      }
      weights[key] = sum;
    }
    const double largest = *std::max_element(weights.begin(), weights.end());
    double total = 0.0;
    for (double& weight : weights) {
      weight = std::exp(weight - largest);
      total += weight;
    }
    for (int64_t channel = 0; channel < p.head_blocks * kWide; ++channel) {
      const Element* const v = p.v + channel / kBlock * p.v_block_stride + channel % kBlock;
      double sum = 0.0;
      for (int64_t key = 0; key < p.keys; ++key) {
        sum += weights[key] * Channel(v[key / kChannelsPer<Element> * kBlock],
                                      static_cast<int>(key % kChannelsPer<Element>));
      }
      StoreChannel(static_cast<float>(sum / total),
                   p.out + channel / kWide * p.out_block_stride + query * kBlock, channel % kWide);
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

void ReferenceSinkhornExponentials(const SinkhornExponentials& p) {
  for (int64_t row = p.row_begin; row < p.row_end; ++row) {
    for (int64_t j = 0; j < p.stride; ++j) {
      const int64_t at = row * p.stride + j;
      const double x = j < p.columns ? static_cast<double>(p.z[at]) + p.u[row] + p.v[j] : -1000.0;
      p.k[at] = x >= -80.0 ? static_cast<float>(std::exp(x)) : 0.0F;
    }
  }
}

void ReferenceSinkhornRows(const SinkhornRows& p) {
  for (int64_t row = p.row_begin; row < p.row_end; ++row) {
    const float* k = p.k + row * p.stride;
    double sum = 0.0;
    for (int64_t j = 0; j < p.stride; ++j) {
      sum += static_cast<double>(k[j]) * p.b[j];
    }
    sum = std::max<double>(sum, std::numeric_limits<float>::min());
    p.a[row] = static_cast<float>(p.mu[row] / sum);
    for (int64_t j = 0; j < p.stride; ++j) {
      p.column_sums[j] =
          static_cast<float>(p.column_sums[j] + static_cast<double>(k[j]) * p.a[row]);
    }
  }
}

void ReferenceByteProducts(const ByteProducts& p) {
  for (int64_t i = 0; i < p.rows; ++i) {
    p.out[i] = std::inner_product(p.a, p.a + p.size, p.b + i * p.size, int32_t{0});
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
      .matmul = ReferenceMatMul<float>,
      .matmul_bf16 = ReferenceMatMul<Bf16Pair>,
      .attention = ReferenceAttention<float>,
      .attention_bf16 = ReferenceAttention<Bf16Pair>,
      .detector_softmax = ReferenceDetectorSoftmax,
      .sinkhorn_exponentials = ReferenceSinkhornExponentials,
      .sinkhorn_rows = ReferenceSinkhornRows,
      .byte_products = ReferenceByteProducts,
      .peak_flops = ReferencePeakFlops,
      .peak_flops_bf16 = ReferencePeakFlops,
  };
  return kKernels;
}

}  // namespace gluevo::nn::kernels
