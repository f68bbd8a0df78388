#include "gluevo/vo/evaluation/evaluation.h"

#include <Eigen/LU>
#include <Eigen/SVD>
#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>
#include <vector>

#include "gluevo/nn/error.h"
#include "gluevo/nn/option_error.h"
#include "gluevo/vo/core/angle.h"
#include "gluevo/vo/core/median.h"
#include "pose_association.h"

namespace gluevo::vo {
namespace {

constexpr std::size_t kFewestPairs = 3;
constexpr double kSecondsPerNanosecond = 1e-9;

struct Moments {
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  double variance = 0.0;  // Mean squared distance from the mean, square metres.

  /// Whether the points differ by no more than the rounding of their coordinates.
  bool InOnePlace() const {
    constexpr double kRelative = 1e-12;
    const double noise = kRelative * (1.0 + mean.norm());
    return !(variance > noise * noise);
  }
};

Moments MomentsOf(const std::vector<Eigen::Vector3d>& points) {
  Moments moments;
  const auto count = static_cast<double>(points.size());
  for (const Eigen::Vector3d& point : points) {
    moments.mean += point / count;
  }
  for (const Eigen::Vector3d& point : points) {
    moments.variance += (point - moments.mean).squaredNorm() / count;
  }
  return moments;
}

Eigen::Vector3d Align(const Similarity3& target_from_source, const Eigen::Vector3d& source) {
  return target_from_source.scale * (target_from_source.rigid.rotation * source) +
         target_from_source.rigid.translation;
}

double RootMeanSquare(const std::vector<PoseError>& errors, double PoseError::*error) {
  double sum = 0.0;
  for (const PoseError& pose : errors) {
    sum += (pose.*error) * (pose.*error);
  }
  return std::sqrt(sum / static_cast<double>(errors.size()));
}

void EvaluateAbsolute(const std::vector<PosePair>& pairs, Evaluation& evaluation) {
  std::vector<Eigen::Vector3d> source;
  std::vector<Eigen::Vector3d> target;
  for (const PosePair& pair : pairs) {
    source.push_back(pair.estimate->world_from_body.translation);
    target.push_back(pair.groundtruth->world_from_body.translation);
  }
  const Moments source_moments = MomentsOf(source);
  const Moments target_moments = MomentsOf(target);
  Similarity3 se3;
  Similarity3 sim3;
  if (source_moments.InOnePlace() || target_moments.InOnePlace()) {
    se3.rigid.translation = target_moments.mean - source_moments.mean;
    sim3 = se3;
    evaluation.scale = std::numeric_limits<double>::quiet_NaN();
  } else {
    se3 = AlignUmeyama(source, target, /*with_scale=*/false);
    sim3 = AlignUmeyama(source, target, /*with_scale=*/true);
    evaluation.scale = sim3.scale;
  }
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    PoseError error;
    error.timestamp_ns = pairs[i].estimate->timestamp_ns;
    error.groundtruth = target[i];
    error.se3 = Align(se3, source[i]);
    error.sim3 = Align(sim3, source[i]);
    error.se3_m = (error.se3 - target[i]).norm();
    error.sim3_m = (error.sim3 - target[i]).norm();
    evaluation.errors.push_back(error);
  }
  evaluation.ate_se3_m = RootMeanSquare(evaluation.errors, &PoseError::se3_m);
  evaluation.ate_sim3_m = RootMeanSquare(evaluation.errors, &PoseError::sim3_m);
  evaluation.groundtruth_world_from_estimate_world = se3.rigid;
  evaluation.groundtruth_world_from_estimate_world_sim3 = sim3;
}

/// KITTI's lengths of sub-paths, or the largest tenths of them of which a path holds five.
constexpr double kLengthSteps[] = {100.0, 10.0, 1.0, 0.1};
constexpr int kFewestHeld = 5;

std::vector<double> SubPathLengths(double path_length) {
  constexpr int kLengths = 8;
  for (const double step : kLengthSteps) {
    if (path_length >= kFewestHeld * step) {
      std::vector<double> lengths;
      for (int i = 1; i <= kLengths; ++i) {
        lengths.push_back(i * step);
      }
      return lengths;
    }
  }
  return {};
}

std::size_t CountCorrectMotions(const std::vector<PosePair>& pairs,
                                const EvaluationOptions& options) {
  std::size_t right = 0;
  for (std::size_t i = 1; i < pairs.size(); ++i) {
    right += IsCorrectMotion(pairs[i - 1], pairs[i], options) ? 1 : 0;
  }
  return right;
}

void EvaluateRelative(const std::vector<PosePair>& pairs, const EvaluationOptions& options,
                      Evaluation& evaluation) {
  std::vector<double> travelled = {0.0};
  for (std::size_t i = 1; i < pairs.size(); ++i) {
    travelled.push_back(travelled.back() + (pairs[i].groundtruth->world_from_body.translation -
                                            pairs[i - 1].groundtruth->world_from_body.translation)
                                               .norm());
  }
  double translation_sum = 0.0;
  double rotation_sum = 0.0;
  std::size_t count = 0;
  const bool is_asked = !options.rpe_lengths_m.empty();
  const std::vector<double> lengths =
      is_asked ? options.rpe_lengths_m : SubPathLengths(travelled.back());
  evaluation.path_m = travelled.back();
  evaluation.shortest_path_m =
      is_asked ? *std::min_element(lengths.begin(), lengths.end())
               : kFewestHeld * *std::min_element(std::begin(kLengthSteps), std::end(kLengthSteps));
  for (const double length : lengths) {
    const std::size_t count_before = count;
    for (std::size_t start = 0; start < pairs.size(); ++start) {
      const auto end =
          std::upper_bound(travelled.begin(), travelled.end(), travelled[start] + length);
      if (end == travelled.end()) {
        break;
      }
      const PosePair& last = pairs[static_cast<std::size_t>(end - travelled.begin())];
      const Rigid3 error = MotionError(pairs[start], last);
      translation_sum += error.translation.norm() / length;
      rotation_sum += AngleOf(error) / length;
      ++count;
    }
    if (count > count_before) {
      evaluation.rpe_lengths_m.push_back(length);
    }
  }
  constexpr double kPercent = 100.0;
  const double weight =
      count > 0 ? 1.0 / static_cast<double>(count) : std::numeric_limits<double>::quiet_NaN();
  evaluation.rpe_translation_percent = kPercent * weight * translation_sum;
  evaluation.rpe_rotation_deg_per_m = weight * rotation_sum / kDegree;
}

void EvaluateMotions(const std::vector<PosePair>& pairs, Evaluation& evaluation) {
  for (std::size_t i = 1; i < pairs.size(); ++i) {
    const Rigid3 error = MotionError(pairs[i - 1], pairs[i]);
    evaluation.errors[i].motion_m = error.translation.norm();
    evaluation.errors[i].motion_deg = AngleOf(error) / kDegree;
  }
}

void EvaluateFrameSteps(const std::vector<PosePair>& pairs, const EvaluationOptions& options,
                        Evaluation& evaluation) {
  const auto delta = static_cast<std::size_t>(options.rpe_frames);
  const std::size_t step = options.rpe_every_frame ? 1 : delta;
  double squared_translations = 0.0;
  double squared_angles = 0.0;
  std::vector<double> translations;
  for (std::size_t start = 0; start + delta < pairs.size(); start += step) {
    const Rigid3 error = MotionError(pairs[start], pairs[start + delta]);
    const double angle = AngleOf(error) / kDegree;
    squared_translations += error.translation.squaredNorm();
    squared_angles += angle * angle;
    translations.push_back(error.translation.norm());
  }
  const auto count = static_cast<double>(translations.size());
  // 0 / 0 is NaN: fewer poses than the step.
  evaluation.rpe_frames_translation_m = std::sqrt(squared_translations / count);
  evaluation.rpe_frames_rotation_deg = std::sqrt(squared_angles / count);
  evaluation.rpe_frames_translation_median_m = translations.empty()
                                                   ? std::numeric_limits<double>::quiet_NaN()
                                                   : Median(std::move(translations));
}

double Seconds(int64_t from_ns, int64_t to_ns) {
  return static_cast<double>(TimeApart(from_ns, to_ns)) * kSecondsPerNanosecond;
}

/// `shorter` is the trajectory whose poses look for a mate: were all found, they would be no
/// further apart than its own.
double Coverage(const std::vector<PosePair>& pairs, const Trajectory& groundtruth,
                const Trajectory& shorter) {
  constexpr double kGap = 1.0;
  constexpr double kStepsOfGap = 3.0;
  const double longest_gap = std::max(kGap, kStepsOfGap * MedianStep(shorter));
  double covered = 0.0;
  for (std::size_t i = 1; i < pairs.size(); ++i) {
    const double step =
        Seconds(pairs[i - 1].groundtruth->timestamp_ns, pairs[i].groundtruth->timestamp_ns);
    covered += step <= longest_gap ? step : 0.0;
  }
  const double duration =
      Seconds(groundtruth.front().timestamp_ns, groundtruth.back().timestamp_ns);
  return duration > 0.0 ? std::min(1.0, covered / duration) : 0.0;
}

}  // namespace

