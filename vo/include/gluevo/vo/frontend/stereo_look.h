#pragma once

#include <array>
#include <opencv2/core/mat.hpp>

#include "gluevo/vo/core/stereo_frame.h"
#include "gluevo/vo/geometry/stereo_rig.h"

namespace gluevo::vo {

/// What a stereo pair shows by itself, seen with corners and optical flow alone: whatever front end
/// fails on it, this tells images, calibration and time apart.
struct StereoLook {
  std::array<double, 2> brightness = {};  ///< Mean of each image, gray levels 0 to 255.
  std::array<double, 2> contrast = {};    ///< Standard deviation, gray levels.
  std::array<int, 2> corners = {};        ///< Of each image; at most 200 are looked for.
  bool is_same = false;                   ///< Both images are equal, pixel for pixel.
  /// The left image's corners that are found in the right image.
  int found = 0;
  /// Of these, as the calibration allows: near the epipolar line, in front of both cameras.
  int fit = 0;
  /// The same if the two images were exchanged.
  int fit_exchanged = 0;
  /// The same if the transform between the cameras were its inverse.
  int fit_inverted = 0;
  /// Corners of the left image before, and those found in this one. 0 of 0 where there is none.
  int before = 0;
  int followed = 0;
};

/// `left_before`: the left image of the frame before; may be empty. Throws Error as CheckImages
/// does.
StereoLook LookAt(const StereoFrame& frame, const StereoRig& rig, const cv::Mat& left_before);

}  // namespace gluevo::vo
