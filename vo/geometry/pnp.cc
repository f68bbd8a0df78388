#include "gluevo/vo/geometry/pnp.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <opencv2/calib3d.hpp>
#include <opencv2/core/eigen.hpp>
#include <random>

#include "gluevo/vo/core/median.h"
#include "gluevo/vo/core/options_check.h"
#include "gluevo/vo/core/reference_focal.h"
#include "gluevo/vo/geometry/eigen_solvers.h"
#include "gluevo/vo/geometry/manifold.h"
#include "gluevo/vo/geometry/projection.h"
#include "pnp_scoring.h"

namespace gluevo::vo {
namespace {

// Huber threshold of the refinement, in standard deviations.
constexpr double kHuber = 1.5;

using Matrix26 = Eigen::Matrix<double, 2, 6>;

/// Normal equations of the pose step, the depths eliminated.
struct Normal {
  Eigen::Matrix<double, 6, 6> hessian = Eigen::Matrix<double, 6, 6>::Zero();
  Eigen::Matrix<double, 6, 1> gradient = Eigen::Matrix<double, 6, 1>::Zero();
};

Matrix26 PoseJacobian(const Rigid3& world_from_body, const Rigid3& body_from_cam,
                      const AnchoredPoint& point, double weight) {
  const Eigen::Matrix3d body_from_world = world_from_body.rotation.toRotationMatrix().transpose();
  const Eigen::Matrix3d cam_from_body = body_from_cam.rotation.toRotationMatrix().transpose();
  const Eigen::Vector3d in_body =
      body_from_world *
      (point.ray + point.inverse_depth * (point.center - world_from_body.translation));
  const Eigen::Vector3d in_cam =
      cam_from_body * (in_body - point.inverse_depth * body_from_cam.translation);
  const Eigen::Matrix<double, 2, 3> by_body = weight * ProjectionJacobian(in_cam) * cam_from_body;
  Matrix26 jacobian;
  jacobian << -point.inverse_depth * by_body * body_from_world, by_body * Skew(in_body);
  return jacobian;
}

Normal BuildNormal(const StereoRig& rig, const Hypothesis& hypothesis,
                   std::span<const PnpObservation> observations, double weight) {
  const PosedRig posed(rig, hypothesis.world_from_body);
  Normal normal;
  for (std::size_t i = 0; i < observations.size(); ++i) {
    const PnpObservation& observation = observations[i];
    ViewResidual left;
    if (hypothesis.verdicts[i] == PnpVerdict::kOutlier ||
        !Residual(posed.left, observation.point, observation.left, weight, left)) {
      continue;
    }
    const int views =
        observation.has_right && hypothesis.verdicts[i] == PnpVerdict::kInlier ? 2 : 1;
    Eigen::Matrix<double, 4, 1> error = Eigen::Matrix<double, 4, 1>::Zero();
    Eigen::Matrix<double, 4, 1> by_depth = Eigen::Matrix<double, 4, 1>::Zero();
    Eigen::Matrix<double, 4, 6> jacobian = Eigen::Matrix<double, 4, 6>::Zero();
    error.head<2>() = left.error;
    by_depth.head<2>() = left.by_depth;
    jacobian.topRows<2>() =
        PoseJacobian(hypothesis.world_from_body, rig.body_from_cam[0], observation.point, weight);
    ViewResidual right;
    if (views == 2 && Residual(posed.right, observation.point, observation.right, weight, right)) {
      error.tail<2>() = right.error;
      by_depth.tail<2>() = right.by_depth;
      jacobian.bottomRows<2>() =
          PoseJacobian(hypothesis.world_from_body, rig.body_from_cam[1], observation.point, weight);
    }
    const double shrink = 1.0 / (1.0 + by_depth.squaredNorm());
    const double chi = std::sqrt(std::max(
        0.0, Mahalanobis(error.squaredNorm(), error.dot(by_depth), by_depth.squaredNorm())));
    const double robust = chi <= kHuber ? 1.0 : kHuber / chi;
    const Eigen::Matrix<double, 6, 1> by_depth_and_pose = jacobian.transpose() * by_depth;
    normal.hessian += robust * (jacobian.transpose() * jacobian -
                                shrink * by_depth_and_pose * by_depth_and_pose.transpose());
    normal.gradient +=
        robust * (jacobian.transpose() * error - shrink * by_depth.dot(error) * by_depth_and_pose);
  }
  return normal;
}

// Gauss-Newton over the inliers, which are collected anew at each step. Never returns a hypothesis
// that scores worse.
Hypothesis Refine(const StereoRig& rig, Hypothesis best,
                  std::span<const PnpObservation> observations, double weight, int iterations) {
  Hypothesis current = best;
  for (int iteration = 0; iteration < iterations; ++iteration) {
    const Normal normal = BuildNormal(rig, current, observations, weight);
    const Eigen::Matrix<double, 6, 1> step = normal.hessian.ldlt().solve(-normal.gradient);
    if (!step.allFinite()) {
      break;
    }
    current = Score(rig, Plus(current.world_from_body, step), observations, weight);
    if (current.score > best.score) {
      best = current;
    }
    if (step.norm() < 1e-9) {
      break;
    }
  }
  return best;
}

double MedianError(const StereoRig& rig, const Rigid3& world_from_body,
                   std::span<const PnpObservation> observations, double weight) {
  const PosedRig posed(rig, world_from_body);
  std::vector<double> errors;
  errors.reserve(observations.size());
  for (const PnpObservation& observation : observations) {
    ViewResidual left;
    errors.push_back(Residual(posed.left, observation.point, observation.left, weight, left)
                         ? std::sqrt(std::max(0.0, Mahalanobis(left.error.squaredNorm(),
                                                               left.error.dot(left.by_depth),
                                                               left.by_depth.squaredNorm())))
                         : std::numeric_limits<double>::infinity());
  }
  return Median(std::move(errors));
}

// Draws observations in proportion to their votes; the distributions of <random> differ between
// standard libraries.
class Ballot {
 public:
  explicit Ballot(std::span<const PnpObservation> observations) {
    sums_.reserve(observations.size());
    double sum = 0.0;
    for (const PnpObservation& observation : observations) {
      sums_.push_back(sum += observation.vote);
    }
  }

