// What coming back to places costs: a query among many key frames, and the graph of a long run.

#include <benchmark/benchmark.h>

#include <cstdint>
#include <numbers>
#include <random>
#include <vector>

#include "gluevo/vo/geometry/manifold.h"
#include "gluevo/vo/mapping/loop_closer.h"
#include "gluevo/vo/mapping/place_codebook.h"
#include "gluevo/vo/mapping/place_index.h"
#include "gluevo/vo/mapping/pose_graph.h"

namespace gluevo::vo {
namespace {

constexpr int kKeypoints = 400;
constexpr int kCentres = 32;  // As in the built-in codebook.

using Descriptors = nn::Features::RowMajor;

Descriptors RandomDescriptors(int count, int values, std::mt19937& random) {
  std::normal_distribution<float> normal;
  Descriptors descriptors(count, values);
  for (Eigen::Index i = 0; i < descriptors.size(); ++i) {
    descriptors.data()[i] = normal(random);
  }
  descriptors.rowwise().normalize();
  return descriptors;
}

// Along a path: a tenth of what an image shows is new, and what is seen is never quite the same.
class Path {
 public:
  explicit Path(int values)
      : pool_(RandomDescriptors(kPool, values, random_)), seen_(pool_.topRows(kKeypoints)) {}

  nn::Features Next() {
    constexpr int kNew = kKeypoints / 10;
    for (int i = 0; i < kNew; ++i) {
      seen_.row(next_ + i) = pool_.row(random_() % kPool);
    }
    next_ = (next_ + kNew) % kKeypoints;
    nn::Features features;
    features.keypoints.setZero(kKeypoints, 2);
    features.scores.setOnes(kKeypoints);
    features.descriptors =
        seen_ + 0.5F * pool_.middleRows(random_() % (kPool - kKeypoints), kKeypoints);
    features.descriptors.rowwise().normalize();
    return features;
  }

  PlaceCodebook Codebook() {
    // Short, as means of many descriptors are.
    return {0.1F * RandomDescriptors(kCentres, static_cast<int>(pool_.cols()), random_), ""};
  }

 private:
  static constexpr int kPool = 20'000;
  std::mt19937 random_{1};
  Descriptors pool_;
  Descriptors seen_;
  int next_ = 0;
};

// Describes an image, and finds the three places most like it among all others. Arguments: places,
// values of a descriptor, and whether one of them is the image's own.
void PlaceQuery(benchmark::State& state) {
  Path path(static_cast<int>(state.range(1)));
  const PlaceCodebook codebook = path.Codebook();
  PlaceIndex index;
  nn::Features query;
  for (int64_t i = 0; i < state.range(0); ++i) {
    query = path.Next();
    index.Add(codebook.Describe(query));
  }
  // One that is farther along the path than any is like none.
  for (int i = 0; state.range(2) == 0 && i < 20; ++i) {
    query = path.Next();
  }
  constexpr std::size_t kCandidates = 3;
  for (auto _ : state) {
    benchmark::DoNotOptimize(index.MostSimilar(codebook.Describe(query), index.size(), kCandidates,
                                               LoopOptions().min_similarity));
  }
}
BENCHMARK(PlaceQuery)
    ->Args({5000, 64, 0})
    ->Args({5000, 256, 0})
    ->Args({5000, 256, 1})
    ->Iterations(50)
    ->Unit(benchmark::kMillisecond);

// The part of it that describes. Argument: values of a descriptor.
void PlaceDescriptor(benchmark::State& state) {
  Path path(static_cast<int>(state.range(0)));
  const PlaceCodebook codebook = path.Codebook();
  const nn::Features query = path.Next();
  for (auto _ : state) {
    benchmark::DoNotOptimize(codebook.Describe(query));
  }
}
BENCHMARK(PlaceDescriptor)->Arg(64)->Arg(256)->Unit(benchmark::kMillisecond);

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
