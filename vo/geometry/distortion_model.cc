#include "distortion_model.h"

#include <cstddef>
#include <limits>

namespace gluevo::vo {
namespace {

// In the order of Distortion.
constexpr const DistortionModel* kModels[] = {&kNoDistortion, &kRadialTangentialModel,
                                              &kEquidistantModel};

}  // namespace

const DistortionModel& ModelOf(Distortion distortion) {
  return *kModels[static_cast<std::size_t>(distortion)];
}

Eigen::Vector2d NoPoint() {
  return Eigen::Vector2d::Constant(std::numeric_limits<double>::quiet_NaN());
}

}  // namespace gluevo::vo
