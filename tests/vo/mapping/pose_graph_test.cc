#include "gluevo/vo/mapping/pose_graph.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "gluevo/nn/error.h"
#include "gluevo/vo/geometry/manifold.h"

namespace gluevo::vo {
namespace {

constexpr std::size_t kPoses = 24;

// A round trip, bobbing and turning.
std::vector<Rigid3> Ring() {
  std::vector<Rigid3> poses;
  for (std::size_t i = 0; i < kPoses; ++i) {
    const double angle = 2.0 * std::numbers::pi * static_cast<double>(i) / kPoses;
    poses.push_back({ExpSo3({0.2 * std::sin(angle), 0.1, angle}),
                     {3.0 * std::cos(angle), 3.0 * std::sin(angle), 0.2 * std::sin(3.0 * angle)}});
  }
  return poses;
}

PoseGraphEdge EdgeOf(const std::vector<Rigid3>& poses, std::size_t a, std::size_t b) {
  return {a, b, poses[a].Inverse() * poses[b], 1e-4 * PoseCovariance::Identity()};
}

// From each pose to the next, each wrong by the same small motion.
std::vector<PoseGraphEdge> Drifting(const std::vector<Rigid3>& poses, const Rigid3& error) {
  std::vector<PoseGraphEdge> edges;
  for (std::size_t i = 0; i + 1 < poses.size(); ++i) {
    edges.push_back(EdgeOf(poses, i, i + 1));
    edges.back().a_from_b = edges.back().a_from_b * error;
  }
  return edges;
}

std::vector<Rigid3> Chained(const std::vector<Rigid3>& truth,
                            const std::vector<PoseGraphEdge>& edges) {
  std::vector<Rigid3> poses = {truth[0]};
  for (std::size_t i = 0; i + 1 < truth.size(); ++i) {
    poses.push_back(poses.back() * edges[i].a_from_b);
  }
  return poses;
}

std::vector<bool> FirstIsFixed() {
  std::vector<bool> is_fixed(kPoses, false);
  is_fixed[0] = true;
  return is_fixed;
}

double LargestError(const std::vector<Rigid3>& poses, const std::vector<Rigid3>& truth) {
  double largest = 0.0;
  for (std::size_t i = 0; i < poses.size(); ++i) {
    largest = std::max(largest, Minus(poses[i], truth[i]).norm());
  }
  return largest;
}

TEST(PoseGraph, ExactEdgesGiveTheExactPosesFromAfar) {
  const std::vector<Rigid3> truth = Ring();
  std::vector<PoseGraphEdge> edges = Drifting(truth, {});
  edges.push_back(EdgeOf(truth, 0, kPoses - 1));
  std::vector<Rigid3> poses = truth;
  for (std::size_t i = 1; i < kPoses; ++i) {
    PoseTangent delta;
    delta << 0.3, -0.2, 0.1, 0.05, 0.1, -0.1;
    poses[i] = Plus(truth[i], delta);
  }
  OptimizePoseGraph(edges, FirstIsFixed(), poses);
  EXPECT_LT(LargestError(poses, truth), 1e-6);
}

TEST(PoseGraph, ALoopTakesTheDriftAway) {
  const std::vector<Rigid3> truth = Ring();
  const Rigid3 error = {ExpSo3({0.0, 0.0, 0.01}), {0.02, -0.01, 0.005}};
  std::vector<PoseGraphEdge> edges = Drifting(truth, error);
  std::vector<Rigid3> poses = Chained(truth, edges);
  const double before = LargestError(poses, truth);
  edges.push_back(EdgeOf(truth, 0, kPoses - 1));
  edges.back().covariance *= 0.01;
  OptimizePoseGraph(edges, FirstIsFixed(), poses);
  EXPECT_LT(LargestError(poses, truth), 0.3 * before);
  EXPECT_LT(Minus(poses.back(), truth.back()).norm(), 0.02 * before);
  EXPECT_EQ(poses[0].translation, truth[0].translation);
}

TEST(PoseGraph, OneWrongLoopAmongRightOnesHardlyCounts) {
  const std::vector<Rigid3> truth = Ring();
  std::vector<PoseGraphEdge> edges = Drifting(truth, {});
  for (const std::size_t from : {std::size_t{0}, std::size_t{2}, std::size_t{4}}) {
    edges.push_back(EdgeOf(truth, from, kPoses - 1 - from));
    edges.back().loss_scale = 4.0;
  }
  PoseGraphEdge wrong = EdgeOf(truth, 1, kPoses - 2);
  wrong.a_from_b.translation += Eigen::Vector3d(2.0, 0.0, 0.0);
  const auto with_wrong = [&](bool is_robust) {
    std::vector<PoseGraphEdge> all = edges;
    all.push_back(wrong);
    all.back().loss_scale = is_robust ? 4.0 : 0.0;
    std::vector<Rigid3> poses = truth;
    OptimizePoseGraph(all, FirstIsFixed(), poses);
    return LargestError(poses, truth);
  };
  EXPECT_LT(with_wrong(true), 0.02);
  EXPECT_GT(with_wrong(false), 0.2);
}

TEST(PoseGraph, ManyLoopsThatAgreeOutvoteAWrongMotion) {
  const std::vector<Rigid3> truth = Ring();
  std::vector<PoseGraphEdge> edges = Drifting(truth, {});
  constexpr std::size_t kWrong = 11;
  edges[kWrong].a_from_b.translation += Eigen::Vector3d(0.0, 2.0, 0.0);
  edges[kWrong].a_from_b.rotation = edges[kWrong].a_from_b.rotation * ExpSo3({0.0, 0.0, 0.6});
  const std::vector<Rigid3> start = Chained(truth, edges);
  for (std::size_t i = 0; i < kPoses / 2; ++i) {
    edges.push_back(EdgeOf(truth, i, i + kPoses / 2));
  }
  const auto error = [&](double loop_scale, double odometry_scale) {
    for (std::size_t i = 0; i < edges.size(); ++i) {
      edges[i].loss_scale = i + 1 < kPoses ? odometry_scale : loop_scale;
    }
    std::vector<Rigid3> poses = start;
    OptimizePoseGraph(edges, FirstIsFixed(), poses);
    return LargestError(poses, truth);
  };
  EXPECT_LT(error(8.0, 4.0), 0.02);
  // Where odometry is never wrong, what it says bends the rest.
  EXPECT_GT(error(8.0, 0.0), 0.5);
}

TEST(PoseGraph, PosesWithoutEdgesStay) {
  const std::vector<Rigid3> truth = Ring();
  std::vector<Rigid3> poses = truth;
  OptimizePoseGraph({EdgeOf(truth, 0, 1)}, FirstIsFixed(), poses);
  EXPECT_LT(LargestError(poses, truth), 1e-12);
}

TEST(PoseGraph, ACovarianceThatIsNoneIsRefused) {
  std::vector<Rigid3> poses = Ring();
  PoseGraphEdge edge = EdgeOf(poses, 3, 4);
  edge.covariance.setZero();
  EXPECT_THROW(OptimizePoseGraph({edge}, FirstIsFixed(), poses), Error);
}

}  // namespace
}  // namespace gluevo::vo
