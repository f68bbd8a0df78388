#include "gluevo/vo/geometry/stereo_rig.h"

#include <cmath>

#include "gluevo/nn/error.h"
#include "gluevo/vo/core/angle.h"
#include "gluevo/vo/core/text.h"

namespace gluevo::vo {
namespace {

// Metres. Endoscopes have some millimetres.
constexpr double kShortestBaseline = 1e-3;
constexpr double kLongestBaseline = 10.0;

std::string Text(double value, int digits = 4) { return ShortText(value, digits); }

// Of a number that is too large for metres: rigs have 5 cm to 1 m, hand-held ones 30 cm at most.
std::string UnitOfBaseline(double baseline) {
  constexpr double kShortInMillimetres = 30.0;
  constexpr double kLongInCentimetres = 100.0;
  return baseline <= kLongestBaseline || baseline > kLongInCentimetres ? "millimetres"
         : baseline < kShortInMillimetres                              ? "centimetres"
                                          : "centimetres or millimetres";
}

/// Whether the right camera is much more beside the left one than above, below, before or behind.
bool IsBeside(const Eigen::Vector3d& right_in_left) {
  return std::abs(right_in_left.x()) > right_in_left.tail<2>().norm();
}

void AddCameraOddities(const Camera& camera, const std::string& side,
                       std::vector<std::string>& oddities) {
  const std::string size = std::to_string(camera.width) + " x " + std::to_string(camera.height);
  const Eigen::Vector2d focal = camera.CentralFocal();
  constexpr double kSmallestFocal = 0.1;  // Of the width: a fisheye lens of 220 degrees has 0.26.
  constexpr double kLargestFocal = 20.0;  // 3 degrees.
  if (focal.x() < kSmallestFocal * camera.width || focal.x() > kLargestFocal * camera.width) {
    oddities.push_back("the " + side + " camera's focal length of " + Text(focal.x()) +
                       " px is unusual for images of " + size +
                       ": are the intrinsics of this size, and in the order fx fy cx cy?");
  }
  constexpr double kUnequal = 1.2;
  if (const double ratio = focal.x() / focal.y(); ratio > kUnequal || ratio < 1.0 / kUnequal) {
    oddities.push_back("the " + side + " camera's fx of " + Text(focal.x()) + " and fy of " +
                       Text(focal.y()) + " px differ: are they in the order fx fy cx cy?");
  }
  constexpr double kFarFromMiddle = 0.25;
  if (std::abs(camera.cx / camera.width - 0.5) > kFarFromMiddle ||
      std::abs(camera.cy / camera.height - 0.5) > kFarFromMiddle) {
    oddities.push_back("the " + side + " camera's principal point (" + Text(camera.cx) + ", " +
                       Text(camera.cy) + ") is far from the middle of images of " + size +
                       ": are they of the size that was calibrated?");
  }
}

void AddPoseOddities(const StereoRig& rig, std::vector<std::string>& oddities) {
  const Eigen::Vector3d right_in_left = rig.RightInLeft();
  constexpr double kLongBaseline = 2.0;
  if (rig.baseline() > kLongBaseline) {
    oddities.push_back("the baseline of " + Text(rig.baseline()) +
                       " m is unusually long: are lengths in metres, not in centimetres?");
  }
  if (!IsBeside(right_in_left)) {
    oddities.push_back("the right camera is at (" + Text(right_in_left.x()) + ", " +
                       Text(right_in_left.y()) + ", " + Text(right_in_left.z()) +
                       ") m from the left one (right, down, forward): if the two are side by side, "
                       "a transform is inverted or of other frames");
  }
  const double degrees =
      std::acos(std::min(1.0, (rig.right_from_left().rotation * Eigen::Vector3d::UnitZ()).z())) /
      kDegree;
  constexpr double kLargeAngle = 45.0;
  if (degrees > kLargeAngle) {
    oddities.push_back("the cameras look in directions " + Text(degrees, 3) +
                       " degrees apart: a transform may be inverted or of other frames");
  }
}

}  // namespace

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
  if (baseline() > kLongestBaseline || baseline() < kShortestBaseline) {
    throw Error(
        what + ": a baseline of " + Text(baseline()) +
        " m between the cameras, expected 0.001 to 10: lengths are in metres, are these in " +
        UnitOfBaseline(baseline()) + "?");
  }
  const Eigen::Vector3d right_in_left = RightInLeft();
  if (right_in_left.x() < 0.0 && IsBeside(right_in_left)) {
    throw Error(what + ": the right camera is " + Text(-right_in_left.x()) +
                " m to the left of the left one: either the transform between them is inverted "
                "(expected from left to right), or the cameras are exchanged");
  }
}

std::vector<std::string> StereoRig::Oddities() const {
  std::vector<std::string> oddities;
  AddCameraOddities(cameras[0], "left", oddities);
  AddCameraOddities(cameras[1], "right", oddities);
  constexpr double kUnequal = 1.5;
  const double ratio = cameras[0].CentralFocal().x() / cameras[1].CentralFocal().x();
  if (ratio > kUnequal || ratio < 1.0 / kUnequal) {
    oddities.push_back("the focal lengths of left and right, " +
                       Text(cameras[0].CentralFocal().x()) + " and " +
                       Text(cameras[1].CentralFocal().x()) + " px, hardly belong to one rig");
  }
  AddPoseOddities(*this, oddities);
  return oddities;
}

}  // namespace gluevo::vo
