#include "gluevo/vo/mapping/pose_graph.h"

#include <ceres/ceres.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <cmath>
#include <deque>
#include <optional>
#include <string>

#include "gluevo/nn/error.h"
#include "gluevo/vo/geometry/manifold.h"
#include "pose_graph_edge.h"

namespace gluevo::vo {
namespace {

// What the scale of losses is divided by from step to step.
constexpr double kGraduation = 4.0;
constexpr int kIterations = 50;

// Position, and quaternion as Eigen stores it.
constexpr int kSize = 7;
using Parameters = std::array<double, kSize>;

Rigid3 PoseOf(const double* parameters) {
  return {Eigen::Quaterniond(Eigen::Map<const Eigen::Vector4d>(parameters + 3)).normalized(),
          Eigen::Map<const Eigen::Vector3d>(parameters)};
}

Parameters ParametersOf(const Rigid3& pose) {
  Parameters parameters{};
  Eigen::Map<Eigen::Vector3d>(parameters.data()) = pose.translation;
  Eigen::Map<Eigen::Vector4d>(parameters.data() + 3) = pose.rotation.coeffs();
  return parameters;
}

// The poses' error against the measured motion, whitened.
class EdgeCost : public ceres::SizedCostFunction<6, kSize, kSize> {
 public:
  EdgeCost(const Rigid3& a_from_b, const Eigen::Matrix<double, 6, 6>& whitening)
      : a_from_b_(a_from_b), whitening_(whitening) {}

  bool Evaluate(double const* const* poses, double* residuals, double** jacobians) const override {
    const std::array<Rigid3, 2> world_from = {PoseOf(poses[0]), PoseOf(poses[1])};
    std::array<internal::EdgeJacobian, 2> by;
    Eigen::Map<internal::EdgeError>{residuals} =
        whitening_ * internal::ErrorOfEdge(a_from_b_, world_from[0], world_from[1], &by[0], &by[1]);
    for (std::size_t i = 0; jacobians != nullptr && i < by.size(); ++i) {
      if (jacobians[i] == nullptr) {
        continue;
      }
      Eigen::Map<Eigen::Matrix<double, 6, kSize, Eigen::RowMajor>> jacobian(jacobians[i]);
      const internal::EdgeJacobian whitened = whitening_ * by[i];
      jacobian.leftCols<3>() = whitened.leftCols<3>();
      jacobian.rightCols<4>() =
          whitened.rightCols<3>() * internal::TurnByQuaternion(world_from[i].rotation);
    }
    return true;
  }

 private:
  Rigid3 a_from_b_;
  Eigen::Matrix<double, 6, 6> whitening_;
};

// Position in the world and turn in the body; without an axis any turn.
class PoseManifold : public ceres::Manifold {
 public:
  explicit PoseManifold(const std::optional<Eigen::Vector3d>& axis_in_world)
      : axis_in_world_(axis_in_world) {}

  int AmbientSize() const override { return kSize; }
  int TangentSize() const override { return axis_in_world_ ? 4 : 6; }

  bool Plus(const double* x, const double* delta, double* sum) const override {
    const Rigid3 pose = PoseOf(x);
    const Eigen::Map<const Eigen::VectorXd> turn(delta + 3, TangentSize() - 3);
    PoseTangent tangent;
    tangent << Eigen::Map<const Eigen::Vector3d>(delta), TurnsOf(pose.rotation) * turn;
    const Parameters moved = ParametersOf(vo::Plus(pose, tangent));
    std::copy(moved.begin(), moved.end(), sum);
    return true;
  }

  bool PlusJacobian(const double* x, double* jacobian) const override {
    Eigen::Map<Jacobian> derivative(jacobian, kSize, TangentSize());
    const Eigen::Quaterniond rotation = PoseOf(x).rotation;
    derivative.setZero();
    derivative.topLeftCorner<3, 3>().setIdentity();
    derivative.bottomRightCorner(4, TangentSize() - 3) =
        internal::QuaternionByTurn(rotation) * TurnsOf(rotation);
    return true;
  }

