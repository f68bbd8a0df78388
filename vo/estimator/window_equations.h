#pragma once

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <vector>

#include "window_problem.h"
#include "window_reprojection.h"

namespace gluevo::vo {

/// The cost at a state of the problem: half the sum of squares, those of views under Huber's loss.
double WindowCost(const WindowProblem& problem, const WindowGeometry& geometry,
                  const std::vector<Rigid3>& world_from_body, const Eigen::Vector3d& turn,
                  const std::vector<Eigen::Vector3d>& points);

/// The problem's normal equations at one state. Each point is tied to few poses, and points are not
/// tied to each other: they are eliminated block by block (Triggs et al. 2000, section 6.1).
/// Allocates only for problems larger than ever before.
class WindowEquations {
 public:
  /// Columns of the state: a PoseTangent for each frame but the first, then the turn, if it is
  /// estimated.
  void Linearize(const WindowProblem& problem, const WindowGeometry& geometry,
                 const std::vector<Rigid3>& world_from_body, const Eigen::Vector3d& turn,
                 const std::vector<Eigen::Vector3d>& points);
  /// Of what was linearised last.
  double cost() const { return cost_; }

  /// The step of Levenberg and Marquardt, the diagonal raised by `damping` times itself. False
  /// where the equations have no finite solution.
  bool Solve(double damping);
  /// Of the last solution.
  const Eigen::VectorXd& state_step() const { return step_; }
  const std::vector<Eigen::Vector3d>& point_steps() const { return point_steps_; }
  /// By how much the linearised problem says that the cost falls with the step.
  double predicted_decrease() const { return predicted_decrease_; }

 private:
  /// What ties a point to a frame.
  struct Link {
    int column = 0;  ///< Of the frame; negative for the first one, which is fixed.
    Eigen::Matrix<double, 6, 3> hessian;
  };
  struct PointBlock {
    Eigen::Matrix3d hessian;
    Eigen::Vector3d gradient;
    Eigen::Matrix3d with_turn;  ///< Rows: the turn.
    Eigen::Matrix3d inverse;    ///< Of the damped hessian.
    std::size_t first_link = 0;
    std::size_t end_link = 0;
  };

  void AddPoint(const WindowProblem& problem, const WindowGeometry& geometry,
                const WindowProblem::Point& point, const Eigen::Vector3d& position);
  void AddView(const ReprojectionRows& rows, double robust, bool sees_turn, PointBlock& block,
               Link& anchor, Link* frame);
  void AddPrior(const WindowProblem& problem, const std::vector<Rigid3>& world_from_body,
                const Eigen::Vector3d& turn);
  void AddTurnPrior(const WindowProblem& problem, const Eigen::Vector3d& turn);
  void EliminatePoint(double damping, PointBlock& block);

  bool has_turn_ = false;
  int turn_column_ = 0;
  double cost_ = 0.0;
  Eigen::MatrixXd hessian_;  ///< Lower triangle, blocks on the diagonal whole.
  Eigen::VectorXd gradient_;
  std::vector<PointBlock> blocks_;
  std::vector<Link> links_;

  Eigen::MatrixXd reduced_;
  Eigen::VectorXd step_;
  std::vector<Eigen::Vector3d> point_steps_;
  double predicted_decrease_ = 0.0;

  Eigen::VectorXd prior_delta_, prior_residual_, prior_gradient_;
  Eigen::MatrixXd prior_jacobian_, prior_hessian_;
};

}  // namespace gluevo::vo