  double all() const { return sums_.back(); }
  std::size_t Draw() {
    const double place = static_cast<double>(generator_() >> 11) * 0x1p-53 * all();
    const auto drawn = std::upper_bound(sums_.begin(), sums_.end() - 1, place);
    return static_cast<std::size_t>(drawn - sums_.begin());
  }

 private:
  std::vector<double> sums_;
  std::mt19937_64 generator_{0};
};

std::vector<Rigid3> SolveP3P(const StereoRig& rig, std::span<const PnpObservation> observations,
                             const std::array<std::size_t, 3>& sample) {
  std::array<cv::Point3d, 3> points;
  std::array<cv::Point2d, 3> pixels;
  for (int k = 0; k < 3; ++k) {
    const PnpObservation& observation = observations[sample[k]];
    const Eigen::Vector3d point = observation.point.InWorld();
    points[k] = {point.x(), point.y(), point.z()};
    pixels[k] = {observation.left.x(), observation.left.y()};
  }
  std::vector<cv::Mat> rotations, translations;
  const int solutions = cv::solveP3P(points, pixels, cv::Matx33d::eye(), cv::noArray(), rotations,
                                     translations, cv::SOLVEPNP_AP3P);
  std::vector<Rigid3> poses;
  for (int i = 0; i < solutions; ++i) {
    const cv::Mat& r = rotations[i];
    const cv::Mat& t = translations[i];
    Rigid3 cam_from_world{ExpSo3({r.at<double>(0), r.at<double>(1), r.at<double>(2)}),
                          {t.at<double>(0), t.at<double>(1), t.at<double>(2)}};
    if (cam_from_world.translation.allFinite() && cam_from_world.rotation.coeffs().allFinite()) {
      poses.push_back((rig.body_from_cam[0] * cam_from_world).Inverse());
    }
  }
  return poses;
}

// A PoseTangent moves the position in the world, a pose's error in the body's axes.
PoseCovariance InAxesOfBody(const Eigen::Matrix<double, 6, 6>& covariance,
                            const Rigid3& world_from_body) {
  Eigen::Matrix<double, 6, 6> turn = Eigen::Matrix<double, 6, 6>::Identity();
  turn.topLeftCorner<3, 3>() = world_from_body.rotation.toRotationMatrix().transpose();
  return turn * covariance * turn.transpose();
}

// Draws until a sample of three inliers has been seen with the asked probability.
int IterationsNeeded(double inlier_share, const PnpOptions& options) {
  const double all_inliers = std::pow(inlier_share, 3);
  if (all_inliers >= 1.0 - 1e-12) {
    return options.min_iterations;
  }
  const double needed = std::log(1.0 - options.confidence) / std::log1p(-all_inliers);
  return static_cast<int>(std::clamp(needed, static_cast<double>(options.min_iterations),
                                     static_cast<double>(options.max_iterations)));
}

}  // namespace

void PnpOptions::Validate() const {
  CheckPositive(noise_px, "pnp.noise_px");
  CheckWithin(confidence, 0.0, 1.0 - 1e-9, "pnp.confidence");
  CheckAtLeast(min_iterations, 1, "pnp.min_iterations");
  CheckAtLeast(max_iterations, min_iterations, "pnp.max_iterations");
  CheckAtLeast(min_inliers, 4, "pnp.min_inliers");
  CheckPositive(max_position_sigma_m, "pnp.max_position_sigma_m");
  CheckPositive(max_rotation_sigma_rad, "pnp.max_rotation_sigma_rad");
}

std::optional<PnpResult> SolvePnp(const StereoRig& rig,
                                  std::span<const PnpObservation> observations,
                                  std::span<const Rigid3> guesses, const PnpOptions& options) {
  if (observations.size() < static_cast<std::size_t>(options.min_inliers)) {
    return std::nullopt;
  }
  constexpr int kLocalIterations = 3;
  constexpr int kFinalIterations = 10;
  const double weight = 1.0 / FromReferencePx(options.noise_px);

  Hypothesis best;
  const auto consider = [&](const Rigid3& world_from_body) {
    Hypothesis hypothesis = Score(rig, world_from_body, observations, weight);
    if (hypothesis.inliers >= 4 && hypothesis.score > best.score) {
      best = Refine(rig, std::move(hypothesis), observations, weight, kLocalIterations);
    }
  };
  for (const Rigid3& guess : guesses) {
    consider(guess);
  }
  Ballot ballot(observations);
  int needed = IterationsNeeded(best.votes / ballot.all(), options);
  for (int iteration = 0; iteration < needed; ++iteration) {
    const std::array<std::size_t, 3> sample = {ballot.Draw(), ballot.Draw(), ballot.Draw()};
    if (sample[0] == sample[1] || sample[0] == sample[2] || sample[1] == sample[2]) {
      continue;
    }
    for (const Rigid3& world_from_body : SolveP3P(rig, observations, sample)) {
      consider(world_from_body);
    }
    needed = IterationsNeeded(best.votes / ballot.all(), options);
  }
  if (best.inliers < options.min_inliers) {
    return std::nullopt;
  }
  best = Refine(rig, std::move(best), observations, weight, kFinalIterations);

  const Eigen::Matrix<double, 6, 6> hessian = BuildNormal(rig, best, observations, weight).hessian;
  const Eigen::LLT<Eigen::Matrix<double, 6, 6>> cholesky(hessian);
  if (cholesky.info() != Eigen::Success) {
    return std::nullopt;
  }
  const Eigen::Matrix<double, 6, 6> covariance =
      cholesky.solve(Eigen::Matrix<double, 6, 6>::Identity());
  PnpResult result{best.world_from_body,
                   std::move(best.verdicts),
                   best.inliers,
                   best.votes / ballot.all(),
                   WorstSigma(covariance.topLeftCorner<3, 3>()),
                   WorstSigma(covariance.bottomRightCorner<3, 3>()),
                   InAxesOfBody(covariance, best.world_from_body),
                   options.noise_px * MedianError(rig, best.world_from_body, observations, weight)};
  const bool certain = result.position_sigma_m <= options.max_position_sigma_m &&
                       result.rotation_sigma_rad <= options.max_rotation_sigma_rad;
  if (!certain || result.inliers < options.min_inliers) {
    return std::nullopt;
  }
  return result;
}

}  // namespace gluevo::vo
