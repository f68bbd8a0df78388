#include "spline.h"

#include <Eigen/SparseCholesky>
#include <Eigen/SparseCore>
#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include "gluevo/nn/error.h"
#include "gluevo/vo/core/seconds.h"

namespace gluevo::simulation {
namespace {

constexpr double kKnotS = 0.1;
/// Weight of the squared third differences against the squared residuals of one knot's span: a
/// wave of w radians a knot is kept by 1 / (1 + weight * (2 sin(w / 2))^6), half of it at 4 Hz.
constexpr double kSmoothing = 0.02;
constexpr std::array<double, 4> kThirdDifference = {-1.0, 3.0, -3.0, 1.0};

double SecondsAfterFirst(const vo::Trajectory& trajectory, std::size_t i) {
  return vo::SecondsBetween(trajectory.front().timestamp_ns, trajectory[i].timestamp_ns);
}

template <int degree>
using Weights = std::array<double, degree + 1>;

/// Values of the uniform B-splines that are not zero at `u` of a piece (Cox and de Boor's
/// recursion).
template <int degree>
Weights<degree> BasisAt(double u) {
  Weights<degree> weights = {1.0};
  for (int d = 1; d <= degree; ++d) {
    double saved = 0.0;
    for (int r = 0; r < d; ++r) {
      const double part = weights[r] / d;
      weights[r] = saved + (r + 1.0 - u) * part;
      saved = (u + d - r - 1.0) * part;
    }
    weights[d] = saved;
  }
  return weights;
}

}  // namespace

TrajectorySpline::TrajectorySpline(const vo::Trajectory& trajectory, const std::string& what) {
  constexpr double kShortestS = 0.5;
  constexpr double kLongestS = 7200.0;
  duration_s_ = trajectory.empty() ? 0.0 : SecondsAfterFirst(trajectory, trajectory.size() - 1);
  if (trajectory.size() < 2 || duration_s_ < kShortestS || duration_s_ > kLongestS) {
    throw Error(what + ": " + std::to_string(trajectory.size()) + " poses over " +
                std::to_string(duration_s_) + " s, expected 0.5 s to 2 hours of them");
  }
  pieces_ = static_cast<int>(std::ceil(duration_s_ / kKnotS));
  const int controls = pieces_ + kDegree;
  std::vector<Eigen::Triplet<double>> terms;
  Eigen::Matrix<double, Eigen::Dynamic, 7> right = decltype(right)::Zero(controls, 7);
  Eigen::Vector4d last = trajectory.front().world_from_body.rotation.coeffs();
  for (std::size_t i = 0; i < trajectory.size(); ++i) {
    // q and -q are the same rotation: take the one that continues.
    Eigen::Vector4d quaternion = trajectory[i].world_from_body.rotation.coeffs();
    if (quaternion.dot(last) < 0.0) quaternion = -quaternion;
    // Half the angle between the two rotations. Close to 90 degrees, the way round is a guess.
    if (quaternion.dot(last) < 0.5) {
      throw Error(what + ": the body turns by more than 120 degrees from pose " +
                  std::to_string(i) + " to the next, so that its way is unknown");
    }
    last = quaternion;
    Values values;
    values << trajectory[i].world_from_body.translation.transpose(), quaternion.transpose();
    const double time = SecondsAfterFirst(trajectory, i);
    const double from = i > 0 ? SecondsAfterFirst(trajectory, i - 1) : time;
    const double to = i + 1 < trajectory.size() ? SecondsAfterFirst(trajectory, i + 1) : time;
    // Each sample stands for its share of the time, whatever the rate.
    const double weight = std::min(0.5 * (to - from) / kKnotS, 1.0);
    const int piece = std::min(static_cast<int>(time / kKnotS), pieces_ - 1);
    const Weights<kDegree> basis = BasisAt<kDegree>(time / kKnotS - piece);
    for (int a = 0; a <= kDegree; ++a) {
      right.row(piece + a) += weight * basis[a] * values;
      for (int b = 0; b <= kDegree; ++b) {
        terms.emplace_back(piece + a, piece + b, weight * basis[a] * basis[b]);
      }
    }
  }
  for (int i = 0; i + 3 < controls; ++i) {
    for (int a = 0; a < 4; ++a) {
      for (int b = 0; b < 4; ++b) {
        terms.emplace_back(i + a, i + b, kSmoothing * kThirdDifference[a] * kThirdDifference[b]);
      }
    }
  }
  // Two poses leave a parabola open, which only this decides.
  constexpr double kTinyWeight = 1e-9;
  for (int i = 0; i + 1 < controls; ++i) {
    terms.emplace_back(i, i, kTinyWeight);
    terms.emplace_back(i + 1, i + 1, kTinyWeight);
    terms.emplace_back(i, i + 1, -kTinyWeight);
    terms.emplace_back(i + 1, i, -kTinyWeight);
  }
  Eigen::SparseMatrix<double> left(controls, controls);
  left.setFromTriplets(terms.begin(), terms.end());
  const Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>> solver(left);
  controls_ = solver.solve(right);
  if (solver.info() != Eigen::Success || !controls_.allFinite()) {
    throw Error(what + ": no smooth path through its poses could be found");
  }
  // Turns that are fast for the spline's bandwidth average to quaternions of no length.
  constexpr double kLeastLength = 0.3;
  for (int i = 0; i <= 4 * pieces_; ++i) {
    const double time = std::min(0.25 * i * kKnotS, duration_s_);
    if (!(Blend(time).tail<4>().norm() > kLeastLength)) {
      throw Error(what + ": the body turns too fast to be followed around " + std::to_string(time) +
                  " s after its first pose");
    }
  }
}

TrajectorySpline::Values TrajectorySpline::Blend(double time_s) const {
  const int piece = static_cast<int>(std::clamp(std::floor(time_s / kKnotS), 0.0, pieces_ - 1.0));
  const Weights<kDegree> basis = BasisAt<kDegree>(time_s / kKnotS - piece);
  Values values = Values::Zero();
  for (int i = 0; i <= kDegree; ++i) values += basis[i] * controls_.row(piece + i);
  return values;
}

vo::Rigid3 TrajectorySpline::At(double time_s) const {
  const Values values = Blend(time_s);
  return {Eigen::Quaterniond(Eigen::Vector4d(values.tail<4>())).normalized(), values.head<3>()};
}

double TakeOffSeconds(const vo::Trajectory& trajectory, const std::string& what) {
  constexpr double kRestS = 2.0;
  constexpr double kStill = 0.02;  // metres
  constexpr double kAway = 1.0;    // metres
  const auto position = [&](std::size_t i) { return trajectory[i].world_from_body.translation; };
  const auto end_of_stay = [&](std::size_t from, double radius) {
    std::size_t i = from;
    while (i + 1 < trajectory.size() && (position(i + 1) - position(from)).norm() <= radius) ++i;
    return i;
  };
  std::optional<std::size_t> rest;
  for (std::size_t i = 0; i < trajectory.size();) {
    const std::size_t still_to = end_of_stay(i, kStill);
    if (SecondsAfterFirst(trajectory, still_to) - SecondsAfterFirst(trajectory, i) >= kRestS) {
      rest = still_to;
      i = still_to + 1;
    } else if (rest && (position(i) - position(*rest)).norm() > kAway) {
      return SecondsAfterFirst(trajectory, *rest);
    } else {
      ++i;
    }
  }
  throw Error(what +
              ": no take-off found, expected a body at rest for 2 s that then moves 1 m away");
}

}  // namespace gluevo::simulation
