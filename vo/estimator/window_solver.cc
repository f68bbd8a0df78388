#include "window_solver.h"

#include <algorithm>
#include <cmath>

#include "window_inertial.h"

namespace gluevo::vo {
namespace {

/// How far to trust the linearised problem: one over the damping.
class TrustRegion {
 public:
  double damping() const { return 1.0 / radius_; }
  /// `gain`: how much the cost fell, in shares of what was predicted.
  void Accept(double gain) {
    radius_ =
        std::min(kLargest, radius_ / std::max(1.0 / 3.0, 1.0 - std::pow(2.0 * gain - 1.0, 3)));
    shrink_by_ = 2.0;
  }
  /// False where nothing is left to shrink.
  bool Reject() {
    radius_ /= shrink_by_;
    shrink_by_ *= 2.0;
    return radius_ > kSmallest;
  }

 private:
  static constexpr double kLargest = 1e16;
  static constexpr double kSmallest = 1e-32;
  double radius_ = 1e4;
  double shrink_by_ = 2.0;
};

constexpr double kLeastGain = 1e-3;

// What is not finite counts as behind the cameras, at a cost that is.
bool IsFinite(const WindowProblem& problem) {
  return problem.turn.allFinite() && problem.gravity.turn.allFinite() &&
         (!problem.time_offset_s || std::isfinite(*problem.time_offset_s)) &&
         std::all_of(problem.motions.begin(), problem.motions.end(),
                     [](const VelocityAndBias& motion) {
                       return motion.velocity_in_world.allFinite() &&
                              motion.bias.gyroscope.allFinite() &&
                              motion.bias.accelerometer.allFinite();
                     }) &&
         std::all_of(problem.world_from_body.begin(), problem.world_from_body.end(),
                     [](const Rigid3& pose) {
                       return pose.translation.allFinite() && pose.rotation.coeffs().allFinite();
                     }) &&
         std::all_of(problem.points.begin(), problem.points.end(),
                     [](const WindowProblem::Point& point) { return point.position.allFinite(); });
}

}  // namespace

void WindowState::Set(const WindowProblem& problem) {
  world_from_body = problem.world_from_body;
  turn = problem.turn;
  points.resize(problem.points.size());
  std::transform(problem.points.begin(), problem.points.end(), points.begin(),
                 [](const WindowProblem::Point& point) { return point.position; });
  motions = problem.motions;
  gravity_turn = problem.gravity.turn;
  time_offset_s = problem.time_offset_s;
}

void WindowSolver::MoveBy(const WindowState& from, WindowState& to) const {
  const WindowColumns& columns = equations_.columns();
  const Eigen::VectorXd& step = equations_.state_step();
  to.world_from_body.resize(from.world_from_body.size());
  for (std::size_t i = 0; i < from.world_from_body.size(); ++i) {
    const int column = columns.Of(static_cast<int>(i));
    to.world_from_body[i] =
        column < 0 ? from.world_from_body[i]
                   : Plus(from.world_from_body[i], step.segment<kPoseTangentSize>(column));
  }
  to.turn = from.turn;
  if (columns.has_turn) {
    to.turn += step.segment<3>(columns.Turn());
  }
  to.motions.resize(from.motions.size());
  for (std::size_t i = 0; i < from.motions.size(); ++i) {
    to.motions[i] = Plus(from.motions[i],
                         step.segment<WindowColumns::kMotion>(columns.Motion(static_cast<int>(i))));
  }
  to.gravity_turn = from.gravity_turn;
  if (columns.has_inertia) {
    to.gravity_turn += step.segment<WindowColumns::kGravity>(columns.Gravity());
  }
  to.time_offset_s = from.time_offset_s;
  if (columns.has_time_offset) {
    *to.time_offset_s += step[columns.TimeOffset()];
  }
  to.points.resize(from.points.size());
  for (std::size_t i = 0; i < from.points.size(); ++i) {
    to.points[i] = from.points[i] + equations_.point_steps()[i];
  }
}

bool WindowSolver::Solve(WindowProblem& problem, const WindowSolverLimits& limits) {
  if (!IsFinite(problem)) {
    return false;
  }
  state_.Set(problem);
  equations_.Set(problem);
  equations_.Linearize(state_);
  cost_ = equations_.cost();
  if (!std::isfinite(cost_)) {
    return false;
  }
  TrustRegion region;
  bool is_linearized = true;
  for (iterations_ = 0; iterations_ < limits.max_iterations; ++iterations_) {
    if (!is_linearized) {
      equations_.Linearize(state_);
      is_linearized = true;
    }
    double gain = 0.0;
    double candidate_cost = 0.0;
    if (equations_.Solve(region.damping()) && equations_.predicted_decrease() > 0.0) {
      MoveBy(state_, candidate_);
      candidate_cost = equations_.Cost(candidate_);
      gain = (cost_ - candidate_cost) / equations_.predicted_decrease();
    }
    if (!(gain > kLeastGain)) {
      if (!region.Reject()) {
        break;
      }
      continue;
    }
    std::swap(state_, candidate_);
    is_linearized = false;
    region.Accept(gain);
    const bool is_done = cost_ - candidate_cost < limits.least_decrease * cost_;
    cost_ = candidate_cost;
    if (is_done) {
      ++iterations_;
      break;
    }
  }
  problem.world_from_body = state_.world_from_body;
  problem.turn = state_.turn;
  problem.motions = state_.motions;
  problem.gravity.turn = state_.gravity_turn;
  problem.time_offset_s = state_.time_offset_s;
  for (std::size_t i = 0; i < problem.points.size(); ++i) {
    problem.points[i].position = state_.points[i];
  }
  return true;
}

}  // namespace gluevo::vo
