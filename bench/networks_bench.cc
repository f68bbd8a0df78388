// Google Benchmark programs of whole networks of the published shapes, with one and two threads.
// "peak" is the share of the multiply-adds that so many threads' registers alone reach in one
// precision, measured just before each call, with the work counted as published:
// convolutions as direct ones, SuperGlue with its merge layers.

#include <benchmark/benchmark.h>

#include <algorithm>
#include <chrono>
#include <random>

#include "gluevo/nn/superglue.h"
#include "gluevo/nn/superpoint.h"
#include "kernels/kernels.h"
#include "nn/random_weights.h"

namespace gluevo::nn {
namespace {

// Times calls with the peak measured before each of them, since shared machines change their speed
// from second to second.
class Meter {
 public:
  explicit Meter(bool bf16) {
    const kernels::Kernels& kernels = kernels::KernelsFor(ChooseIsa());
    peak_flops_ = bf16 ? kernels.peak_flops_bf16 : kernels.peak_flops;
  }

  template <typename Call>
  void Time(benchmark::State& state, const Call& call) {
    const double peak = peak_flops_(0.02);
    const auto start = std::chrono::steady_clock::now();
    call();
    const std::chrono::duration<double> seconds = std::chrono::steady_clock::now() - start;
    state.SetIterationTime(seconds.count());
    possible_flops_ += peak * seconds.count();
  }

  void Report(benchmark::State& state, double flops, int threads) const {
    state.counters["peak"] =
        static_cast<double>(state.iterations()) * flops / (possible_flops_ * threads);
  }

 private:
  double (*peak_flops_)(double) = nullptr;
  double possible_flops_ = 0.0;  ///< Of one thread in all the calls' time.
};

void ExtractFeatures(benchmark::State& state) {
  constexpr int kWidth = 752;
  constexpr int kHeight = 480;
  const auto threads = static_cast<int>(state.range(0));
  const SuperPoint network(RandomSuperPoint());
  ThreadPool pool(threads);
  Workspace workspace(pool);
  std::mt19937 generator(1);
  std::vector<uint8_t> pixels(kWidth * kHeight);
  std::generate(pixels.begin(), pixels.end(),
                [&] { return static_cast<uint8_t>(generator() % 256); });
  Features features;
  const auto extract = [&] {
    network.Extract({pixels.data(), kWidth, kHeight, kWidth}, {.max_keypoints = 500}, workspace,
                    features);
  };
  extract();
  Meter meter(false);
  for (auto _ : state) {
    meter.Time(state, extract);
  }
  // Multiply-adds a pixel of each resolution: 1a and 1b, 2, 3, 4 and the heads.
  const double a_pixel = 9.0 * 64 * (1 + 64) + 2 * 9.0 * 64 * 64 / 4 + 9.0 * 128 * (64 + 128) / 16 +
                         (9.0 * 128 * (2 * 128 + 2 * 256) + 256.0 * (65 + 256)) / 64;
  meter.Report(state, 2.0 * a_pixel * kWidth * kHeight, threads);
}

void MatchFeatures(benchmark::State& state, Precision precision) {
  const auto keypoints = static_cast<int>(state.range(0));
  const auto threads = static_cast<int>(state.range(1));
  const SuperGlue network(RandomSuperGlue(), precision);
  ThreadPool pool(threads);
  Workspace workspace(pool);
  std::mt19937 generator(1);
  std::uniform_real_distribution<float> uniform(0.0F, 1.0F);
  Features features[2];
  for (Features& f : features) {
    f.width = 752;
    f.height = 480;
    f.keypoints = Features::Points::NullaryExpr(keypoints, 2, [&](Eigen::Index, Eigen::Index axis) {
      return uniform(generator) * (axis == 0 ? 752.0F : 480.0F);
    });
    f.scores = Eigen::VectorXf::NullaryExpr(keypoints, [&] { return uniform(generator); });
    f.descriptors =
        Features::RowMajor::NullaryExpr(keypoints, 256, [&] { return uniform(generator) - 0.5F; });
    f.descriptors.rowwise().normalize();
  }
  Matches matches;
  const auto match = [&] { network.Match(features[0], features[1], {}, workspace, matches); };
  match();
  Meter meter(precision == Precision::kBf16);
  for (auto _ : state) {
    meter.Time(state, match);
  }
  // Multiply-adds of both images: encoder; a layer's projections, merge and MLP; its attention;
  // the final projection and the scores.
  const auto n = static_cast<double>(keypoints);
  const double tokens = 2.0 * n;
  const double encoder = 3.0 * 32 + 32 * 64 + 64 * 128 + 128 * 256 + 256 * 256;
  const double layer = 4.0 * 256 * 256 + 512.0 * 512 + 512 * 256 + 2 * 256.0 * n;
  const double macs = tokens * (encoder + 18 * layer + 256 * 256) + n * n * 256;
  meter.Report(state, 2.0 * macs, threads);
}

BENCHMARK(ExtractFeatures)
    ->ArgName("threads")
    ->Arg(1)
    ->Arg(2)
    ->Unit(benchmark::kMillisecond)
    ->UseManualTime();
BENCHMARK_CAPTURE(MatchFeatures, float, Precision::kFloat)
    ->ArgNames({"keypoints", "threads"})
    ->ArgsProduct({{200, 500, 1024}, {1, 2}})
    ->Unit(benchmark::kMillisecond)
    ->UseManualTime();
BENCHMARK_CAPTURE(MatchFeatures, bf16, Precision::kBf16)
    ->ArgNames({"keypoints", "threads"})
    ->ArgsProduct({{200, 500, 1024}, {1, 2}})
    ->Unit(benchmark::kMillisecond)
    ->UseManualTime();

}  // namespace
}  // namespace gluevo::nn

BENCHMARK_MAIN();
