#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "stamp_unit.h"

// What the names of the images of two cameras say: when each was taken, or which number it has.
namespace gluevo::vo {

/// An image and what it pairs by.
struct KeyedImage {
  int64_t key = 0;
  std::filesystem::path path;
};

enum class KeyKind {
  kStamps,   ///< Keys are times, nanoseconds.
  kNumbers,  ///< Keys are numbers of images.
  kNames,    ///< Names have neither in common: keys are their places in the order of all names.
};

struct ImageNames {
  KeyKind kind = KeyKind::kNames;
  /// Of each camera, in the order of keys, and of names where keys are the same.
  std::array<std::vector<KeyedImage>, 2> images;
  /// Images that are named unlike most others of their camera: not of the sequence.
  std::vector<std::filesystem::path> others;
  /// How the times are written, where it is not nanoseconds or decimal seconds: "microseconds".
  std::string unit;
};

/// Names are prefixes, numbers and suffixes ("left_000012", "000012_r", "1403715273262142976",
/// "1403715273.262143", "1403715273_262142976"): one number goes up from image to image, all else
/// is the same for all images of a camera (and need not be for both). Throws Error for stamps that
/// are beyond 292 years, and where the two cameras are not named in the same way.
ImageNames ReadImageNames(const std::array<std::vector<std::filesystem::path>, 2>& images);

/// Which camera a name belongs to by a word in it (left, right, l, r, cam0, cam1, camera0,
/// camera1): 0 or 1, nothing where there is none. `rest` becomes the name without that word.
std::optional<std::size_t> SideOfName(const std::string& name, std::string& rest);

}  // namespace gluevo::vo
