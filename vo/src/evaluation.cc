#include "gluevo/vo/evaluation.h"

#include <Eigen/SVD>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <utility>

#include "gluevo/nn/error.h"

namespace gluevo::vo {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

struct Pair {
  StampedPose estimate;
  StampedPose groundtruth;
};

// As evo does: each pose of the shorter trajectory with the nearest in time of the longer one.
std::vector<Pair> Associate(const Trajectory& estimate, const Trajectory& groundtruth,
                            double max_time_difference_s) {
  const bool estimate_is_longer = estimate.size() > groundtruth.size();
  const Trajectory& longer = estimate_is_longer ? estimate : groundtruth;
  const Trajectory& shorter = estimate_is_longer ? groundtruth : estimate;
  std::vector<Pair> pairs;
  for (const StampedPose& pose : shorter) {
    const auto after =
        std::lower_bound(longer.begin(), longer.end(), pose.timestamp_ns,
                         [](const StampedPose& p, int64_t time) { return p.timestamp_ns < time; });
    auto nearest = after;
    if (after == longer.end() ||
        (after != longer.begin() && pose.timestamp_ns - std::prev(after)->timestamp_ns <=
                                        after->timestamp_ns - pose.timestamp_ns)) {
      nearest = std::prev(after);
    }
    const double difference_s =
        std::abs(static_cast<double>(nearest->timestamp_ns - pose.timestamp_ns)) * 1e-9;
    if (difference_s <= max_time_difference_s) {
      pairs.push_back(estimate_is_longer ? Pair{*nearest, pose} : Pair{pose, *nearest});
    }
  }
  return pairs;
}

bool AllInOnePlace(const std::vector<Eigen::Vector3d>& points) {
  return std::all_of(points.begin(), points.end(), [&](const Eigen::Vector3d& point) {
    return (point - points.front()).norm() < 1e-12;
  });
}

Eigen::Vector3d MeanOf(const std::vector<Eigen::Vector3d>& points) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (const Eigen::Vector3d& point : points) {
    sum += point;
  }
  return sum / static_cast<double>(points.size());
}

double RmseAfter(const Similarity3& target_from_source, const std::vector<Eigen::Vector3d>& source,
                 const std::vector<Eigen::Vector3d>& target) {
  double sum = 0.0;
  for (std::size_t i = 0; i < source.size(); ++i) {
    const Eigen::Vector3d moved =
        target_from_source.scale * (target_from_source.rigid.rotation * source[i]) +
        target_from_source.rigid.translation;
    sum += (moved - target[i]).squaredNorm();
  }
  return std::sqrt(sum / static_cast<double>(source.size()));
}

// Error of the estimated motion from one pose to another, in the body's frame at the latter.
Rigid3 MotionError(const Pair& from, const Pair& to) {
  const auto motion = [&](StampedPose Pair::*pose) {
    return (from.*pose).world_from_body.Inverse() * (to.*pose).world_from_body;
  };
  return motion(&Pair::groundtruth).Inverse() * motion(&Pair::estimate);
}

double AngleOf(const Rigid3& transform) {
  return transform.rotation.angularDistance(Eigen::Quaterniond::Identity());
}

std::size_t CountRightMotions(const std::vector<Pair>& pairs, const EvaluationOptions& options) {
  std::size_t right = 0;
  for (std::size_t i = 1; i < pairs.size(); ++i) {
    const Rigid3 error = MotionError(pairs[i - 1], pairs[i]);
    right += error.translation.norm() <= options.right_motion_m &&
             AngleOf(error) * 180.0 / std::numbers::pi <= options.right_motion_deg;
  }
  return right;
}

void EvaluateRelative(const std::vector<Pair>& pairs, Evaluation& evaluation) {
  std::vector<double> path = {0.0};  // Along the ground truth, metres.
  for (std::size_t i = 1; i < pairs.size(); ++i) {
    path.push_back(path.back() + (pairs[i].groundtruth.world_from_body.translation -
                                  pairs[i - 1].groundtruth.world_from_body.translation)
                                     .norm());
  }
  evaluation.rpe_translation_percent = kNan;
  evaluation.rpe_rotation_deg_per_m = kNan;
  double unit = 100.0;
  while (path.back() < 5.0 * unit && unit > 0.1) {
    unit /= 10.0;
  }
  if (path.back() < 5.0 * unit) {
    return;
  }
  double translation_sum = 0.0;
  double rotation_sum = 0.0;
  std::size_t count = 0;
  for (int multiple = 1; multiple <= 8; ++multiple) {
    const double length = unit * multiple;
    bool has_any = false;
    for (std::size_t first = 0; first < pairs.size(); ++first) {
      const auto last = static_cast<std::size_t>(
          std::upper_bound(path.begin(), path.end(), path[first] + length) - path.begin());
      if (last == pairs.size()) {
        break;
      }
      const Rigid3 error = MotionError(pairs[first], pairs[last]);
      translation_sum += error.translation.norm() / length;
      rotation_sum += AngleOf(error) / length;
      ++count;
      has_any = true;
    }
    if (has_any) {
      evaluation.rpe_lengths_m.push_back(length);
    }
  }
  evaluation.rpe_translation_percent = 100.0 * translation_sum / static_cast<double>(count);
  evaluation.rpe_rotation_deg_per_m =
      rotation_sum / static_cast<double>(count) * 180.0 / std::numbers::pi;
}

