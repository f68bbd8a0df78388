#include "gluevo/vo/mapping/pose_graph.h"

#include <ceres/ceres.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <cmath>
#include <deque>
#include <string>

#include "gluevo/nn/error.h"
#include "gluevo/vo/geometry/pose_uncertainty.h"

namespace gluevo::vo {
namespace {

// What the scale of losses is divided by from step to step.
constexpr double kGraduation = 4.0;
constexpr int kIterations = 50;

// Position, and quaternion as Eigen stores it.
struct Parameters {
  std::array<double, 3> position;
  std::array<double, 4> rotation;
};

// The error of the poses' a_from_b against the measured one, whitened: as ErrorOfPose has it, for
// small turns.
class EdgeResidual {
 public:
  EdgeResidual(const Rigid3& a_from_b, const Eigen::Matrix<double, 6, 6>& whitening)
      : b_from_a_(a_from_b.Inverse()), whitening_(whitening) {}

  template <typename T>
  bool operator()(const T* position_a, const T* rotation_a, const T* position_b,
                  const T* rotation_b, T* residual) const {
    using Vector = Eigen::Matrix<T, 3, 1>;
    using Quaternion = Eigen::Quaternion<T>;
    const Eigen::Map<const Quaternion> world_from_a(rotation_a);
    const Eigen::Map<const Quaternion> world_from_b(rotation_b);
    const Vector between = world_from_a.conjugate() * (Eigen::Map<const Vector>(position_b) -
                                                       Eigen::Map<const Vector>(position_a));
    const Quaternion measured = b_from_a_.rotation.cast<T>();
    const Quaternion turn = measured * (world_from_a.conjugate() * world_from_b);
    Eigen::Matrix<T, 6, 1> error;
    error.template head<3>() = measured * between + b_from_a_.translation.cast<T>();
    error.template tail<3>() = (turn.w() < T(0) ? T(-2) : T(2)) * turn.vec();
    Eigen::Map<Eigen::Matrix<T, 6, 1>>{residual} = whitening_.cast<T>() * error;
    return true;
  }

 private:
  Rigid3 b_from_a_;
  Eigen::Matrix<double, 6, 6> whitening_;
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

std::vector<Parameters> ToParameters(const std::vector<Rigid3>& poses) {
  std::vector<Parameters> parameters(poses.size());
  for (std::size_t i = 0; i < poses.size(); ++i) {
    Eigen::Map<Eigen::Vector3d>(parameters[i].position.data()) = poses[i].translation;
    Eigen::Map<Eigen::Vector4d>(parameters[i].rotation.data()) = poses[i].rotation.coeffs();
  }
  return parameters;
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
                     const std::vector<Rigid3>& world_from_body) {
  double largest = 1.0;
  for (const PoseGraphEdge& edge : edges) {
    if (edge.loss_scale > 0.0) {
      const Eigen::Matrix<double, 6, 1> error =
          ErrorOfPose(edge.a_from_b, world_from_body[edge.a].Inverse() * world_from_body[edge.b]);
      largest = std::max(largest, (Whitening(edge) * error).norm() / edge.loss_scale);
    }
  }
  return largest;
}

}  // namespace

void OptimizePoseGraph(const std::vector<PoseGraphEdge>& edges, const std::vector<bool>& is_fixed,
                       std::vector<Rigid3>& world_from_body) {
  std::vector<Parameters> poses = ToParameters(world_from_body);
  double widening = LargestExcess(edges, world_from_body);
  std::deque<GraduatedLoss> losses;
  ceres::EigenQuaternionManifold unit_quaternions;
  ceres::Problem::Options problem_options;
  problem_options.manifold_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
  problem_options.loss_function_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
  ceres::Problem problem(problem_options);
  for (const PoseGraphEdge& edge : edges) {
    using Cost = ceres::AutoDiffCostFunction<EdgeResidual, 6, 3, 4, 3, 4>;
    ceres::LossFunction* const loss =
        edge.loss_scale > 0.0 ? &losses.emplace_back(edge.loss_scale, widening) : nullptr;
    problem.AddResidualBlock(new Cost(new EdgeResidual(edge.a_from_b, Whitening(edge))), loss,
                             poses[edge.a].position.data(), poses[edge.a].rotation.data(),
                             poses[edge.b].position.data(), poses[edge.b].rotation.data());
  }
  for (std::size_t i = 0; i < poses.size(); ++i) {
    if (!problem.HasParameterBlock(poses[i].position.data())) {
      continue;
    }
    problem.SetManifold(poses[i].rotation.data(), &unit_quaternions);
    if (is_fixed[i]) {
      problem.SetParameterBlockConstant(poses[i].position.data());
      problem.SetParameterBlockConstant(poses[i].rotation.data());
    }
  }
  Solve(problem, widening);
  for (std::size_t i = 0; i < poses.size(); ++i) {
    world_from_body[i] = {
        Eigen::Quaterniond(Eigen::Map<const Eigen::Vector4d>(poses[i].rotation.data()))
            .normalized(),
        Eigen::Map<const Eigen::Vector3d>(poses[i].position.data())};
  }
}

}  // namespace gluevo::vo
