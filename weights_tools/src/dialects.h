#pragma once

#include "gluevo/nn/weights.h"

namespace gluevo::weights_tools {

/// Second stage of a conversion: from the names and shapes of the file's maker to the canonical
/// ones. Dialects: the published names, 1x1 convolutions of a SuperGlue also as matrices [O x I]
/// and its dustbin score also as a vector of one. What no dialect knows stays as it is, for the
/// architecture's check to name.
nn::Weights ToCanonical(nn::Weights weights);

}  // namespace gluevo::weights_tools
