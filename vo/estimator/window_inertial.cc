#include "window_inertial.h"

#include <cstddef>

namespace gluevo::vo {
namespace {

constexpr int kPose = kPoseTangentSize;
constexpr int kMotion = WindowColumns::kMotion;
constexpr std::array<int, 5> kSizes = {kPose, kMotion, kPose, kMotion, WindowColumns::kGravity};

GravityEstimate GravityAt(const WindowProblem& problem, const WindowState& state) {
  return {problem.gravity.first_in_world, state.gravity_turn};
}

StillResidual ResidualOf(const WindowProblem::Still& still, const WindowState& state) {
  const auto at = [&](int frame) {
    const auto i = static_cast<std::size_t>(frame);
    return StateOf(state.world_from_body[i], state.motions[i]);
  };
  return ComputeStillResidual(still.factor, at(still.first), at(still.first + 1));
}

InertialPlaces PlacesFrom(int first, const WindowColumns& columns) {
  return {columns.Of(first), columns.Motion(first), columns.Of(first + 1),
          columns.Motion(first + 1), columns.Gravity()};
}

InertialPlaces PlacesOfFirstTwo(const PosePrior& linearization) {
  return {0, static_cast<int>(linearization.MotionColumn(0)), kPose,
          static_cast<int>(linearization.MotionColumn(1)),
          static_cast<int>(linearization.GravityColumn())};
}

InertialState LinearizationAt(const PosePrior& linearization, std::size_t frame) {
  return StateOf(linearization.world_from_body[frame], linearization.motions[frame]);
}

}  // namespace

VelocityAndBias Plus(const VelocityAndBias& motion,
                     const Eigen::Matrix<double, kMotion, 1>& delta) {
  return {
      motion.velocity_in_world + delta.head<3>(),
      {motion.bias.gyroscope + delta.segment<3>(3), motion.bias.accelerometer + delta.tail<3>()}};
}

WhitenedInertialResidual WhitenedByTurn(const InertialFactor& factor, const InertialState& first,
                                        const InertialState& second, const GravityEstimate& gravity,
                                        const std::optional<double>& time_offset_s) {
  const Eigen::Vector3d in_world = gravity.InWorld();
  WhitenedInertialResidual residual = Whitened(factor, first, second, in_world, time_offset_s);
  // Both tangents are of the same plane.
  const Eigen::Matrix2d step_by_turn =
      GravityTangent(in_world).transpose() * gravity.ByTurn() / in_world.squaredNorm();
  residual.by_gravity = (residual.by_gravity * step_by_turn).eval();
  return residual;
}

double InertialCost(const WindowProblem& problem, const WindowState& state) {
  if (!problem.has_inertia()) {
    return 0.0;
  }
  const Eigen::Vector3d gravity = GravityAt(problem, state).InWorld();
  double cost = 0.0;
  for (std::size_t i = 0; i < problem.measured.size(); ++i) {
    const InertialFactor& factor = *problem.measured[i];
    const InertialVector residual =
        ComputeInertialResidual(StateOf(state.world_from_body[i], state.motions[i]),
                                StateOf(state.world_from_body[i + 1], state.motions[i + 1]),
                                factor.measured, gravity,
                                ShiftTo(state.time_offset_s, factor.measured))
            .value;
    cost += 0.5 * (factor.whitening.triangularView<Eigen::Lower>() * residual).squaredNorm();
  }
  for (const WindowProblem::Still& still : problem.still) {
    cost += ResidualOf(still, state).Cost();
  }
  return cost;
}

void AddInertial(const WindowProblem& problem, const WindowState& state, WindowSystem& system) {
  if (!problem.has_inertia()) {
    return;
  }
  const GravityEstimate gravity = GravityAt(problem, state);
  const WindowColumns& columns = system.columns;
  for (std::size_t i = 0; i < problem.measured.size(); ++i) {
    const WhitenedInertialResidual residual = WhitenedByTurn(
        *problem.measured[i], StateOf(state.world_from_body[i], state.motions[i]),
        StateOf(state.world_from_body[i + 1], state.motions[i + 1]), gravity, state.time_offset_s);
    system.cost += residual.Cost();
    AddAt(residual, PlacesFrom(static_cast<int>(i), columns),
          columns.has_time_offset ? columns.TimeOffset() : -1, system.hessian, system.gradient);
  }
  for (const WindowProblem::Still& still : problem.still) {
    const StillResidual residual = ResidualOf(still, state);
    system.cost += residual.Cost();
    AddAt(NormalEquationsOf(residual), PlacesFrom(still.first, columns), system.hessian,
          system.gradient);
  }
}

void AddAt(const WhitenedInertialResidual& residual, const InertialPlaces& places, int time_offset,
           Eigen::MatrixXd& hessian, Eigen::VectorXd& gradient) {
  AddAt(NormalEquationsOf(residual), places, hessian, gradient);
  if (time_offset < 0) {
    return;
  }
  const InertialVector& by_offset = residual.by_time_offset;
  hessian(time_offset, time_offset) += by_offset.squaredNorm();
  gradient[time_offset] += by_offset.dot(residual.value);
  Eigen::Matrix<double, kInertialColumns, 1> with_others;
  with_others << residual.by_first.transpose() * by_offset,
      residual.by_second.transpose() * by_offset, residual.by_gravity.transpose() * by_offset;
  int row = 0;
  for (std::size_t i = 0; i < places.size(); ++i) {
    if (places[i] >= 0) {
      const auto part = with_others.segment(row, kSizes[i]);
      hessian.block(places[i], time_offset, kSizes[i], 1) += part;
      hessian.block(time_offset, places[i], 1, kSizes[i]) += part.transpose();
    }
    row += kSizes[i];
  }
}

void AddAt(const InertialNormalEquations& equations, const InertialPlaces& places,
           Eigen::MatrixXd& hessian, Eigen::VectorXd& gradient) {
  int row = 0;
  for (std::size_t a = 0; a < places.size(); ++a) {
    int column = 0;
    for (std::size_t b = 0; b < places.size(); ++b) {
      if (places[a] >= 0 && places[b] >= 0) {
        hessian.block(places[a], places[b], kSizes[a], kSizes[b]) +=
            equations.hessian.block(row, column, kSizes[a], kSizes[b]);
      }
      column += kSizes[b];
    }
    if (places[a] >= 0) {
      gradient.segment(places[a], kSizes[a]) += equations.gradient.segment(row, kSizes[a]);
    }
    row += kSizes[a];
  }
}

void AddMeasured(const InertialFactor& factor, const std::array<InertialState, 2>& present,
                 const GravityEstimate& present_gravity,
                 const std::optional<double>& present_time_offset_s, const Eigen::VectorXd& delta,
                 Marginalizer& marginalizer) {
  const PosePrior& linearization = marginalizer.linearization();
  WhitenedInertialResidual residual = WhitenedByTurn(
      factor, LinearizationAt(linearization, 0), LinearizationAt(linearization, 1),
      {present_gravity.first_in_world, *linearization.gravity_turn}, present_time_offset_s);
  residual.value =
      Whitened(factor, present[0], present[1], present_gravity.InWorld(), present_time_offset_s)
          .value;
  const Eigen::Index columns = linearization.Columns();
  Eigen::MatrixXd hessian = Eigen::MatrixXd::Zero(columns, columns);
  Eigen::VectorXd gradient = Eigen::VectorXd::Zero(columns);
  AddAt(residual, PlacesOfFirstTwo(linearization),
        linearization.time_offset_s ? static_cast<int>(linearization.TimeOffsetColumn()) : -1,
        hessian, gradient);
  marginalizer.Add(hessian, gradient, delta);
}

void AddStill(const StillFactor& factor, const std::array<InertialState, 2>& present,
              const Eigen::VectorXd& delta, Marginalizer& marginalizer) {
  const PosePrior& linearization = marginalizer.linearization();
  StillResidual residual = ComputeStillResidual(factor, LinearizationAt(linearization, 0),
                                                LinearizationAt(linearization, 1));
  residual.value = ComputeStillResidual(factor, present[0], present[1]).value;
  const Eigen::Index columns = linearization.Columns();
  Eigen::MatrixXd hessian = Eigen::MatrixXd::Zero(columns, columns);
  Eigen::VectorXd gradient = Eigen::VectorXd::Zero(columns);
  AddAt(NormalEquationsOf(residual), PlacesOfFirstTwo(linearization), hessian, gradient);
  marginalizer.Add(hessian, gradient, delta);
}

}  // namespace gluevo::vo
