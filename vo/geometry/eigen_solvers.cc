#include "gluevo/vo/geometry/eigen_solvers.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

namespace gluevo::vo {

SymmetricEigen SolveSymmetricEigen(const Eigen::MatrixXd& matrix) {
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(matrix);
  return {solver.eigenvalues(), solver.eigenvectors()};
}

Eigen::Vector4d SmallestEigenvector(const Eigen::Matrix4d& matrix) {
  return Eigen::SelfAdjointEigenSolver<Eigen::Matrix4d>(matrix).eigenvectors().col(0);
}

double WorstSigma(const Eigen::Matrix3d& covariance) {
  return std::sqrt(std::max(
      0.0, Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(covariance, Eigen::EigenvaluesOnly)
               .eigenvalues()[2]));
}

}  // namespace gluevo::vo
