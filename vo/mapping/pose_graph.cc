#include "gluevo/vo/mapping/pose_graph.h"

#include <ceres/ceres.h>

#include <algorithm>
#include <cmath>
#include <deque>

#include "pose_graph_cost.h"
#include "pose_graph_edge.h"

namespace gluevo::vo {
namespace {

// What the scale of losses is divided by from step to step.
constexpr double kGraduation = 4.0;
constexpr int kIterations = 50;

// Cauchy's, of a scale that the graph widens.
class GraduatedLoss : public ceres::LossFunction {
 public:
  GraduatedLoss(double scale, const double& widening) : scale_(scale), widening_(widening) {}

  void Evaluate(double squared_error, double rho[3]) const override {
    const double limit = scale_ * scale_ * widening_ * widening_;
    rho[0] = limit * std::log1p(squared_error / limit);
    rho[1] = limit / (limit + squared_error);
    rho[2] = -rho[1] / (limit + squared_error);
  }

 private:
  double scale_;
  const double& widening_;
};

// From a loss that is nearly none to what it is to be.
void Solve(ceres::Problem& problem, double& widening) {
  ceres::Solver::Options options;
  options.linear_solver_type = ceres::SPARSE_NORMAL_CHOLESKY;
  options.max_num_iterations = kIterations;
  options.num_threads = 1;
  options.logging_type = ceres::SILENT;
  for (;; widening = std::max(1.0, widening / kGraduation)) {
    ceres::Solver::Summary summary;
    ceres::Solve(options, &problem, &summary);
    if (widening <= 1.0) {
      return;
    }
  }
}

// By how much the largest error of an edge exceeds the scale of its loss.
double LargestExcess(const std::vector<PoseGraphEdge>& edges,
                     const std::vector<PoseGraphNode>& nodes) {
  double largest = 1.0;
  for (const PoseGraphEdge& edge : edges) {
    if (edge.loss_scale > 0.0) {
      const internal::EdgeError error =
          internal::ErrorOfEdge(edge.a_from_b, nodes[edge.a].world_from_body,
                                nodes[edge.b].world_from_body, nullptr, nullptr);
      largest = std::max(largest, (internal::Whitening(edge) * error).norm() / edge.loss_scale);
    }
  }
  return largest;
}

}  // namespace

std::vector<Rigid3> PosesOf(const PoseGraph& graph) {
  std::vector<Rigid3> poses;
  poses.reserve(graph.nodes.size());
  for (const PoseGraphNode& node : graph.nodes) {
    poses.push_back(node.world_from_body);
  }
  return poses;
}

void OptimizePoseGraph(const std::vector<PoseGraphEdge>& edges, std::vector<PoseGraphNode>& nodes) {
  std::vector<internal::PoseParameters> poses;
  poses.reserve(nodes.size());
  for (const PoseGraphNode& node : nodes) {
    poses.push_back(internal::ParametersOf(node.world_from_body));
  }
  double widening = LargestExcess(edges, nodes);
  std::deque<GraduatedLoss> losses;
  ceres::Problem::Options problem_options;
  problem_options.loss_function_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
  ceres::Problem problem(problem_options);
  for (const PoseGraphEdge& edge : edges) {
    ceres::LossFunction* const loss =
        edge.loss_scale > 0.0 ? &losses.emplace_back(edge.loss_scale, widening) : nullptr;
    problem.AddResidualBlock(new internal::EdgeCost(edge), loss, poses[edge.a].data(),
                             poses[edge.b].data());
  }
  for (std::size_t i = 0; i < poses.size(); ++i) {
    if (!problem.HasParameterBlock(poses[i].data())) {
      continue;
    }
    problem.SetManifold(poses[i].data(), new internal::PoseManifold(nodes[i].up_in_world));
    if (nodes[i].is_fixed) {
      problem.SetParameterBlockConstant(poses[i].data());
    }
  }
  Solve(problem, widening);
  for (std::size_t i = 0; i < poses.size(); ++i) {
    if (problem.HasParameterBlock(poses[i].data())) {
      nodes[i].world_from_body = internal::PoseOf(poses[i].data());
    }
  }
}

}  // namespace gluevo::vo
