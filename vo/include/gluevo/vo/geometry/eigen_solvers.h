#pragma once

#include <Eigen/Core>

// Eigen's solvers of symmetric eigenvalue problems, compiled once: each use of the templates takes
// a compiler half a minute.
namespace gluevo::vo {

/// values in increasing order; column i of `vectors` is the unit vector of values[i].
struct SymmetricEigen {
  Eigen::VectorXd values;
  Eigen::MatrixXd vectors;
};

/// Of a symmetric matrix, of which only the lower triangle is read.
SymmetricEigen SolveSymmetricEigen(const Eigen::MatrixXd& matrix);

/// The unit vector of the smallest eigenvalue of a symmetric matrix: the least-squares solution x
/// of A x = 0 with |x| = 1, where `matrix` is A^T A.
Eigen::Vector4d SmallestEigenvector(const Eigen::Matrix4d& matrix);

/// One standard deviation of a Gaussian in its worst direction.
double WorstSigma(const Eigen::Matrix3d& covariance);

}  // namespace gluevo::vo
