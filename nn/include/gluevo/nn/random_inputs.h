#pragma once

#include <cstdint>
#include <vector>

#include "gluevo/nn/features.h"

namespace gluevo::nn {

/// What networks are given where only their cost is of interest, which does not depend on the
/// values: always the same for the same arguments.

/// Noise of 8 bits, row by row.
std::vector<uint8_t> RandomPixels(int width, int height);

/// Features at random places of an image of that size, in no order of their scores, which are 0 to
/// 1, with random descriptors of unit length.
Features RandomFeatures(int keypoints, int descriptor_size, int width, int height, unsigned seed);

}  // namespace gluevo::nn
