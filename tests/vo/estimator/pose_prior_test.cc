#include "pose_prior_factor.h"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <vector>

#include "pose_manifold.h"
#include "vo/scene.h"

namespace gluevo::vo {
namespace {

constexpr int kPose = PosePrior::kPose;
constexpr int kTurn = PosePrior::kTurn;

Eigen::MatrixXd RandomMatrix(std::mt19937_64& generator, Eigen::Index rows, Eigen::Index cols) {
  Eigen::MatrixXd matrix(rows, cols);
  for (double& value : matrix.reshaped()) {
    value = testing::Uniform(generator, -1.0, 1.0);
  }
  return matrix;
}

std::vector<Rigid3> RandomPoses(std::mt19937_64& generator, int count) {
  std::vector<Rigid3> poses;
  for (int i = 0; i < count; ++i) {
    const Eigen::Vector3d rotation = testing::UniformVector(generator, 1.0);
    poses.push_back({ExpSo3(rotation), testing::UniformVector(generator, 5.0)});
  }
  return poses;
}

PosePrior RandomPrior(std::mt19937_64& generator, const std::vector<int64_t>& frame_ids) {
  const auto poses = RandomPoses(generator, static_cast<int>(frame_ids.size()));
  const auto columns = static_cast<Eigen::Index>(kPose * frame_ids.size() + kTurn);
  return {frame_ids, poses, testing::UniformVector(generator, 1.0),
          RandomMatrix(generator, columns, columns), RandomMatrix(generator, columns, 1)};
}

TEST(PosePriorFactor, JacobiansMatchCentralDifferences) {
  std::mt19937_64 generator(1);
  const PosePrior prior = RandomPrior(generator, {3, 8});
  // Well away from the linearisation point, where the rotation's derivative is not the identity.
  std::vector<std::vector<double>> x;
  for (const Rigid3& pose : prior.world_from_body) {
    PoseTangent step;
    step << testing::UniformVector(generator, 1.0), testing::UniformVector(generator, 0.5);
    const PoseParameters moved = ToParameters(Plus(pose, step));
    x.emplace_back(moved.begin(), moved.end());
  }
  x.push_back({0.1, -0.2, 0.3});
  const PosePriorFactor factor(prior);

  const auto residuals = [&] {
    Eigen::VectorXd r(factor.num_residuals());
    const double* const pointers[] = {x[0].data(), x[1].data(), x[2].data()};
    EXPECT_TRUE(factor.Evaluate(pointers, r.data(), nullptr));
    return r;
  };
  std::vector<Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>> analytic;
  for (const auto& block : x) {
    analytic.emplace_back(factor.num_residuals(), block.size());
  }
  double* jacobians[] = {analytic[0].data(), analytic[1].data(), analytic[2].data()};
  const double* const pointers[] = {x[0].data(), x[1].data(), x[2].data()};
  Eigen::VectorXd r(factor.num_residuals());
  ASSERT_TRUE(factor.Evaluate(pointers, r.data(), jacobians));
  EXPECT_EQ(r, residuals());
  const PoseManifold manifold;
  for (std::size_t block = 0; block < x.size(); ++block) {
    const bool is_pose = block < 2;
    const std::vector<double> at = x[block];
    Eigen::MatrixXd by_step = analytic[block];
    if (is_pose) {
      Eigen::Matrix<double, 7, 6, Eigen::RowMajor> plus;
      manifold.PlusJacobian(at.data(), plus.data());
      by_step = analytic[block] * plus;
    }
    for (Eigen::Index k = 0; k < by_step.cols(); ++k) {
      const auto sample = [&](double offset) {
        if (is_pose) {
          PoseTangent step = PoseTangent::Zero();
          step[k] = offset;
          manifold.Plus(at.data(), step.data(), x[block].data());
        } else {
          x[block][k] += offset;
        }
        const Eigen::VectorXd value = residuals();
        x[block] = at;
        return value;
      };
      constexpr double kStep = 1e-3;
      const Eigen::VectorXd numeric =
          (8.0 * (sample(kStep) - sample(-kStep)) - (sample(2.0 * kStep) - sample(-2.0 * kStep))) /
          (12.0 * kStep);
      EXPECT_LT((by_step.col(k) - numeric).cwiseAbs().maxCoeff(),
                1e-6 * by_step.cwiseAbs().maxCoeff())
          << "block " << block << " column " << k;
    }
  }
}

TEST(PosePrior, ItsResidualAtTheLinearizationPointIsItsConstant) {
  std::mt19937_64 generator(2);
  const PosePrior prior = RandomPrior(generator, {0, 1});
  const PosePriorFactor factor(prior);
  const PoseParameters pose0 = ToParameters(prior.world_from_body[0]);
  const PoseParameters pose1 = ToParameters(prior.world_from_body[1]);
  const double* const parameters[] = {pose0.data(), pose1.data(), prior.turn.data()};
  Eigen::VectorXd residual(factor.num_residuals());
  ASSERT_TRUE(factor.Evaluate(parameters, residual.data(), nullptr));
  EXPECT_LT((residual - prior.residual).norm(), 1e-14);
}

// The least-squares solution of the whole problem, for the columns that remain, is that of the
// prior alone; and so is the gradient at the linearisation point, once the eliminated variables
// have their best values.
TEST(Marginalizer, EliminationLeavesTheSolutionOfTheRest) {
  std::mt19937_64 generator(3);
  const std::vector<int64_t> frame_ids = {2, 5, 9};
  const PosePrior before = RandomPrior(generator, frame_ids);
  // A landmark seen 20 times, with residuals taken away from the linearisation point.
  const Eigen::Index columns = before.jacobian.cols();
  const Eigen::MatrixXd by_state = RandomMatrix(generator, 40, columns);
  const Eigen::Matrix<double, Eigen::Dynamic, 3> by_landmark = RandomMatrix(generator, 40, 3);
  const Eigen::VectorXd delta = RandomMatrix(generator, columns, 1);
  const Eigen::VectorXd residual = RandomMatrix(generator, 40, 1);

  Marginalizer marginalizer(before);
  marginalizer.AddPrior(before);
  // What is orthogonal to the landmark's own derivatives.
  const Eigen::MatrixXd rest =
      Eigen::MatrixXd::Identity(40, 40) -
      by_landmark * (by_landmark.transpose() * by_landmark).inverse() * by_landmark.transpose();
  const Eigen::MatrixXd hessian_of_rest = by_state.transpose() * rest * by_state;
  marginalizer.Add(hessian_of_rest.triangularView<Eigen::Lower>(),
                   by_state.transpose() * rest * residual, delta);
  const PosePrior after = marginalizer.Eliminate(5);
  EXPECT_EQ(after.frame_ids, (std::vector<int64_t>{2, 9}));
  EXPECT_EQ(after.world_from_body[1].translation, before.world_from_body[2].translation);

  Eigen::MatrixXd whole(before.jacobian.rows() + 40, columns + 3);
  whole << before.jacobian, Eigen::MatrixXd::Zero(before.jacobian.rows(), 3), by_state, by_landmark;
  Eigen::VectorXd constant(whole.rows());
  constant << before.residual, residual - by_state * delta;
  const Eigen::MatrixXd hessian = whole.transpose() * whole;
  const Eigen::VectorXd solution = hessian.ldlt().solve(-whole.transpose() * constant);
  const Eigen::VectorXd of_prior = (after.jacobian.transpose() * after.jacobian)
                                       .ldlt()
                                       .solve(-after.jacobian.transpose() * after.residual);
  Eigen::VectorXd expected(columns - kPose);
  expected << solution.head(kPose), solution.segment(2 * kPose, kPose + kTurn);
  // Both go by normal equations of a condition below 1e6.
  EXPECT_LT((of_prior - expected).norm(), 1e-8 * expected.norm());
  // And it is as certain: the covariance of what remains is a block of the whole one.
  const Eigen::MatrixXd covariance = hessian.inverse();
  const Eigen::MatrixXd of_first = covariance.topLeftCorner(kPose, kPose);
  EXPECT_LT(((after.jacobian.transpose() * after.jacobian).inverse().topLeftCorner(kPose, kPose) -
             of_first)
                .norm(),
            1e-8 * of_first.norm());
}

TEST(Marginalizer, WhatIsKnownInPartStaysSo) {
  // Six directions of 15 are measured, and a pose goes: it takes them all. Twelve: six remain.
  std::mt19937_64 generator(4);
  const PosePrior frames = RandomPrior(generator, {0, 1});
  Marginalizer marginalizer(frames);
  const auto add = [&] {
    const Eigen::MatrixXd by_state = RandomMatrix(generator, 6, 15);
    marginalizer.Add(by_state.transpose() * by_state,
                     by_state.transpose() * RandomMatrix(generator, 6, 1),
                     Eigen::VectorXd::Zero(15));
  };
  add();
  EXPECT_EQ(marginalizer.Eliminate(0).jacobian.rows(), 0);
  add();
  EXPECT_EQ(marginalizer.Eliminate(0).jacobian.rows(), 6);
}

}  // namespace
}  // namespace gluevo::vo
