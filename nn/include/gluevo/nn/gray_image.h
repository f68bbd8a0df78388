#pragma once

#include <cstddef>
#include <cstdint>

namespace gluevo::nn {

/// A gray image that somebody else owns, 8 bits a pixel.
struct GrayImage {
  const uint8_t* data = nullptr;
  int width = 0;              ///< Pixels.
  int height = 0;             ///< Pixels.
  std::ptrdiff_t stride = 0;  ///< Bytes from one row to the next.
};

}  // namespace gluevo::nn
