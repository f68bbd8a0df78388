#include "gluevo/vo/mapping/pose_graph.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <numbers>
#include <optional>

#include "gluevo/nn/error.h"
#include "gluevo/vo/geometry/manifold.h"
#include "gluevo/vo/geometry/pose_uncertainty.h"
#include "pose_graph_edge.h"

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

// From these poses on, the first one fixed.
void Optimize(const std::vector<PoseGraphEdge>& edges, std::vector<Rigid3>& poses,
              const std::optional<Eigen::Vector3d>& up_in_world = std::nullopt) {
  std::vector<PoseGraphNode> nodes;
  for (const Rigid3& pose : poses) {
    nodes.push_back({pose, nodes.empty(), up_in_world});
  }
  OptimizePoseGraph(edges, nodes);
  for (std::size_t i = 0; i < poses.size(); ++i) {
    poses[i] = nodes[i].world_from_body;
  }
}

double LargestError(const std::vector<Rigid3>& poses, const std::vector<Rigid3>& truth) {
  double largest = 0.0;
  for (std::size_t i = 0; i < poses.size(); ++i) {
    largest = std::max(largest, Minus(poses[i], truth[i]).norm());
  }
  return largest;
}

TEST(PoseGraphEdge, DerivativesAreThoseOfDifferences) {
  const std::vector<Rigid3> poses = Ring();
  const Rigid3 measured = poses[2].Inverse() * poses[7] *
                          Rigid3{ExpSo3({0.4, -0.3, 0.5}), Eigen::Vector3d(0.3, 0.2, -0.1)};
  internal::EdgeJacobian by_a;
  internal::EdgeJacobian by_b;
  const internal::EdgeError error =
      internal::ErrorOfEdge(measured, poses[2], poses[7], &by_a, &by_b);
  EXPECT_LT((error - ErrorOfPose(measured, poses[2].Inverse() * poses[7])).norm(), 1e-12);
  constexpr double kStep = 1e-6;
  for (int i = 0; i < 6; ++i) {
    const PoseTangent step = kStep * PoseTangent::Unit(i);
    const auto error_at = [&](const PoseTangent& of_a, const PoseTangent& of_b) {
      return internal::ErrorOfEdge(measured, Plus(poses[2], of_a), Plus(poses[7], of_b), nullptr,
                                   nullptr);
    };
    const PoseTangent none = PoseTangent::Zero();
    EXPECT_LT(((error_at(step, none) - error_at(-step, none)) / (2.0 * kStep) - by_a.col(i)).norm(),
              1e-8)
        << i;
    EXPECT_LT(((error_at(none, step) - error_at(none, -step)) / (2.0 * kStep) - by_b.col(i)).norm(),
              1e-8)
        << i;
  }
}

TEST(PoseGraphEdge, TurnsAndQuaternionsAreEachOthersDerivative) {
  const Eigen::Quaterniond q = ExpSo3({0.7, -1.1, 0.4});
  const Eigen::Matrix<double, 4, 3> by_turn = internal::QuaternionByTurn(q);
  constexpr double kStep = 1e-6;
  for (int i = 0; i < 3; ++i) {
    const Eigen::Vector3d step = kStep * Eigen::Vector3d::Unit(i);
    const Eigen::Vector4d difference =
        ((q * ExpSo3(step)).coeffs() - (q * ExpSo3(-step)).coeffs()) / (2.0 * kStep);
    EXPECT_LT((difference - by_turn.col(i)).norm(), 1e-9);
  }
  EXPECT_TRUE((internal::TurnByQuaternion(q) * by_turn).isIdentity(1e-12));
}

TEST(PoseGraph, WhereUpIsKnownTiltsStay) {
  const std::vector<Rigid3> truth = Ring();
  const Eigen::Vector3d up = Eigen::Vector3d(0.1, -0.2, 1.0).normalized();
  // Odometry turns about the vertical by too much; the loop is wrong in its tilt.
  std::vector<Rigid3> start = truth;
  for (std::size_t i = 0; i < kPoses; ++i) {
    const double share = static_cast<double>(i) / kPoses;
    start[i].rotation = ExpSo3(0.3 * share * up) * truth[i].rotation;
    start[i].translation += Eigen::Vector3d(0.5 * share, 0.2 * share, -0.3 * share);
  }
  std::vector<PoseGraphEdge> edges;
  for (std::size_t i = 0; i + 1 < kPoses; ++i) {
    edges.push_back(EdgeOf(start, i, i + 1));
  }
  edges.push_back(EdgeOf(truth, 0, kPoses - 1));
  edges.back().covariance *= 1e-4;
  edges.back().a_from_b.rotation =
      edges.back().a_from_b.rotation *
      ExpSo3(truth.back().rotation.conjugate() * Eigen::Vector3d(0.05, 0.0, 0.0));
  std::vector<Rigid3> free = start;
  Optimize(edges, free);
  std::vector<Rigid3> level = start;
  Optimize(edges, level, up);
  double largest_tilt = 0.0;
  double largest_free_tilt = 0.0;
  for (std::size_t i = 0; i < kPoses; ++i) {
    const auto tilt = [&](const Rigid3& pose) {
      return (pose.rotation.conjugate() * up - truth[i].rotation.conjugate() * up).norm();
    };
    largest_tilt = std::max(largest_tilt, tilt(level[i]));
    largest_free_tilt = std::max(largest_free_tilt, tilt(free[i]));
  }
  EXPECT_LT(largest_tilt, 1e-9);
  EXPECT_GT(largest_free_tilt, 0.03);
  // Yaw and position are the loop's.
  EXPECT_LT((level.back().translation - truth.back().translation).norm(), 0.01);
  EXPECT_LT(level.back().rotation.angularDistance(truth.back().rotation), 0.01);
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
  Optimize(edges, poses);
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
  Optimize(edges, poses);
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
    Optimize(all, poses);
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
    Optimize(edges, poses);
    return LargestError(poses, truth);
  };
  EXPECT_LT(error(8.0, 4.0), 0.02);
  // Where odometry is never wrong, what it says bends the rest.
  EXPECT_GT(error(8.0, 0.0), 0.5);
}

TEST(PoseGraph, PosesWithoutEdgesStay) {
  const std::vector<Rigid3> truth = Ring();
  std::vector<Rigid3> poses = truth;
  Optimize({EdgeOf(truth, 0, 1)}, poses);
  EXPECT_LT(LargestError(poses, truth), 1e-12);
}

TEST(PoseGraph, ACovarianceThatIsNoneIsRefused) {
  std::vector<Rigid3> poses = Ring();
  PoseGraphEdge edge = EdgeOf(poses, 3, 4);
  edge.covariance.setZero();
  EXPECT_THROW(Optimize({edge}, poses), Error);
}

}  // namespace
}  // namespace gluevo::vo
