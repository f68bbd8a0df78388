#pragma once

#include <array>
#include <cstdint>

#include "gluevo/nn/weights.h"

namespace gluevo::nn {

/// Networks of the published shapes with random weights, always the same, that keep activations of
/// the order of 1: for measuring, as what a network costs does not depend on the values.

/// Of SuperPoint: 64, 64, 128, 128 channels, heads of 256.
Weights RandomSuperPointWeights();

/// Of SuperGlue: descriptors of 256, 4 heads, `layers` instead of the published 18.
Weights RandomSuperGlueWeights(int layers = 18);

/// Of LightGlue: as published for ALIKED unless told otherwise. Layers are sure of few keypoints.
Weights RandomLightGlueWeights(int layers = 9, int64_t descriptor_size = 128, int64_t size = 256,
                               int64_t heads = 4);

/// Of ALIKED: n16 unless told otherwise; `size` of descriptors is a multiple of 64. Offsets of
/// deformable samples are of some pixels.
Weights RandomAlikedWeights(const std::array<int64_t, 4>& widths = {16, 32, 64, 128},
                            int64_t size = 128, int64_t samples = 16);

}  // namespace gluevo::nn
