#pragma once

#include "gluevo/nn/weights.h"
#include "gluevo/weights_tools/architecture.h"

namespace gluevo::weights_tools {

/// As ReadArchitecture, of weights that hold a LightGlue and of those that hold an ALIKED.
LightGlueArchitecture ReadLightGlue(const nn::Weights& weights);
AlikedArchitecture ReadAliked(const nn::Weights& weights);

}  // namespace gluevo::weights_tools