  bool Minus(const double* y, const double* x, double* difference) const override {
    const Rigid3 pose = PoseOf(x);
    const PoseTangent tangent = vo::Minus(PoseOf(y), pose);
    Eigen::Map<Eigen::VectorXd>(difference, TangentSize()) << tangent.head<3>(),
        TurnsOf(pose.rotation).transpose() * tangent.tail<3>();
    return true;
  }

  bool MinusJacobian(const double* x, double* jacobian) const override {
    Eigen::Map<Jacobian> derivative(jacobian, TangentSize(), kSize);
    const Eigen::Quaterniond rotation = PoseOf(x).rotation;
    derivative.setZero();
    derivative.topLeftCorner<3, 3>().setIdentity();
    derivative.bottomRightCorner(TangentSize() - 3, 4) =
        TurnsOf(rotation).transpose() * internal::TurnByQuaternion(rotation);
    return true;
  }

 private:
  using Jacobian = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
  using Turns = Eigen::Matrix<double, 3, Eigen::Dynamic, Eigen::ColMajor, 3, 3>;

  // Columns: the turns in the body that are allowed, of unit length.
  Turns TurnsOf(const Eigen::Quaterniond& rotation) const {
    return axis_in_world_ ? Turns(rotation.conjugate() * *axis_in_world_)
                          : Turns(Eigen::Matrix3d::Identity());
  }

  std::optional<Eigen::Vector3d> axis_in_world_;
};

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

// W with W^T W the inverse of the covariance.
Eigen::Matrix<double, 6, 6> Whitening(const PoseGraphEdge& edge) {
  const Eigen::LLT<PoseCovariance> cholesky(edge.covariance);
  if (cholesky.info() != Eigen::Success) {
    throw Error("the covariance of the edge between poses " + std::to_string(edge.a) + " and " +
                std::to_string(edge.b) + " of a graph is not positive definite");
  }
  Eigen::Matrix<double, 6, 6> whitening = Eigen::Matrix<double, 6, 6>::Identity();
  cholesky.matrixL().solveInPlace(whitening);
  return whitening;
}

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
      largest = std::max(largest, (Whitening(edge) * error).norm() / edge.loss_scale);
    }
  }
  return largest;
}

}  // namespace

void OptimizePoseGraph(const std::vector<PoseGraphEdge>& edges, std::vector<PoseGraphNode>& nodes) {
  std::vector<Parameters> poses;
  for (const PoseGraphNode& node : nodes) {
    poses.push_back(ParametersOf(node.world_from_body));
  }
  double widening = LargestExcess(edges, nodes);
  std::deque<GraduatedLoss> losses;
  ceres::Problem::Options problem_options;
  problem_options.loss_function_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
  ceres::Problem problem(problem_options);
  for (const PoseGraphEdge& edge : edges) {
    ceres::LossFunction* const loss =
        edge.loss_scale > 0.0 ? &losses.emplace_back(edge.loss_scale, widening) : nullptr;
    problem.AddResidualBlock(new EdgeCost(edge.a_from_b, Whitening(edge)), loss,
                             poses[edge.a].data(), poses[edge.b].data());
  }
  for (std::size_t i = 0; i < poses.size(); ++i) {
    if (!problem.HasParameterBlock(poses[i].data())) {
      continue;
    }
    problem.SetManifold(poses[i].data(), new PoseManifold(nodes[i].up_in_world));
    if (nodes[i].is_fixed) {
      problem.SetParameterBlockConstant(poses[i].data());
    }
  }
  Solve(problem, widening);
  for (std::size_t i = 0; i < poses.size(); ++i) {
    if (problem.HasParameterBlock(poses[i].data())) {
      nodes[i].world_from_body = PoseOf(poses[i].data());
    }
  }
}

}  // namespace gluevo::vo
