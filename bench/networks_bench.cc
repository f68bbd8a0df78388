// Google Benchmark programs of whole networks of the published shapes, with one and two threads.
// "peak" is the share of the multiply-adds that so many threads' registers alone reach in one
// precision, measured just before each call, with the work counted as published:
// convolutions as direct ones, SuperGlue with its merge layers.

#include <benchmark/benchmark.h>

#include <array>
#include <vector>

#include "gluevo/nn/aliked.h"
#include "gluevo/nn/lightglue.h"
#include "gluevo/nn/peak_share.h"
#include "gluevo/nn/random_inputs.h"
#include "gluevo/nn/random_weights.h"
#include "gluevo/nn/superglue.h"
#include "gluevo/nn/superpoint.h"

namespace gluevo::nn {
namespace {

constexpr int kWidth = 752;
constexpr int kHeight = 480;
constexpr int kKeypoints = 500;

std::array<Features, 2> RandomPair(int keypoints, int descriptor_size) {
  return {RandomFeatures(keypoints, descriptor_size, kWidth, kHeight, 1),
          RandomFeatures(keypoints, descriptor_size, kWidth, kHeight, 2)};
}

// Times a call of so many operations and tells its share of the peak.
template <typename Call>
void Measure(benchmark::State& state, Precision precision, int threads, double flops,
             const Call& call) {
  call();
  PeakShare peak(precision, threads);
  for (auto _ : state) {
    state.SetIterationTime(peak.Time(flops, call));
  }
  state.counters["peak"] = peak.share();
}

void ExtractFeatures(benchmark::State& state) {
  const auto threads = static_cast<int>(state.range(0));
  const SuperPoint network(RandomSuperPointWeights());
  ThreadPool pool(threads);
  Workspace workspace(pool);
  const std::vector<uint8_t> pixels = RandomPixels(kWidth, kHeight);
  Features features;
  Measure(state, Precision::kFloat, threads, network.Flops(kWidth, kHeight), [&] {
    network.Extract({pixels.data(), kWidth, kHeight, kWidth}, {.max_keypoints = kKeypoints},
                    workspace, features);
  });
}

// The built-in narrow SuperPoint, beside which ALIKED stands.
void ExtractNarrow(benchmark::State& state) {
  const auto threads = static_cast<int>(state.range(0));
  const SuperPoint network(OpenSuperPointWeights());
  ThreadPool pool(threads);
  Workspace workspace(pool);
  const std::vector<uint8_t> pixels = RandomPixels(kWidth, kHeight);
  Features features;
  Measure(state, Precision::kFloat, threads, network.Flops(kWidth, kHeight), [&] {
    network.Extract({pixels.data(), kWidth, kHeight, kWidth}, {.max_keypoints = kKeypoints},
                    workspace, features);
  });
}

void ExtractAliked(benchmark::State& state, const std::array<int64_t, 4>& widths, int64_t size) {
  const auto threads = static_cast<int>(state.range(0));
  const Aliked network(RandomAlikedWeights(widths, size));
  ThreadPool pool(threads);
  Workspace workspace(pool);
  const std::vector<uint8_t> pixels = RandomPixels(kWidth, kHeight);
  Features features;
  // Whatever random weights score, as many keypoints.
  const AlikedOptions options = {.keypoint_threshold = 0.0F, .max_keypoints = kKeypoints};
  Measure(state, Precision::kFloat, threads, network.Flops(kWidth, kHeight, kKeypoints), [&] {
    network.Extract({pixels.data(), kWidth, kHeight, kWidth}, options, workspace, features);
  });
}

void MatchFeatures(benchmark::State& state, Precision precision) {
  const auto keypoints = static_cast<int>(state.range(0));
  const auto threads = static_cast<int>(state.range(1));
  const SuperGlue network(RandomSuperGlueWeights(), precision);
  ThreadPool pool(threads);
  Workspace workspace(pool);
  const std::array<Features, 2> features = RandomPair(keypoints, 256);
  Matches matches;
  Measure(state, precision, threads, network.Flops(keypoints, keypoints),
          [&] { network.Match(features[0], features[1], {}, workspace, matches); });
}

// All layers.
void MatchLightGlue(benchmark::State& state) {
  const auto keypoints = static_cast<int>(state.range(0));
  const auto threads = static_cast<int>(state.range(1));
  const LightGlue network(RandomLightGlueWeights());
  ThreadPool pool(threads);
  Workspace workspace(pool);
  const std::array<Features, 2> features = RandomPair(keypoints, 128);
  const LightGlueOptions options = {.depth_confidence = 0.0F, .width_confidence = 0.0F};
  Matches matches;
  Measure(state, Precision::kFloat, threads, network.Flops(keypoints, keypoints, network.layers()),
          [&] { network.Match(features[0], features[1], options, workspace, matches); });
}

BENCHMARK(ExtractFeatures)
    ->ArgName("threads")
    ->Arg(1)
    ->Arg(2)
    ->Unit(benchmark::kMillisecond)
    ->UseManualTime();
BENCHMARK(ExtractNarrow)
    ->ArgName("threads")
    ->Arg(1)
    ->Arg(2)
    ->Unit(benchmark::kMillisecond)
    ->UseManualTime();
BENCHMARK_CAPTURE(ExtractAliked, n16, (std::array<int64_t, 4>{16, 32, 64, 128}), 128)
    ->ArgName("threads")
    ->Arg(1)
    ->Arg(2)
    ->Unit(benchmark::kMillisecond)
    ->UseManualTime();
BENCHMARK_CAPTURE(ExtractAliked, t16, (std::array<int64_t, 4>{8, 16, 32, 64}), 64)
    ->ArgName("threads")
    ->Arg(1)
    ->Arg(2)
    ->Unit(benchmark::kMillisecond)
    ->UseManualTime();
BENCHMARK(MatchLightGlue)
    ->ArgNames({"keypoints", "threads"})
    ->ArgsProduct({{200, 500, 1024}, {1, 2}})
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
