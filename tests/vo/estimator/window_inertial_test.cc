// The inertial part of a window's equations: derivatives, what it finds, and what marginalisation
// leaves of it.

#include "window_inertial.h"
#include "gluevo/vo/core/angle.h"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>
#include <vector>

#include "inertial_scene.h"
#include "window_motions.h"
#include "window_priors.h"
#include "window_solver.h"

namespace gluevo::vo {
namespace {

using testing::InertialScene;
using testing::kSceneBias;

constexpr int kMotion = PosePrior::kMotion;

double AngleBetween(const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
  return std::atan2(a.cross(b).norm(), a.dot(b));
}

WindowState StateOfProblem(const WindowProblem& problem) {
  WindowState state;
  state.Set(problem);
  return state;
}

// A state moved along one column.
WindowState Moved(const WindowState& state, const WindowColumns& columns, int column, double step) {
  const Eigen::VectorXd delta = step * Eigen::VectorXd::Unit(columns.Count(), column);
  WindowState moved = state;
  for (int i = 0; i < columns.frames; ++i) {
    const auto frame = static_cast<std::size_t>(i);
    if (columns.Of(i) >= 0) {
      moved.world_from_body[frame] =
          Plus(state.world_from_body[frame], PoseTangent(delta.segment<6>(columns.Of(i))));
    }
    moved.motions[frame] = Plus(state.motions[frame], delta.segment<kMotion>(columns.Motion(i)));
  }
  if (columns.has_turn) {
    moved.turn += delta.segment<3>(columns.Turn());
  }
  moved.gravity_turn += delta.segment<2>(columns.Gravity());
  if (columns.has_time_offset) {
    *moved.time_offset_s += delta[columns.TimeOffset()];
  }
  return moved;
}

// All residuals, one factor's behind the other's.
Eigen::VectorXd Residuals(const WindowProblem& problem, const WindowState& state) {
  Eigen::VectorXd all(kInertialTangentSize * static_cast<Eigen::Index>(problem.measured.size()));
  const Eigen::Vector3d gravity = TurnedGravity(problem.gravity.first_in_world, state.gravity_turn);
  for (std::size_t i = 0; i < problem.measured.size(); ++i) {
    all.segment<kInertialTangentSize>(kInertialTangentSize * static_cast<Eigen::Index>(i)) =
        Whitened(*problem.measured[i], StateOf(state.world_from_body[i], state.motions[i]),
                 StateOf(state.world_from_body[i + 1], state.motions[i + 1]), gravity,
                 state.time_offset_s)
            .value;
  }
  for (const WindowProblem::Still& still : problem.still) {
    const auto at = [&](int frame) {
      const auto i = static_cast<std::size_t>(frame);
      return StateOf(state.world_from_body[i], state.motions[i]);
    };
    all.conservativeResize(all.size() + kStillRows);
    all.tail<kStillRows>() =
        ComputeStillResidual(still.factor, at(still.first), at(still.first + 1)).value;
  }
  return all;
}

TEST(WindowInertialTest, EquationsAreThoseOfNumericDerivatives) {
  const InertialScene scene({});
  WindowProblem problem = scene.Problem(1);
  problem.gravity.turn = {0.1, -0.15};
  problem.still = {{0, {1e-2, 1e-3, 1e-1, 2.0}}, {2, {1e-3, 1e-2, 1e-2, 1.0}}};
  for (const auto& [has_turn, has_time_offset] :
       {std::pair(false, false), {true, false}, {false, true}, {true, true}}) {
    problem.time_offset_s = has_time_offset ? std::optional(0.002) : std::nullopt;
    const WindowState state = StateOfProblem(problem);
    WindowSystem system;
    system.Reset({.frames = InertialScene::kFrames,
                  .fixed_frames = 1,
                  .has_turn = has_turn,
                  .has_inertia = true,
                  .has_time_offset = has_time_offset});
    AddInertial(problem, state, system);
    const Eigen::VectorXd residuals = Residuals(problem, state);
    EXPECT_NEAR(system.cost, 0.5 * residuals.squaredNorm(), 1e-9 * system.cost);
    EXPECT_NEAR(InertialCost(problem, state), system.cost, 1e-9 * system.cost);
    Eigen::MatrixXd jacobian(residuals.size(), system.columns.Count());
    for (int column = 0; column < jacobian.cols(); ++column) {
      const auto at = [&](double step) {
        return Residuals(problem, Moved(state, system.columns, column, step));
      };
      constexpr double kStep = 1e-4;
      jacobian.col(column) =
          (8.0 * (at(kStep) - at(-kStep)) - (at(2.0 * kStep) - at(-2.0 * kStep))) / (12.0 * kStep);
    }
    const Eigen::MatrixXd hessian = jacobian.transpose() * jacobian;
    const Eigen::VectorXd sizes = hessian.diagonal().cwiseSqrt();
    for (int row = 0; row < hessian.rows(); ++row) {
      for (int column = 0; column <= row; ++column) {
        EXPECT_NEAR(system.hessian(row, column), hessian(row, column),
                    1e-6 * (sizes[row] * sizes[column] + 1e-9))
            << row << ' ' << column;
      }
      EXPECT_NEAR(system.gradient[row], jacobian.col(row).dot(residuals),
                  1e-6 * sizes[row] * residuals.norm() + 1e-9)
          << row;
    }
  }
}

TEST(WindowInertialTest, FindsVelocitiesBiasesAndGravity) {
  const InertialScene scene({{0.01, -0.015, 0.005}, {0.05, 0.0, 0.0}});
  WindowProblem problem = scene.Problem(2);
  ASSERT_GT(AngleBetween(problem.gravity.InWorld(), scene.flight.gravity), 5.0 * kDegree);
  WindowSolver solver;
  ASSERT_TRUE(solver.Solve(problem, {.max_iterations = 30, .least_decrease = 1e-12}));
  EXPECT_LT(AngleBetween(problem.gravity.InWorld(), scene.flight.gravity), 0.02 * kDegree);
  EXPECT_NEAR(problem.gravity.InWorld().norm(), scene.flight.gravity.norm(), 1e-9);
  for (int i = 0; i < InertialScene::kFrames; ++i) {
    const InertialState truth = scene.TruthOf(i);
    const auto frame = static_cast<std::size_t>(i);
    EXPECT_LT(Minus(problem.world_from_body[frame], truth.world_from_body).norm(), 1e-4) << i;
    const VelocityAndBias& motion = problem.motions[frame];
    EXPECT_LT((motion.velocity_in_world - truth.velocity_in_world).norm(), 1e-3) << i;
    EXPECT_LT((motion.bias.gyroscope - kSceneBias.gyroscope).norm(), 1e-4) << i;
    EXPECT_LT((motion.bias.accelerometer - kSceneBias.accelerometer).norm(), 0.01) << i;
  }
}

// Readings that are stamped 4 ms late; twice, since derivatives are of first order.
TEST(WindowInertialTest, FindsTheTimeOffset) {
  const InertialScene scene(kSceneBias);
  constexpr double kLateS = 0.004;
  std::vector<ImuSample> late = scene.readings.samples();
  for (ImuSample& sample : late) {
    sample.timestamp_ns += std::llround(1e9 * kLateS);
  }
  ImuReadings readings{ImuNoise()};
  readings.Add(late);
  double found_s = 0.0;
  for (int i = 0; i < 2; ++i) {
    readings.set_time_offset_s(found_s);
    std::vector<InertialFactor> factors;
    for (int frame = 0; frame + 1 < InertialScene::kFrames; ++frame) {
      factors.push_back(MakeInertialFactor(readings.Between(
          InertialScene::TimeOf(frame), InertialScene::TimeOf(frame + 1), kSceneBias)));
    }
    WindowProblem problem = scene.Problem(2);
    for (std::size_t frame = 0; frame < factors.size(); ++frame) {
      problem.measured[frame] = &factors[frame];
    }
    problem.time_offset_s = found_s;
    WindowSolver solver;
    ASSERT_TRUE(solver.Solve(problem, {.max_iterations = 30, .least_decrease = 1e-12}));
    found_s = *problem.time_offset_s;
  }
  EXPECT_NEAR(found_s, kLateS, 5e-5);
}

// With views of the first frame alone the readings lead on.
TEST(WindowInertialTest, ReadingsAloneBridgeFramesWithoutViews) {
  const InertialScene scene(kSceneBias);
  WindowProblem problem = scene.Problem(3);
  for (int i = 0; i < InertialScene::kFrames; ++i) {
    problem.motions[static_cast<std::size_t>(i)].bias = kSceneBias;
  }
  // Views of the last frames go; all else is known to be right.
  constexpr int kSeen = InertialScene::kFrames - 2;
  for (WindowProblem::Point& point : problem.points) {
    while (point.end_view > point.first_view &&
           problem.views[static_cast<std::size_t>(point.end_view) - 1].frame >= kSeen) {
      --point.end_view;
    }
  }
  std::erase_if(problem.points, [](const WindowProblem::Point& point) {
    return point.end_view - point.first_view <= 2;
  });
  WindowSolver solver;
  ASSERT_TRUE(solver.Solve(problem, {.max_iterations = 30, .least_decrease = 1e-12}));
  const InertialState truth = scene.TruthOf(InertialScene::kFrames - 1);
  EXPECT_LT((problem.world_from_body.back().translation - truth.world_from_body.translation).norm(),
            0.005);
  EXPECT_LT(problem.world_from_body.back().rotation.angularDistance(truth.world_from_body.rotation),
            0.05 * kDegree);
}

PosePrior RandomPrior(std::mt19937_64& generator, std::size_t motions) {
  PosePrior prior;
  prior.frame_ids = {2, 5, 9};
  for (std::size_t i = 0; i < prior.frame_ids.size(); ++i) {
    prior.world_from_body.push_back(
        {ExpSo3(testing::UniformVector(generator, 1.0)), testing::UniformVector(generator, 5.0)});
  }
  for (std::size_t i = 0; i < motions; ++i) {
    prior.motions.push_back(
        {testing::UniformVector(generator, 1.0),
         {testing::UniformVector(generator, 0.1), testing::UniformVector(generator, 0.1)}});
  }
  prior.gravity_turn = Eigen::Vector2d(0.02, -0.01);
  const Eigen::Index columns = prior.Columns();
  prior.jacobian.resize(columns, columns);
  for (double& value : prior.jacobian.reshaped()) {
    value = testing::Uniform(generator, -1.0, 1.0);
  }
  prior.residual = Eigen::VectorXd::LinSpaced(columns, -1.0, 1.0);
  return prior;
}

TEST(WindowInertialTest, ThePriorsEquationsAreThoseOfNumericDerivatives) {
  std::mt19937_64 generator(4);
  const InertialScene scene({});
  WindowProblem problem = scene.Problem(1);
  PosePrior prior = RandomPrior(generator, 1);
  problem.prior = &prior;
  problem.prior_frames = {0, 1, 4};
  for (std::size_t i = 0; i < 3; ++i) {
    PoseTangent step;
    step << testing::UniformVector(generator, 0.3), testing::UniformVector(generator, 0.2);
    prior.world_from_body[i] =
        Plus(problem.world_from_body[static_cast<std::size_t>(problem.prior_frames[i])], step);
  }
  problem.turn_sigma = 1e3;  // Of no weight.
  const WindowState state = StateOfProblem(problem);
  WindowSystem system;
  system.Reset(
      {.frames = InertialScene::kFrames, .fixed_frames = 1, .has_turn = true, .has_inertia = true});
  WindowPriors priors;
  priors.Set(problem);
  priors.AddTo(state, system);
  const auto gradient_at = [&](const WindowState& at) {
    WindowSystem moved;
    moved.Reset(system.columns);
    priors.AddTo(at, moved);
    return moved.gradient;
  };
  constexpr double kStep = 1e-4;
  for (int column = 0; column < system.columns.Count(); ++column) {
    const WindowState plus = Moved(state, system.columns, column, kStep);
    const WindowState minus = Moved(state, system.columns, column, -kStep);
    EXPECT_NEAR(system.gradient[column], (priors.Cost(plus) - priors.Cost(minus)) / (2.0 * kStep),
                1e-5)
        << column;
    // Of what is no rotation derivatives are the same everywhere.
    const int motion = system.columns.Motion(0);
    if (column >= motion) {
      const Eigen::VectorXd numeric = (gradient_at(plus) - gradient_at(minus)) / (2.0 * kStep);
      EXPECT_LT((system.hessian.col(column).tail(system.columns.Count() - column) -
                 numeric.tail(system.columns.Count() - column))
                    .norm(),
                1e-6)
          << column;
      EXPECT_LT((system.hessian.row(column).head(motion).transpose() - numeric.head(motion)).norm(),
                1e-6)
          << column;
    }
  }
}

// Eliminated one after the other, or all at once.
TEST(WindowInertialTest, MotionsAreEliminatedAsADenseSolverDoes) {
  std::mt19937_64 generator(7);
  const InertialScene scene({});
  WindowProblem problem = scene.Problem(1);
  PosePrior prior = RandomPrior(generator, 1);
  problem.prior = &prior;
  problem.prior_frames = {0, 3, 5};
  const WindowState state = StateOfProblem(problem);
  for (const bool has_turn : {false, true}) {
    problem.turn_sigma = has_turn ? 1.0 : 0.0;
    WindowSystem system;
    system.Reset({.frames = InertialScene::kFrames,
                  .fixed_frames = 1,
                  .has_turn = has_turn,
                  .has_inertia = true});
    AddInertial(problem, state, system);
    WindowPriors priors;
    priors.Set(problem);
    priors.AddTo(state, system);
    system.hessian.diagonal().array() += 100.0;
    const Eigen::MatrixXd whole = system.hessian.selfadjointView<Eigen::Lower>();
    const Eigen::VectorXd expected = whole.ldlt().solve(system.gradient);
    WindowMotions motions;
    Eigen::VectorXd solution = system.gradient;
    ASSERT_TRUE(motions.Eliminate(system.columns, system.hessian, solution));
    ASSERT_TRUE(motions.Solve(system.columns, system.hessian, solution));
    EXPECT_LT((solution - expected).norm(), 1e-6 * expected.norm());
    EXPECT_LT((whole * solution - system.gradient).norm(), 1e-7 * system.gradient.norm());
  }
}

// As for poses alone: what is left has the solution and the covariance of the whole.
TEST(WindowInertialTest, EliminationLeavesTheSolutionOfTheRest) {
  std::mt19937_64 generator(5);
  const PosePrior before = RandomPrior(generator, 2);
  Marginalizer marginalizer(before);
  marginalizer.AddPrior(before);
  const PosePrior after = marginalizer.Eliminate(2);
  EXPECT_EQ(after.frame_ids, (std::vector<int64_t>{5, 9}));
  ASSERT_EQ(after.motions.size(), 1U);
  EXPECT_EQ(after.motions[0].velocity_in_world, before.motions[1].velocity_in_world);
  EXPECT_EQ(after.gravity_turn, before.gravity_turn);

  const Eigen::MatrixXd hessian = before.jacobian.transpose() * before.jacobian;
  const Eigen::VectorXd solution =
      hessian.ldlt().solve(-before.jacobian.transpose() * before.residual);
  const Eigen::MatrixXd covariance = hessian.inverse();
  const Eigen::MatrixXd hessian_after = after.jacobian.transpose() * after.jacobian;
  const Eigen::VectorXd of_prior =
      hessian_after.ldlt().solve(-after.jacobian.transpose() * after.residual);
  std::vector<Eigen::Index> kept;
  for (Eigen::Index i = 6; i < before.Columns(); ++i) {
    if (i < before.MotionColumn(0) || i >= before.MotionColumn(1)) {
      kept.push_back(i);
    }
  }
  ASSERT_EQ(static_cast<Eigen::Index>(kept.size()), after.Columns());
  EXPECT_LT((of_prior - solution(kept)).norm(), 1e-7 * solution.norm());
  const Eigen::MatrixXd expected = covariance(kept, kept);
  EXPECT_LT((hessian_after.inverse() - expected).norm(), 1e-6 * expected.norm());

  // Nothing is lost where nothing is eliminated.
  const PosePrior all = marginalizer.Keep();
  EXPECT_LT((all.jacobian.transpose() * all.jacobian - hessian).norm(), 1e-9 * hessian.norm());
  EXPECT_LT(
      (all.jacobian.transpose() * all.residual - before.jacobian.transpose() * before.residual)
          .norm(),
      1e-9 * hessian.norm());
}

// J^T J of what views say of two frames: where the second is in the first, to a millimetre and a
// milliradian.
Eigen::MatrixXd SeenMotion(const PosePrior& frames) {
  constexpr double kWeight = 1e3;
  const Rigid3& first = frames.world_from_body[0];
  const Rigid3& second = frames.world_from_body[1];
  const Eigen::Matrix3d first_from_world = first.rotation.conjugate().toRotationMatrix();
  const Rigid3 first_from_second = first.Inverse() * second;
  Eigen::Matrix<double, 6, 12> jacobian = Eigen::Matrix<double, 6, 12>::Zero();
  jacobian.topLeftCorner<3, 3>() = -first_from_world;
  jacobian.block<3, 3>(0, 3) = Skew(first_from_second.translation);
  jacobian.block<3, 3>(0, 6) = first_from_world;
  jacobian.block<3, 3>(3, 3) = -first_from_second.rotation.conjugate().toRotationMatrix();
  jacobian.bottomRightCorner<3, 3>().setIdentity();
  jacobian *= kWeight;
  return jacobian.transpose() * jacobian;
}

// Frame by frame, with estimates that move between a frame's first time in the prior and its last:
// of where the world is and how it is turned nothing becomes known.
TEST(WindowInertialTest, FirstEstimatesLeavePlaceAndTurnOfTheWorldFree) {
  std::mt19937_64 generator(6);
  const InertialScene scene(kSceneBias);
  GravityEstimate gravity{scene.flight.gravity, {0.01, 0.02}};
  const auto estimate = [&](int frame) {
    InertialVector error;
    error << testing::UniformVector(generator, 0.05), testing::UniformVector(generator, 0.03),
        testing::UniformVector(generator, 0.1), testing::UniformVector(generator, 0.002),
        testing::UniformVector(generator, 0.02);
    return Plus(scene.TruthOf(frame), error);
  };
  const auto motion_of = [](const InertialState& state) {
    return VelocityAndBias{state.velocity_in_world, state.bias};
  };
  const InertialState first = estimate(0);
  PosePrior prior;
  prior.frame_ids = {0};
  prior.world_from_body = {first.world_from_body};
  prior.motions = {motion_of(first)};
  prior.gravity_turn = gravity.turn;
  prior.jacobian.resize(0, prior.Columns());
  prior.residual.resize(0);
  for (int i = 0; i + 1 < InertialScene::kFrames; ++i) {
    const std::array<InertialState, 2> present = {estimate(i), estimate(i + 1)};
    PosePrior linearization = prior;
    linearization.frame_ids.push_back(i + 1);
    linearization.world_from_body.push_back(present[1].world_from_body);
    linearization.motions.push_back(motion_of(present[1]));
    Marginalizer marginalizer(linearization);
    marginalizer.AddPrior(prior);
    gravity.turn += Eigen::Vector2d(0.003, -0.002);
    const Eigen::VectorXd delta = linearization.Delta(
        {present[0].world_from_body, present[1].world_from_body}, linearization.turn,
        {motion_of(present[0]), motion_of(present[1])}, gravity.turn);
    AddMeasured(scene.factors[static_cast<std::size_t>(i)], present, gravity, std::nullopt, delta,
                marginalizer);
    marginalizer.Add(SeenMotion(linearization), Eigen::VectorXd::Zero(12), delta);
    prior = marginalizer.Eliminate(i);
  }
  const Eigen::Vector3d in_world = TurnedGravity(gravity.first_in_world, *prior.gravity_turn);
  const GravityTangentMatrix by_turn =
      GravityEstimate{gravity.first_in_world, *prior.gravity_turn}.ByTurn();
  Eigen::MatrixXd free = Eigen::MatrixXd::Zero(prior.Columns(), 6);
  free.topLeftCorner<3, 3>().setIdentity();
  for (int axis = 0; axis < 3; ++axis) {
    const Eigen::Vector3d unit = Eigen::Vector3d::Unit(axis);
    free.col(3 + axis).head<3>() = unit.cross(prior.world_from_body[0].translation);
    free.col(3 + axis).segment<3>(3) = prior.world_from_body[0].rotation.conjugate() * unit;
    free.col(3 + axis).segment<3>(prior.MotionColumn(0)) =
        unit.cross(prior.motions[0].velocity_in_world);
    free.col(3 + axis).tail<2>() =
        (by_turn.transpose() * by_turn).ldlt().solve(by_turn.transpose() * unit.cross(in_world));
  }
  // Velocity, biases and gravity against the pose: 17 less what is free.
  EXPECT_EQ(prior.jacobian.rows(), 11);
  const Eigen::MatrixXd hessian = prior.jacobian.transpose() * prior.jacobian;
  EXPECT_LT((free.transpose() * hessian * free).diagonal().maxCoeff(),
            1e-6 * hessian.diagonal().maxCoeff());
  // The same directions taken elsewhere are not free: the test can fail.
  free.col(3).segment<3>(prior.MotionColumn(0)) += Eigen::Vector3d(0.1, 0.1, 0.1);
  EXPECT_GT(free.col(3).dot(hessian * free.col(3)), 1.0);
}

}  // namespace
}  // namespace gluevo::vo
