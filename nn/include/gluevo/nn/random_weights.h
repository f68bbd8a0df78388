#pragma once

#include "gluevo/nn/weights.h"

namespace gluevo::nn {

/// Networks of the published shapes with random weights, always the same, that keep activations of
/// the order of 1: for measuring, as what a network costs does not depend on the values.

/// Of SuperPoint: 64, 64, 128, 128 channels, heads of 256.
Weights RandomSuperPointWeights();

/// Of SuperGlue: descriptors of 256, 4 heads, `layers` instead of the published 18.
Weights RandomSuperGlueWeights(int layers = 18);

}  // namespace gluevo::nn
