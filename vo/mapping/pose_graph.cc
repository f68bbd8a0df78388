#include "gluevo/vo/mapping/pose_graph.h"

#include <ceres/ceres.h>

#include <Eigen/Cholesky>
#include <array>
#include <string>

#include "gluevo/nn/error.h"

namespace gluevo::vo {
namespace {

// Standard deviations at which an edge of six degrees of freedom begins to count less.
constexpr double kCauchy = 4.0;

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

}  // namespace

void OptimizePoseGraph(const std::vector<PoseGraphEdge>& edges, const std::vector<bool>& is_fixed,
                       std::vector<Rigid3>& world_from_body) {
  std::vector<Parameters> poses = ToParameters(world_from_body);
  ceres::EigenQuaternionManifold unit_quaternions;
  ceres::CauchyLoss robust(kCauchy);
  ceres::Problem::Options problem_options;
  problem_options.manifold_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
  problem_options.loss_function_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
  ceres::Problem problem(problem_options);
  for (const PoseGraphEdge& edge : edges) {
    using Cost = ceres::AutoDiffCostFunction<EdgeResidual, 6, 3, 4, 3, 4>;
    problem.AddResidualBlock(new Cost(new EdgeResidual(edge.a_from_b, Whitening(edge))),
                             edge.is_robust ? &robust : nullptr, poses[edge.a].position.data(),
                             poses[edge.a].rotation.data(), poses[edge.b].position.data(),
                             poses[edge.b].rotation.data());
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
  ceres::Solver::Options options;
  options.linear_solver_type = ceres::SPARSE_NORMAL_CHOLESKY;
  options.max_num_iterations = 50;
  options.num_threads = 1;
  options.logging_type = ceres::SILENT;
  ceres::Solver::Summary summary;
  ceres::Solve(options, &problem, &summary);
  for (std::size_t i = 0; i < poses.size(); ++i) {
    world_from_body[i] = {
        Eigen::Quaterniond(Eigen::Map<const Eigen::Vector4d>(poses[i].rotation.data()))
            .normalized(),
        Eigen::Map<const Eigen::Vector3d>(poses[i].position.data())};
  }
}

}  // namespace gluevo::vo
