#include "distortion_model.h"

#include <algorithm>
#include <cstddef>
#include <limits>

namespace gluevo::vo {
namespace {

// In the order of Distortion.
constexpr const DistortionModel* kModels[] = {
    &kNoDistortion, &kRadialTangentialModel, &kEquidistantModel,     &kRationalModel,
    &kMeiModel,     &kDoubleSphereModel,     &kExtendedUnifiedModel, &kFieldOfViewModel};

}  // namespace

const DistortionModel& ModelOf(Distortion distortion) {
  return *kModels[static_cast<std::size_t>(distortion)];
}

std::string_view NameOf(Distortion distortion) { return ModelOf(distortion).name; }

std::vector<std::string_view> CoefficientNames(Distortion distortion) {
  std::vector<std::string_view> names;
  std::string_view rest = ModelOf(distortion).coefficients;
  while (!rest.empty()) {
    const std::size_t end = std::min(rest.find(' '), rest.size());
    names.push_back(rest.substr(0, end));
    rest.remove_prefix(std::min(end + 1, rest.size()));
  }
  return names;
}

Eigen::Vector2d NoPoint() {
  return Eigen::Vector2d::Constant(std::numeric_limits<double>::quiet_NaN());
}

Distorted ScaledAlongRadius(const Eigen::Vector2d& p, double scale, double slope) {
  return {scale * p, scale * Eigen::Matrix2d::Identity() + slope * p * p.transpose()};
}

Eigen::Vector2d CheckedInverse(DistortFunction distort, const DistortionCoefficients& coefficients,
                               const Eigen::Vector2d& target, const Eigen::Vector2d& candidate) {
  // Near 90 degrees to the side rounding is large on the plane, but not on the image.
  constexpr double kAccepted = 1e-9;
  if (!candidate.allFinite()) {
    return NoPoint();
  }
  const double error = (distort(coefficients, candidate).point - target).norm();
  return error <= kAccepted * (1.0 + target.norm()) ? candidate : NoPoint();
}

Distorted WithTangentialPart(const Eigen::Vector2d& p, double scale, double slope, double p1,
                             double p2) {
  const double x = p.x();
  const double y = p.y();
  const double r2 = x * x + y * y;
  Distorted result;
  result.point << x * scale + 2.0 * p1 * x * y + p2 * (r2 + 2.0 * x * x),
      y * scale + p1 * (r2 + 2.0 * y * y) + 2.0 * p2 * x * y;
  const double mixed = slope * x * y + 2.0 * p1 * x + 2.0 * p2 * y;
  result.jacobian << scale + slope * x * x + 2.0 * p1 * y + 6.0 * p2 * x, mixed, mixed,
      scale + slope * y * y + 6.0 * p1 * y + 2.0 * p2 * x;
  return result;
}

}  // namespace gluevo::vo