double Coverage(const std::vector<Pair>& pairs, const Trajectory& groundtruth) {
  const int64_t whole = groundtruth.back().timestamp_ns - groundtruth.front().timestamp_ns;
  if (whole <= 0) {
    return 1.0;
  }
  std::vector<int64_t> steps;
  for (std::size_t i = 1; i < pairs.size(); ++i) {
    steps.push_back(pairs[i].groundtruth.timestamp_ns - pairs[i - 1].groundtruth.timestamp_ns);
  }
  std::vector<int64_t> sorted = steps;
  std::sort(sorted.begin(), sorted.end());
  const int64_t largest_gap = std::max<int64_t>(1'000'000'000, 3 * sorted[sorted.size() / 2]);
  int64_t covered = 0;
  for (const int64_t step : steps) {
    covered += step <= largest_gap ? step : 0;
  }
  return static_cast<double>(covered) / static_cast<double>(whole);
}

}  // namespace

void EvaluationOptions::Validate() const {
  if (!(max_time_difference_s >= 0.0) || !std::isfinite(max_time_difference_s)) {
    throw Error("largest time difference " + std::to_string(max_time_difference_s) +
                " s is out of range: expected 0 or more");
  }
  if (!(right_motion_m > 0.0) || !(right_motion_deg > 0.0)) {
    throw Error("bounds of a right motion are out of range: expected above 0");
  }
}

Similarity3 AlignUmeyama(const std::vector<Eigen::Vector3d>& source,
                         const std::vector<Eigen::Vector3d>& target, bool with_scale) {
  if (source.size() != target.size() || source.size() < 3) {
    throw Error("alignment needs two equally long lists of at least 3 points, got " +
                std::to_string(source.size()) + " and " + std::to_string(target.size()));
  }
  if (AllInOnePlace(source) || AllInOnePlace(target)) {
    throw Error("points that are all in one place cannot be aligned");
  }
  const auto n = static_cast<double>(source.size());
  const Eigen::Vector3d source_mean = MeanOf(source);
  const Eigen::Vector3d target_mean = MeanOf(target);
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
  double source_variance = 0.0;
  for (std::size_t i = 0; i < source.size(); ++i) {
    covariance += (target[i] - target_mean) * (source[i] - source_mean).transpose() / n;
    source_variance += (source[i] - source_mean).squaredNorm() / n;
  }
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(covariance,
                                              Eigen::ComputeFullU | Eigen::ComputeFullV);
  Eigen::Vector3d signs = Eigen::Vector3d::Ones();
  if (svd.matrixU().determinant() * svd.matrixV().determinant() < 0.0) {
    signs.z() = -1.0;
  }
  Similarity3 result;
  result.rigid.rotation = Eigen::Quaterniond(
      Eigen::Matrix3d(svd.matrixU() * signs.asDiagonal() * svd.matrixV().transpose()));
  result.scale = with_scale ? svd.singularValues().dot(signs) / source_variance : 1.0;
  result.rigid.translation = target_mean - result.scale * (result.rigid.rotation * source_mean);
  return result;
}

Evaluation Evaluate(const Trajectory& estimate, const Trajectory& groundtruth,
                    const EvaluationOptions& options) {
  options.Validate();
  std::vector<Pair> pairs;
  if (!estimate.empty() && !groundtruth.empty()) {
    pairs = Associate(estimate, groundtruth, options.max_time_difference_s);
  }
  if (pairs.size() < 3) {
    throw Error("only " + std::to_string(pairs.size()) +
                " poses of the estimate and the ground truth are within " +
                std::to_string(options.max_time_difference_s) +
                " s of each other, expected at least 3: are they of the same sequence and clock?");
  }
  std::vector<Eigen::Vector3d> source;
  std::vector<Eigen::Vector3d> target;
  for (const Pair& pair : pairs) {
    source.push_back(pair.estimate.world_from_body.translation);
    target.push_back(pair.groundtruth.world_from_body.translation);
  }

  Evaluation evaluation;
  evaluation.pairs = pairs.size();
  if (AllInOnePlace(source) || AllInOnePlace(target)) {
    Similarity3 shift;
    shift.rigid.translation = MeanOf(target) - MeanOf(source);
    evaluation.ate_se3_m = evaluation.ate_sim3_m = RmseAfter(shift, source, target);
    evaluation.scale = kNan;
    evaluation.groundtruth_world_from_estimate_world = shift.rigid;
  } else {
    const Similarity3 rigid = AlignUmeyama(source, target, /*with_scale=*/false);
    const Similarity3 scaled = AlignUmeyama(source, target, /*with_scale=*/true);
    evaluation.ate_se3_m = RmseAfter(rigid, source, target);
    evaluation.ate_sim3_m = RmseAfter(scaled, source, target);
    evaluation.scale = scaled.scale;
    evaluation.groundtruth_world_from_estimate_world = rigid.rigid;
  }
  EvaluateRelative(pairs, evaluation);
  evaluation.right_motions = CountRightMotions(pairs, options);
  evaluation.coverage = Coverage(pairs, groundtruth);
  return evaluation;
}

}  // namespace gluevo::vo
