// Google Benchmark programs of whole networks of the published shapes, with one and two threads.
// "peak" is the share of the multiply-adds that so many threads' registers alone reach in one
// precision, measured just before each call, with the work counted as published:
// convolutions as direct ones, SuperGlue with its merge layers.

#include <benchmark/benchmark.h>

#include <algorithm>
#include <random>

#include "gluevo/nn/peak_share.h"
#include "gluevo/nn/random_weights.h"
#include "gluevo/nn/superglue.h"
#include "gluevo/nn/superpoint.h"

namespace gluevo::nn {
namespace {

void ExtractFeatures(benchmark::State& state) {
  constexpr int kWidth = 752;
  constexpr int kHeight = 480;
  const auto threads = static_cast<int>(state.range(0));
  const SuperPoint network(RandomSuperPointWeights());
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
  PeakShare peak(Precision::kFloat, threads);
  const double flops = network.Flops(kWidth, kHeight);
  for (auto _ : state) {
    state.SetIterationTime(peak.Time(flops, extract));
  }
  state.counters["peak"] = peak.share();
}

void MatchFeatures(benchmark::State& state, Precision precision) {
  const auto keypoints = static_cast<int>(state.range(0));
  const auto threads = static_cast<int>(state.range(1));
  const SuperGlue network(RandomSuperGlueWeights(), precision);
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
  PeakShare peak(precision, threads);
  const double flops = network.Flops(keypoints, keypoints);
  for (auto _ : state) {
    state.SetIterationTime(peak.Time(flops, match));
  }
  state.counters["peak"] = peak.share();
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
