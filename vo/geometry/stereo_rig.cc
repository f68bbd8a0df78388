#include "gluevo/vo/geometry/stereo_rig.h"

#include "gluevo/nn/error.h"

namespace gluevo::vo {

void StereoRig::Validate(const std::string& what) const {
  cameras[0].Validate(what + ": left camera");
  cameras[1].Validate(what + ": right camera");
  for (const Rigid3& pose : body_from_cam) {
    if (!pose.rotation.coeffs().allFinite() || !pose.translation.allFinite()) {
      throw Error(what + ": the pose of a camera is not finite");
    }
  }
  // Stereo needs a baseline; a micrometre is none.
  constexpr double kNoBaseline = 1e-6;
  if (!(baseline() > kNoBaseline)) {
    throw Error(what + ": both cameras are in the same place, expected a baseline between them");
  }
}

}  // namespace gluevo::vo
