// Google Benchmark programs of single kernels on every instruction set of this CPU, one thread.
// "peak" is the share of the multiply-adds a second that registers alone reach, measured in the
// same process just before; Winograd's convolutions count as direct ones. "bytes_per_second" is
// what a kernel must read and write once.

#include <benchmark/benchmark.h>

#include <algorithm>
#include <map>
#include <random>
#include <string>

#include "gluevo/nn/tensor.h"
#include "kernels/bf16.h"
#include "kernels/kernels.h"
#include "kernels/vectorized.h"
#include "kernels/winograd.h"

namespace gluevo::nn::kernels {
namespace {

float Value(float value, float /*element*/) { return value; }
Bf16Pair Value(float value, Bf16Pair /*element*/) { return {ToBf16(value), ToBf16(value)}; }

template <typename Element = float>
Tensor<Element> Random(int64_t size) {
  Tensor<Element> tensor(Shape{size});
  std::mt19937 generator(1);
  std::uniform_real_distribution<float> uniform(-1.0F, 1.0F);
  std::generate_n(tensor.data(), size, [&] { return Value(uniform(generator), Element{}); });
  return tensor;
}

void Report(benchmark::State& state, const Kernels& kernels, bool bf16, double flops,
            double bytes) {
  static std::map<std::pair<Isa, bool>, double> peaks;
  double& peak = peaks[{kernels.isa, bf16}];
  for (int i = 0; peak == 0.0 || i < 3; ++i) {
    peak = std::max(peak, (bf16 ? kernels.peak_flops_bf16 : kernels.peak_flops)(0.02));
  }
  const auto iterations = static_cast<double>(state.iterations());
  state.counters["peak"] =
      benchmark::Counter(iterations * flops / peak, benchmark::Counter::kIsRate);
  state.SetBytesProcessed(static_cast<int64_t>(iterations * bytes));
}

struct ConvShape {
  const char* name;
  int64_t in, out, height, width;
  bool pool;
};
constexpr ConvShape kConvolutions[] = {
    {"1b", 64, 64, 480, 752, true},   {"2a", 64, 64, 240, 376, false},
    {"3a", 64, 128, 120, 188, false}, {"3b", 128, 128, 120, 188, true},
    {"4a", 128, 128, 60, 94, false},  {"Pa", 128, 256, 60, 94, false}};

void Convolution(benchmark::State& state, const Kernels& kernels, const ConvShape& s,
                 bool winograd) {
  Tensor<float> in = Random(BlockedMap::Floats(BlocksOf(s.in), s.height, s.width));
  const BlockedMap map{in.data(), BlocksOf(s.in), s.height, s.width};
  ClearHalo(map);
  const int64_t out_height = s.pool ? s.height / 2 : s.height;
  const int64_t out_width = s.pool ? s.width / 2 : s.width;
  Tensor<float> out(Shape{BlockedMap::Floats(BlocksOf(s.out), out_height, out_width)});
  const Tensor<float> weights = Random(s.out * s.in * 9);
  Tensor<float> packed(
      Shape{winograd ? PackedWinograd3x3Floats(s.out, s.in) : PackedConv3x3Floats(s.out, s.in)});
  (winograd ? PackWinograd3x3 : PackConv3x3)(weights.data(), s.out, s.in, packed.data());
  const Tensor<float> bias = Random(BlocksOf(s.out) * kBlock);
  Tensor<float> scratch(Shape{WinogradScratchFloats(s.in)});
  for (auto _ : state) {
    (winograd ? kernels.winograd3x3
              : kernels.conv3x3)({.in = map,
                                  .weights = packed.data(),
                                  .bias = bias.data(),
                                  .relu = true,
                                  .pool = s.pool,
                                  .out = {out.data(), BlocksOf(s.out), out_height, out_width},
                                  .row_end = s.height,
                                  .column_end = s.width,
                                  .scratch = scratch.data()});
  }
  Report(state, kernels, false, 18.0 * static_cast<double>(s.in * s.out * s.height * s.width),
         4.0 * static_cast<double>(in.size() + out.size() + packed.size()));
}

void FirstConvolution(benchmark::State& state, const Kernels& kernels) {
  constexpr int64_t kHeight = 480;
  constexpr int64_t kWidth = 752;
  constexpr int64_t kOut = 64;
  Tensor<float> in = Random((kHeight + 2) * (kWidth + 2));
  Tensor<float> packed(Shape{PackedConv3x3Floats(kOut, 1)});
  PackConv3x3(Random(kOut * 9).data(), kOut, 1, packed.data());
  const Tensor<float> bias = Random(kOut);
  Tensor<float> out(Shape{BlockedMap::Floats(BlocksOf(kOut), 8, 56)});
  // In regions, as the network does.
  for (auto _ : state) {
    for (int64_t row = 0; row < kHeight; row += 8) {
      for (int64_t column = 0; column + 56 <= kWidth; column += 56) {
        kernels.conv3x3({.in = {in.data() + row * (kWidth + 2) + column, 1, kHeight, kWidth},
                         .gray = true,
                         .weights = packed.data(),
                         .bias = bias.data(),
                         .relu = true,
                         .out = {out.data(), BlocksOf(kOut), 8, 56},
                         .row_end = 8,
                         .column_end = 56});
      }
    }
  }
  const auto pixels = static_cast<double>(kHeight * (kWidth / 56 * 56));
  Report(state, kernels, false, 18.0 * kOut * pixels, 4.0 * (1 + kOut) * pixels);
}

constexpr int64_t kRows = 48;  // Of a band of SuperGlue.

template <typename Element>
void Product(benchmark::State& state, const Kernels& kernels, int64_t in, int64_t columns) {
  constexpr bool kBf16 = kChannelsPer<Element> == 2;
  const Tensor<Element> a = Random<Element>(ElementBlocks<Element>(in) * kRows * kBlock);
  const Tensor<Element> b = Random<Element>(PackedMatrixSize<Element>(columns, in));
  const Tensor<float> bias = Random(columns);
  Tensor<float> c(Shape{columns * kRows});
  Tensor<Bf16Pair> rounded(Shape{ElementBlocks<Bf16Pair>(columns) * kRows * kBlock});
  for (auto _ : state) {
    Multiply<Element>(kernels, {.a0 = a.data(),
                                .a0_block_stride = kRows * kBlock,
                                .a0_blocks = ElementBlocks<Element>(in),
                                .b = b.data(),
                                .bias = bias.data(),
                                .relu = true,
                                .c = kBf16 ? nullptr : c.data(),
                                .c_block_stride = kRows * kBlock,
                                .rounded = kBf16 ? rounded.data() : nullptr,
                                .rounded_block_stride = kRows * kBlock,
                                .columns = columns,
                                .rows = kRows});
  }
  const double out_bytes = static_cast<double>(columns * kRows) * (kBf16 ? 2.0 : 4.0);
  Report(state, kernels, kBf16, 2.0 * static_cast<double>(kRows * in * columns),
         4.0 * static_cast<double>(a.size() + b.size()) + out_bytes);
}

template <typename Element>
void AttentionOfHead(benchmark::State& state, const Kernels& kernels, int64_t keys) {
  constexpr bool kBf16 = kChannelsPer<Element> == 2;
  constexpr int64_t kBlocks = 64 / kBlock / kChannelsPer<Element>;
  const int64_t padded = ElementBlocks<Element>(keys) * kBlock * kChannelsPer<Element>;
  const Tensor<Element> q = Random<Element>(kBlocks * kRows * kBlock);
  const Tensor<Element> k = Random<Element>(kBlocks * padded * kBlock);
  const Tensor<Element> v = Random<Element>(kBlocks * padded * kBlock);
  Tensor<Element> out(Shape{kBlocks * kRows * kBlock});
  Tensor<float> scratch(Shape{AttentionScratchFloats(keys)});
  for (auto _ : state) {
    Attend<Element>(kernels, {.q = q.data(),
                              .q_block_stride = kRows * kBlock,
                              .head_blocks = kBlocks,
                              .k = k.data(),
                              .v = v.data(),
                              .v_block_stride = padded * kBlock / kChannelsPer<Element>,
                              .keys = keys,
                              .out = out.data(),
                              .out_block_stride = kRows * kBlock,
                              .queries = kRows,
                              .scratch = scratch.data()});
  }
  Report(state, kernels, kBf16, 4.0 * 64.0 * static_cast<double>(kRows * keys),
         4.0 * static_cast<double>(q.size() + k.size() + v.size() + out.size()));
}

void Detector(benchmark::State& state, const Kernels& kernels) {
  constexpr int64_t kColumns = 94;
  constexpr int64_t kCellRows = 60;
  constexpr int64_t kStride = 80;
  const Tensor<float> logits = Random(kCellRows * kColumns * kStride);
  Tensor<float> scores(Shape{64 * kCellRows * kColumns});
  for (auto _ : state) {
    kernels.detector_softmax({.logits = logits.data(),
                              .stride = kStride,
                              .cell_columns = kColumns,
                              .scores = scores.data(),
                              .cell_row_begin = 0,
                              .cell_row_end = kCellRows});
  }
  state.SetBytesProcessed(state.iterations() * 4 * (logits.size() + scores.size()));
  state.counters["exponentials"] =
      benchmark::Counter(static_cast<double>(state.iterations()) * 65.0 * kCellRows * kColumns,
                         benchmark::Counter::kIsRate);
}

void SinkhornIteration(benchmark::State& state, const Kernels& kernels, int64_t keypoints) {
  const int64_t rows = keypoints + 1;
  const int64_t stride = BlocksOf(rows) * kBlock;
  Tensor<float> k = Random(rows * stride);
  k.view().Vector() = k.view().Vector().cwiseAbs();
  const Tensor<float> b = Random(stride);
  const Tensor<float> mu = Random(rows);
  Tensor<float> a(Shape{rows});
  Tensor<float> sums(Shape{stride});
  for (auto _ : state) {
    std::fill_n(sums.data(), stride, 0.0F);
    kernels.sinkhorn_rows({.k = k.data(),
                           .stride = stride,
                           .b = b.data(),
                           .mu = mu.data(),
                           .a = a.data(),
                           .column_sums = sums.data(),
                           .row_begin = 0,
                           .row_end = rows});
  }
  Report(state, kernels, false, 4.0 * static_cast<double>(rows * stride),
         4.0 * static_cast<double>(k.size()));
}

void Exponentials(benchmark::State& state, const Kernels& kernels) {
  constexpr int64_t kSize = 512;
  const Tensor<float> z = Random(kSize * kSize);
  const Tensor<float> u = Random(kSize);
  Tensor<float> k(Shape{kSize * kSize});
  for (auto _ : state) {
    kernels.sinkhorn_exponentials({.z = z.data(),
                                   .stride = kSize,
                                   .columns = kSize,
                                   .u = u.data(),
                                   .v = u.data(),
                                   .k = k.data(),
                                   .row_begin = 0,
                                   .row_end = kSize});
  }
  state.SetBytesProcessed(state.iterations() * 8 * kSize * kSize);
  state.counters["exponentials"] = benchmark::Counter(
      static_cast<double>(state.iterations()) * kSize * kSize, benchmark::Counter::kIsRate);
}

void RegisterAll(const Kernels& kernels) {
  const std::string isa = IsaName(kernels.isa) + "/";
  const auto add = [&](const std::string& name, const auto& f) {
    benchmark::RegisterBenchmark((isa + name).c_str(), f)->Unit(benchmark::kMicrosecond);
  };
  add("convolution/1a", [&kernels](benchmark::State& s) { FirstConvolution(s, kernels); });
  for (const ConvShape& shape : kConvolutions) {
    add(std::string("winograd/") + shape.name,
        [&](benchmark::State& s) { Convolution(s, kernels, shape, true); });
    add(std::string("convolution/") + shape.name,
        [&](benchmark::State& s) { Convolution(s, kernels, shape, false); });
  }
  for (const auto& [in, out] :
       {std::pair<int64_t, int64_t>{256, 256}, {512, 512}, {512, 256}, {256, 80}}) {
    const std::string shape = std::to_string(in) + "x" + std::to_string(out);
    add("product/" + shape, [&kernels, in = in, out = out](benchmark::State& s) {
      Product<float>(s, kernels, in, out);
    });
    add("product_bf16/" + shape, [&kernels, in = in, out = out](benchmark::State& s) {
      Product<Bf16Pair>(s, kernels, in, out);
    });
  }
  for (const int64_t keypoints : {200, 500, 1024}) {
    const std::string count = std::to_string(keypoints);
    add("attention/" + count, [&kernels, keypoints](benchmark::State& s) {
      AttentionOfHead<float>(s, kernels, keypoints);
    });
    add("attention_bf16/" + count, [&kernels, keypoints](benchmark::State& s) {
      AttentionOfHead<Bf16Pair>(s, kernels, keypoints);
    });
    add("sinkhorn/" + count,
        [&kernels, keypoints](benchmark::State& s) { SinkhornIteration(s, kernels, keypoints); });
  }
  add("exponentials", [&kernels](benchmark::State& s) { Exponentials(s, kernels); });
  add("detector_softmax", [&kernels](benchmark::State& s) { Detector(s, kernels); });
}

}  // namespace
}  // namespace gluevo::nn::kernels

int main(int argc, char** argv) {
  for (const auto* const kernels : gluevo::nn::kernels::VectorizedKernels()) {
    gluevo::nn::kernels::RegisterAll(*kernels);
  }
  benchmark::Initialize(&argc, argv);
  if (benchmark::ReportUnrecognizedArguments(argc, argv)) {
    return 1;
  }
  benchmark::RunSpecifiedBenchmarks();
  benchmark::Shutdown();
  return 0;
}
