#include "two_view_refinement.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <cmath>

#include "gluevo/vo/core/reference_focal.h"
#include "gluevo/vo/geometry/manifold.h"

namespace gluevo::vo::internal {
namespace {

using Matrix6 = Eigen::Matrix<double, 6, 6>;
using Matrix63 = Eigen::Matrix<double, 6, 3>;
using Vector6 = Eigen::Matrix<double, 6, 1>;

constexpr int kMostSteps = 15;
constexpr double kHuber = 2.0;  // Standard deviations.
// No observation is better than this, in shares of the noise: a tenth in variance.
constexpr double kLeastVariance = 0.1;
constexpr double kConverged = 1e-9;

// Sums of the normal equations: the motion's, with the points eliminated; what each point needs to
// follow is kept.
struct TwoViewEquations {
  Matrix6 hessian = Matrix6::Zero();
  Vector6 gradient = Vector6::Zero();
  double cost = 0.0;       // Of the loss.
  double squares = 0.0;    // Of residuals, weighted.
  double freedoms = -6.0;  // Of them.
  struct Elimination {
    Eigen::Matrix3d inverse = Eigen::Matrix3d::Zero();
    Matrix63 cross = Matrix63::Zero();
    Eigen::Vector3d gradient = Eigen::Vector3d::Zero();
  };
  std::vector<Elimination> points;
};

struct TwoViewState {
  Rigid3 a_from_b;
  std::vector<Eigen::Vector3d> points;
};

class TwoViewProblem {
 public:
  TwoViewProblem(const StereoRig& rig, const std::vector<TwoViewPoint>& points, double noise)
      : rig_(rig), points_(points), noise_(noise) {}

  // Nothing where a point came to lie behind a camera.
  std::optional<TwoViewEquations> Linearize(const TwoViewState& state) const {
    TwoViewEquations equations;
    equations.points.resize(points_.size());
    for (std::size_t i = 0; i < points_.size(); ++i) {
      if (!AddPoint(state, i, equations)) {
        return std::nullopt;
      }
    }
    return equations;
  }

 private:
  struct View {
    bool is_of_b;
    std::size_t camera;
    Eigen::Vector2d seen;
  };

  static std::vector<View> ViewsOf(const TwoViewPoint& point) {
    std::vector<View> views = {{false, 0, point.in_a.left}, {true, 0, point.in_b.left}};
    if (point.in_a.has_right) {
      views.push_back({false, 1, point.in_a.right});
    }
    if (point.in_b.has_right) {
      views.push_back({true, 1, point.in_b.right});
    }
    return views;
  }

  bool AddPoint(const TwoViewState& state, std::size_t i, TwoViewEquations& equations) const {
    Eigen::Matrix3d of_point = Eigen::Matrix3d::Zero();
    TwoViewEquations::Elimination& elimination = equations.points[i];
    for (const View& view : ViewsOf(points_[i])) {
      const auto projection =
          ProjectInto(rig_.body_from_cam[view.camera], view.is_of_b ? state.a_from_b : Rigid3(),
                      rig_.body_from_cam[0], state.points[i]);
      if (!projection) {
        return false;
      }
      const Eigen::Vector2d error = (projection->place - view.seen) / noise_;
      const double size = error.norm();
      const double weight = size <= kHuber ? 1.0 : kHuber / size;
      const Eigen::Matrix<double, 2, 3> by_point = projection->by_point / noise_;
      equations.cost += size <= kHuber ? size * size : kHuber * (2.0 * size - kHuber);
      equations.squares += weight * size * size;
      equations.freedoms += 2.0;
      of_point += weight * by_point.transpose() * by_point;
      elimination.gradient += weight * by_point.transpose() * error;
      if (view.is_of_b) {
        const Eigen::Matrix<double, 2, 6> by_motion = projection->by_motion / noise_;
        equations.hessian += weight * by_motion.transpose() * by_motion;
        equations.gradient += weight * by_motion.transpose() * error;
        elimination.cross += weight * by_motion.transpose() * by_point;
      }
    }
    equations.freedoms -= 3.0;
    elimination.inverse = of_point.inverse();
    const Matrix63 through = elimination.cross * elimination.inverse;
    equations.hessian -= through * elimination.cross.transpose();
    equations.gradient -= through * elimination.gradient;
    return elimination.inverse.allFinite();
  }

