#include "gluevo/vo/inertial/gyroscope_check.h"

#include <Eigen/LU>
#include <Eigen/SVD>
#include <algorithm>
#include <cmath>
#include <optional>

#include "gluevo/vo/core/angle.h"
#include "gluevo/vo/core/median.h"
#include "gluevo/vo/core/text.h"
#include "gluevo/vo/geometry/manifold.h"

namespace gluevo::vo {
namespace {

struct Turn {
  Eigen::Vector3d seen;      ///< Rotation vector, radians.
  Eigen::Vector3d measured;  ///< Integral of the rates: the same for turns that are not large.
};

/// Nothing where samples do not cover the time.
std::optional<Eigen::Vector3d> Integral(const std::vector<ImuSample>& samples, int64_t begin_ns,
                                        int64_t end_ns) {
  const auto at = [&](int64_t time_ns) {
    return std::lower_bound(
        samples.begin(), samples.end(), time_ns,
        [](const ImuSample& sample, int64_t time) { return sample.timestamp_ns < time; });
  };
  const auto begin = at(begin_ns);
  const auto end = at(end_ns);
  constexpr std::ptrdiff_t kFewest = 3;
  if (end == samples.end() || begin == samples.begin() || end - begin < kFewest) {
    return std::nullopt;
  }
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (auto sample = begin; sample != end; ++sample) {
    sum += sample->angular_velocity;
  }
  return sum / static_cast<double>(end - begin) * 1e-9 * static_cast<double>(end_ns - begin_ns);
}

std::vector<Turn> TurnsOf(const Trajectory& frames, const std::vector<ImuSample>& samples) {
  constexpr double kSmallest = kDegree;
  constexpr double kLargest = 60.0 * kDegree;
  std::vector<Turn> turns;
  turns.reserve(frames.size());
  for (std::size_t i = 1; i < frames.size(); ++i) {
    const Eigen::Vector3d seen = LogSo3(frames[i - 1].world_from_body.rotation.conjugate() *
                                        frames[i].world_from_body.rotation);
    const auto measured = Integral(samples, frames[i - 1].timestamp_ns, frames[i].timestamp_ns);
    if (measured && seen.norm() > kSmallest && seen.norm() < kLargest) {
      turns.push_back({seen, *measured});
    }
  }
  return turns;
}

/// Body from gyroscope, and what remains; `correlation` is the sum of seen measured^T.
void FitRotation(const std::vector<Turn>& turns, GyroscopeCheck& check) {
  Eigen::Matrix3d correlation = Eigen::Matrix3d::Zero();
  for (const Turn& turn : turns) {
    correlation += turn.seen * turn.measured.transpose() / check.scale;
  }
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(correlation,
                                              Eigen::ComputeFullU | Eigen::ComputeFullV);
  Eigen::Matrix3d mirror = Eigen::Matrix3d::Identity();
  mirror(2, 2) = (svd.matrixU() * svd.matrixV().transpose()).determinant() < 0.0 ? -1.0 : 1.0;
  // Of turns about one axis alone, the least rotation that brings it in line: about the axis any
  // further one would fit as well.
  constexpr double kFlat = 0.02;
  const Eigen::Vector3d& sizes = svd.singularValues();
  const Eigen::Matrix3d rotation =
      sizes[1] > kFlat * sizes[0]
          ? Eigen::Matrix3d(svd.matrixU() * mirror * svd.matrixV().transpose())
          : Eigen::Quaterniond::FromTwoVectors(svd.matrixV().col(0), svd.matrixU().col(0))
                .toRotationMatrix();
  double left = 0.0;
  double all = 0.0;
  for (const Turn& turn : turns) {
    left += (turn.seen - rotation * turn.measured / check.scale).squaredNorm();
    all += turn.seen.squaredNorm();
  }
  check.unexplained = all > 0.0 ? left / all : 0.0;
  check.body_from_gyroscope = Eigen::Quaterniond(rotation).normalized();
}

std::string Text(double value) { return FixedText(value, 1); }

}  // namespace

GyroscopeCheck CheckGyroscope(const Trajectory& frames, const std::vector<ImuSample>& samples) {
  const std::vector<Turn> turns = TurnsOf(frames, samples);
  GyroscopeCheck check;
  check.turns = turns.size();
  constexpr std::size_t kFewest = 10;
  if (turns.size() < kFewest) {
    return check;
  }
  std::vector<double> scales;
  scales.reserve(turns.size());
  for (const Turn& turn : turns) {
    scales.push_back(turn.measured.norm() / turn.seen.norm());
  }
  check.scale = Median(std::move(scales));
  constexpr double kNear = 0.3;
  constexpr double kLeast = 1e-3;
  if (check.scale < kLeast) {
    check.scale = 1.0;
    check.fault = "the gyroscope shows no turns where the images turn";
    return check;
  }
  FitRotation(turns, check);
  constexpr double kUnlike = 0.3;
  constexpr double kMounted = 8.0 * kDegree;
  const double angle = check.body_from_gyroscope.angularDistance(Eigen::Quaterniond::Identity());
  check.is_degrees = std::abs(check.scale * kDegree - 1.0) < kNear && check.unexplained < kUnlike;
  if (check.unexplained >= kUnlike) {
    check.fault =
        "the gyroscope's turns have nothing to do with those of the images: is it of another clock "
        "or recording?";
  } else if (check.is_degrees) {
    check.fault = "turning rates are degrees a second, expected rad/s";
  } else if (std::abs(check.scale - 1.0) > kNear) {
    check.fault = "the gyroscope turns " + Text(check.scale) +
                  " times as far as the images, expected the same (rad/s)";
  } else if (angle > kMounted) {
    check.fault = "the gyroscope is mounted " + Text(angle / kDegree) +
                  " degrees differently from what the calibration says";
  }
  return check;
}

}  // namespace gluevo::vo
