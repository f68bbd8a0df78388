#pragma once

#include "image_bytes.h"

namespace gluevo::vo {

bool IsPng(const ImageBytes& bytes);

/// Of a PNG file what its decoder reads without a word, or nothing where it could not be decoded:
/// libpng tells standard error of each checksum (PNG specification 2003, 5.3) that is wrong, and a
/// program has one line for its user. Chunks that a decoder may do without are left out where they
/// are broken, as libpng does; a file whose pixels are, or that is cut off, gives nothing.
ImageBytes SoundPng(ImageBytes bytes);

}  // namespace gluevo::vo
