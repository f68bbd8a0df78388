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

}  // namespace gluevo::vo
