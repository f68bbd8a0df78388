#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <vector>

#include "window_problem.h"
#include "window_reprojection.h"
#include "window_system.h"

namespace gluevo::vo {

/// Half the sum of squares of all views, under Huber's loss.
double ViewsCost(const WindowProblem& problem, const WindowGeometry& geometry,
                 const std::vector<Eigen::Vector3d>& points);

/// The points' part of the normal equations. Each point is tied to few poses, and points are not
/// tied to each other: they are eliminated block by block (Triggs et al. 2000, section 6.1).
/// Allocates only for problems larger than ever before.
class WindowPoints {
 public:
  /// Adds what views say of frames and the turn, and keeps what ties points to these. Residuals
  /// are those of one state, derivatives those of another or the same.
  void Linearize(const WindowProblem& problem, const WindowGeometry& residuals_at,
                 const WindowGeometry& derivatives_at, const std::vector<Eigen::Vector3d>& points,
                 WindowSystem& system);

  /// Prepares the elimination, the points' diagonals raised (Damping) ...
  void Invert(double damping);
  /// ... or as they are, in those directions in which they say something.
  void Invert();
  /// Takes the points out of the equations: what is left holds for the best points.
  void Eliminate(Eigen::MatrixXd& hessian, Eigen::VectorXd& gradient) const;

  /// The points' steps that go with a step of frames and the turn, as Invert(damping) had it.
  /// Returns what they add to twice the predicted decrease.
  double Solve(double damping, const Eigen::VectorXd& state_step);
  /// Of the last solution.
  const std::vector<Eigen::Vector3d>& steps() const { return steps_; }

 private:
  using Block63 = Eigen::Matrix<double, 6, 3>;
  using Block66 = Eigen::Matrix<double, 6, 6>;

  /// What ties a point to a frame that has columns.
  struct Link {
    int column = 0;
    Block63 hessian;
  };
  struct Point {
    Eigen::Matrix3d hessian;
    Eigen::Vector3d gradient;
    Eigen::Matrix3d with_turn;  ///< Rows: the turn.
    Eigen::Matrix3d inverse;
    std::size_t first_link = 0;
    std::size_t end_link = 0;
  };
  /// What the views of a frame say of where it is from an anchor, all points together.
  struct Relative {
    Block66 hessian;
    Eigen::Matrix<double, 6, 1> gradient;
    Eigen::Matrix<double, 6, 3> with_turn;  ///< Columns: the turn.
    bool is_empty = true;

    void Clear() {
      hessian.setZero();
      gradient.setZero();
      with_turn.setZero();
      is_empty = false;
    }
  };
  std::size_t IndexOf(int anchor, int frame) const {
    return static_cast<std::size_t>(anchor) * frames_ + static_cast<std::size_t>(frame);
  }

  void AddPoint(const WindowProblem& problem, const WindowGeometry& residuals_at,
                const WindowGeometry& derivatives_at, const WindowProblem::Point& point,
                const Eigen::Vector3d& position, WindowSystem& system);
  void AddView(const ReprojectionColumns& columns, double weight, bool sees_turn, Point& point,
               WindowSystem& system) const;
  static void AddToRelative(const ReprojectionColumns& columns, double weight, bool sees_turn,
                            Relative& relative, Block63& with_point);
  /// `anchor`, `frame`: their columns; the anchor may have none.
  static void AddRelative(const Relative& relative, int anchor, int frame, const Block66& by_anchor,
                          const Block66& by_frame, WindowSystem& system);

  int turn_column_ = 0;
  bool has_turn_ = false;
  std::size_t frames_ = 0;
  std::vector<Relative> relatives_;  ///< By IndexOf; where one is not empty, ...
  std::vector<Block66> by_frame_;    ///< ... WindowGeometry::RelativeByFrame.
  std::vector<Point> points_;
  std::vector<Link> links_;
  std::vector<Eigen::Vector3d> steps_;
};

}  // namespace gluevo::vo
