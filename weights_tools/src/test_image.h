#pragma once

#include <cstdint>
#include <vector>

#include "gluevo/nn/features.h"

namespace gluevo::weights_tools {

/// Blocks of different gray levels, in some of them a brighter square, and a little noise: corners
/// for SuperPoint. The same on every machine.
struct TestImage {
  int width = 160;
  int height = 120;
  std::vector<uint8_t> pixels;  ///< Row by row.
};
TestImage MakeTestImage();

/// Points of an image of that size with descriptors of this size: the same `count` points twice,
/// the second time in another order, a few pixels away and with a little noise in their
/// descriptors.
struct TestFeatures {
  nn::Features first;
  nn::Features second;
};
TestFeatures MakeTestFeatures(int count, int64_t descriptor_size);

}  // namespace gluevo::weights_tools