void EvaluationOptions::Validate() const {
  constexpr double kLongest = 1e6;
  if (!(max_time_difference_s >= 0.0 && max_time_difference_s <= kLongest)) {
    throw OptionError(
        "the largest time difference of poses that belong together must be 0 to 1e6 s");
  }
  if (!(correct_motion_m > 0.0 && correct_motion_deg > 0.0)) {
    throw OptionError("the bounds of a correct motion must be above 0");
  }
  if (rpe_frames < 1) {
    throw OptionError("the relative pose error must be over 1 frame or more");
  }
  for (const double length : rpe_lengths_m) {
    if (!(length > 0.0 && length <= kLongest)) {
      throw OptionError(
          "lengths of sub-paths of the relative pose error must be above 0, at most 1e6 m");
    }
  }
}

Similarity3 AlignUmeyama(const std::vector<Eigen::Vector3d>& source,
                         const std::vector<Eigen::Vector3d>& target, bool with_scale) {
  if (source.size() != target.size() || source.size() < kFewestPairs) {
    throw Error("alignment of " + std::to_string(source.size()) + " points with " +
                std::to_string(target.size()) + ", expected equally many and at least 3");
  }
  const Moments source_moments = MomentsOf(source);
  const Moments target_moments = MomentsOf(target);
  if (source_moments.InOnePlace() || target_moments.InOnePlace()) {
    throw Error("alignment of points that are all in one place");
  }
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
  for (std::size_t i = 0; i < source.size(); ++i) {
    covariance += (target[i] - target_moments.mean) *
                  (source[i] - source_moments.mean).transpose() /
                  static_cast<double>(source.size());
  }
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(covariance,
                                              Eigen::ComputeFullU | Eigen::ComputeFullV);
  Eigen::Vector3d signs = Eigen::Vector3d::Ones();
  if (svd.matrixU().determinant() * svd.matrixV().determinant() < 0.0) {
    signs.z() = -1.0;
  }
  const Eigen::Matrix3d rotation = svd.matrixU() * signs.asDiagonal() * svd.matrixV().transpose();
  Similarity3 alignment;
  alignment.rigid.rotation = Eigen::Quaterniond(rotation).normalized();
  if (with_scale) {
    alignment.scale = svd.singularValues().dot(signs) / source_moments.variance;
  }
  alignment.rigid.translation =
      target_moments.mean - alignment.scale * (alignment.rigid.rotation * source_moments.mean);
  return alignment;
}

Evaluation Evaluate(const Trajectory& estimate, const Trajectory& groundtruth,
                    const EvaluationOptions& options) {
  const std::vector<PosePair> pairs = AssociatePoses(estimate, groundtruth, options);
  Evaluation evaluation;
  evaluation.pairs = pairs.size();
  EvaluateAbsolute(pairs, evaluation);
  EvaluateMotions(pairs, evaluation);
  evaluation.correct_motions = CountCorrectMotions(pairs, options);
  EvaluateRelative(pairs, options, evaluation);
  EvaluateFrameSteps(pairs, options, evaluation);
  evaluation.estimate_poses = estimate.size();
  evaluation.groundtruth_poses = groundtruth.size();
  evaluation.coverage =
      Coverage(pairs, groundtruth, estimate.size() > groundtruth.size() ? groundtruth : estimate);
  return evaluation;
}

}  // namespace gluevo::vo
