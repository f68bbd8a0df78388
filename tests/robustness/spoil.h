#pragma once

#include <array>
#include <string>
#include <vector>

#include "gluevo/vo/core/stereo_frame.h"

// Images as they come out of a camera that does not work.
namespace gluevo::robustness {

enum class Fault {
  kBlack,    // Every pixel 0.
  kDark,     // As behind a closed shutter: next to 0, with sensor noise.
  kWhite,    // Every pixel 255.
  kNoise,    // Uniform over 0 to 255: what a torn cable gives.
  kBlurred,  // By a Gaussian of 12 pixels: the lens out of focus.
  kCovered,  // A hand in front of it: gray, with a gradient and sensor noise.
  kHalfCovered,
  kTorn,    // The lower half is shifted by 60 pixels.
  kFrozen,  // The image before, again.
};

// Frames first, ..., first + count - 1 are spoiled.
struct Case {
  std::string name;
  Fault fault = Fault::kBlack;
  int first = 0;
  int count = 1;
  std::array<bool, 2> cameras = {true, true};
  // Whether nothing can be seen in these frames, so that their poses must be predicted.
  bool shows_nothing = true;
};

// The same for the same input on every machine.
std::vector<vo::StereoFrame> Spoil(std::vector<vo::StereoFrame> frames, const Case& spoiled);

inline bool IsSpoiled(const Case& spoiled, std::size_t frame) {
  const int index = static_cast<int>(frame);
  return index >= spoiled.first && index < spoiled.first + spoiled.count;
}

}  // namespace gluevo::robustness