  const StereoRig& rig_;
  const std::vector<TwoViewPoint>& points_;
  double noise_;
};

// Where a's own views, or b's by the motion, have it.
TwoViewState StartOf(const StereoRig& rig, const std::vector<TwoViewPoint>& points,
                     const Rigid3& a_from_b) {
  TwoViewState state{a_from_b, {}};
  const Rigid3 left_a_from_left_b =
      rig.body_from_cam[0].Inverse() * a_from_b * rig.body_from_cam[0];
  for (const TwoViewPoint& point : points) {
    double inverse_depth = point.in_a.inverse_depth;
    if (inverse_depth <= 0.0) {
      const Eigen::Vector3d in_a =
          left_a_from_left_b * (point.in_b.left.homogeneous() / point.in_b.inverse_depth);
      inverse_depth = 1.0 / in_a.z();
    }
    state.points.emplace_back(point.in_a.left.x(), point.in_a.left.y(), inverse_depth);
  }
  return state;
}

TwoViewState Moved(const TwoViewState& state, const TwoViewEquations& equations,
                   const Vector6& step) {
  TwoViewState moved{Plus(state.a_from_b, step), state.points};
  for (std::size_t i = 0; i < moved.points.size(); ++i) {
    const TwoViewEquations::Elimination& point = equations.points[i];
    moved.points[i] -= point.inverse * (point.gradient + point.cross.transpose() * step);
  }
  return moved;
}

std::vector<TwoViewPoint> WithDepth(const std::vector<TwoViewPoint>& points) {
  std::vector<TwoViewPoint> with_depth;
  for (const TwoViewPoint& point : points) {
    if (point.in_a.left.allFinite() && point.in_b.left.allFinite() &&
        (point.in_a.inverse_depth > 0.0 || point.in_b.inverse_depth > 0.0)) {
      with_depth.push_back(point);
    }
  }
  return with_depth;
}

}  // namespace

std::optional<TwoViewProjection> ProjectInto(const Rigid3& body_from_cam, const Rigid3& a_from_b,
                                             const Rigid3& body_from_left,
                                             const Eigen::Vector3d& point) {
  // All places are multiplied by the inverse depth, so that points far away are as good as others.
  const double inverse_depth = point.z();
  const Eigen::Vector3d ray(point.x(), point.y(), 1.0);
  const Eigen::Matrix3d b_from_a = a_from_b.rotation.toRotationMatrix().transpose();
  const Eigen::Matrix3d b_from_left = b_from_a * body_from_left.rotation.toRotationMatrix();
  const Eigen::Vector3d left_in_b = b_from_a * (body_from_left.translation - a_from_b.translation);
  const Eigen::Vector3d in_b = b_from_left * ray + inverse_depth * left_in_b;
  const Eigen::Matrix3d cam_from_b = body_from_cam.rotation.toRotationMatrix().transpose();
  const Eigen::Vector3d in_cam = cam_from_b * (in_b - inverse_depth * body_from_cam.translation);
  constexpr double kNearest = 1e-3;
  if (in_cam.z() < kNearest) {
    return std::nullopt;
  }
  TwoViewProjection projection;
  projection.place = in_cam.hnormalized();
  Eigen::Matrix<double, 2, 3> by_cam;
  by_cam << Eigen::Matrix2d::Identity(), -projection.place;
  by_cam /= in_cam.z();
  Eigen::Matrix3d in_cam_by_point;
  in_cam_by_point << cam_from_b * b_from_left.leftCols<2>(),
      cam_from_b * (left_in_b - body_from_cam.translation);
  projection.by_point = by_cam * in_cam_by_point;
  projection.by_motion << -inverse_depth * by_cam * cam_from_b * b_from_a,
      by_cam * cam_from_b * Skew(in_b);
  return projection;
}

std::optional<LoopMeasurement> RefineMotion(const StereoRig& rig,
                                            const std::vector<TwoViewPoint>& points,
                                            const Rigid3& a_from_b, double noise_px) {
  const std::vector<TwoViewPoint> used = WithDepth(points);
  const TwoViewProblem problem(rig, used, FromReferencePx(noise_px));
  TwoViewState state = StartOf(rig, used, a_from_b);
  std::optional<TwoViewEquations> equations = problem.Linearize(state);
  double damping = 1e-6;
  for (int i = 0; i < kMostSteps && equations; ++i) {
    Matrix6 damped = equations->hessian;
    damped.diagonal() *= 1.0 + damping;
    const Vector6 step = -damped.ldlt().solve(equations->gradient);
    const TwoViewState moved = Moved(state, *equations, step);
    const std::optional<TwoViewEquations> next = problem.Linearize(moved);
    if (!next || !(next->cost < equations->cost)) {
      damping *= 100.0;
      continue;
    }
    const double gain = equations->cost - next->cost;
    state = moved;
    equations = next;
    damping = std::max(1e-9, 0.1 * damping);
    if (gain <= kConverged * equations->cost) {
      break;
    }
  }
  if (!equations || equations->freedoms <= 0.0) {
    return std::nullopt;
  }
  const Eigen::LDLT<Matrix6> factors(equations->hessian);
  if (factors.info() != Eigen::Success || !factors.isPositive()) {
    return std::nullopt;
  }
  const double variance = std::max(kLeastVariance, equations->squares / equations->freedoms);
  // The position's error is that in b's axes.
  Matrix6 to_b = Matrix6::Identity();
  to_b.topLeftCorner<3, 3>() = state.a_from_b.rotation.toRotationMatrix().transpose();
  LoopMeasurement refined{state.a_from_b, variance * to_b * factors.solve(to_b.transpose())};
  refined.covariance = 0.5 * (refined.covariance + refined.covariance.transpose()).eval();
  if (!refined.covariance.allFinite()) {
    return std::nullopt;
  }
  return refined;
}

}  // namespace gluevo::vo::internal
