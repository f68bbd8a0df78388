#pragma once

#include <cstddef>
#include <optional>
#include <vector>

// What image files say beside their pixels, and what decoders don't complain of.
namespace gluevo::vo {

using ImageBytes = std::vector<unsigned char>;

/// Whether a JPEG file has no end: decoders fill the missing rest with gray and call it read.
bool IsCutOffJpeg(const ImageBytes& bytes);

/// Where the orientation of an image is stored, and what it is (1 to 8).
struct OrientationTag {
  std::size_t offset = 0;  ///< Of the value's two bytes.
  bool little_endian = true;
  int value = 1;
};

/// The orientation in the EXIF data of a JPEG, PNG or WebP file, or in a TIFF file's tags.
std::optional<OrientationTag> FindOrientation(const ImageBytes& bytes);

/// Whether the head of a file (its first 4096 bytes) says, or leaves open, that a value has more
/// than eight bits.
bool MayHaveMoreThanEightBits(const ImageBytes& head);

}  // namespace gluevo::vo
