// What coming back to places costs: a query among many key frames, and the graph of a long run.

#include <benchmark/benchmark.h>

#include <memory>
#include <numbers>
#include <random>
#include <vector>

#include "gluevo/vo/frontend/network_matcher.h"
#include "gluevo/vo/geometry/manifold.h"
#include "gluevo/vo/mapping/loop_closer.h"
#include "gluevo/vo/mapping/pose_graph.h"
#include "vo/mapping/loop_scene.h"

namespace gluevo::vo {
namespace {

constexpr int kKeypoints = 400;
constexpr int kCentres = 32;  // As in the built-in codebook.

nn::Features RandomFeatures(int values, std::mt19937& random) {
  std::normal_distribution<float> normal;
  nn::Features features;
  features.width = 752;
  features.height = 480;
  features.keypoints.setZero(kKeypoints, 2);
  features.scores.setOnes(kKeypoints);
  features.descriptors.resize(kKeypoints, values);
  for (Eigen::Index i = 0; i < features.descriptors.size(); ++i) {
    features.descriptors.data()[i] = normal(random);
  }
  features.descriptors.rowwise().normalize();
  return features;
}

// Describes a key frame and compares it with all others: none is alike, so that nothing is matched.
// Arguments: key frames, values of a descriptor.
void PlaceQuery(benchmark::State& state) {
  std::mt19937 random(1);
  const auto values = static_cast<int>(state.range(1));
  PlaceCodebook::Centres centres = RandomFeatures(values, random).descriptors.topRows(kCentres);
  LoopCloser closer(testing::SimulatedRig(), PlaceCodebook(centres, ""),
                    MakeNearestNeighborMatcher(), {.min_similarity = 1.0});
  std::vector<LoopKeyframe> known;
  for (int64_t i = 0; i < state.range(0); ++i) {
    LoopKeyframe keyframe{.timestamp_ns = i * 500'000'000};
    keyframe.features = RandomFeatures(values, random);
    known.push_back(std::move(keyframe));
  }
  closer.Load(std::move(known), {});
  LoopKeyframe query{.timestamp_ns = 0, .segment = 1};
  query.features = RandomFeatures(values, random);
  for (auto _ : state) {
    state.PauseTiming();
    LoopKeyframe next = query;
    query.timestamp_ns += 500'000'000;
    state.ResumeTiming();
    closer.Add(std::move(next));
  }
}
BENCHMARK(PlaceQuery)
    ->Args({5000, 64})
    ->Args({5000, 256})
    ->Iterations(20)
    ->Unit(benchmark::kMillisecond);

// Rounds of a circle whose heading drifts, closed by loops to the rounds before. Arguments: key
// frames, loops, and whether gravity is known.
void Graph(benchmark::State& state) {
  const auto keyframes = static_cast<std::size_t>(state.range(0));
  const auto loops = static_cast<std::size_t>(state.range(1));
  constexpr std::size_t kRound = 200;
  std::mt19937 random(1);
  std::normal_distribution<double> normal;
  const auto noisy = [&](const Rigid3& motion, double metres, double radians) {
    const auto vector = [&](double sigma) {
      return Eigen::Vector3d(sigma * normal(random), sigma * normal(random),
                             sigma * normal(random));
    };
    return motion * Rigid3{ExpSo3(vector(radians)), vector(metres)};
  };
  std::vector<Rigid3> truth;
  for (std::size_t i = 0; i < keyframes; ++i) {
    const double angle = 2.0 * std::numbers::pi * static_cast<double>(i) / kRound;
    truth.push_back(
        {ExpSo3({0.0, 0.0, angle}), {10.0 * std::cos(angle), 10.0 * std::sin(angle), 0.0}});
  }
  PoseGraph graph;
  const auto add = [&](std::size_t a, std::size_t b, double metres, double radians, double loss) {
    PoseGraphEdge edge{a, b, noisy(truth[a].Inverse() * truth[b], metres, radians),
                       PoseCovariance::Zero(), loss};
    edge.covariance.diagonal() << Eigen::Vector3d::Constant(metres * metres),
        Eigen::Vector3d::Constant(radians * radians);
    graph.edges.push_back(edge);
  };
  graph.nodes.push_back({.world_from_body = truth[0], .is_fixed = true});
  for (std::size_t i = 1; i < keyframes; ++i) {
    add(i - 1, i, 0.003, 0.001, 4.0);
    graph.nodes.push_back(
        {.world_from_body = graph.nodes.back().world_from_body * graph.edges.back().a_from_b});
  }
  for (PoseGraphNode& node : graph.nodes) {
    if (state.range(2) != 0) {
      node.up_in_world = Eigen::Vector3d::UnitZ();
    }
  }
  for (std::size_t i = 0; i < loops; ++i) {
    const std::size_t query = kRound + i * (keyframes - kRound) / loops;
    add(query % kRound, query, 0.01, 0.003, 8.0);
  }
  for (auto _ : state) {
    std::vector<PoseGraphNode> nodes = graph.nodes;
    OptimizePoseGraph(graph.edges, nodes);
    benchmark::DoNotOptimize(nodes.data());
  }
}
BENCHMARK(Graph)
    ->Args({2000, 200, 0})
    ->Args({2000, 200, 1})
    ->Iterations(3)
    ->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace gluevo::vo

BENCHMARK_MAIN();
