#pragma once

#include "dialects.h"
#include "gluevo/nn/weights.h"

namespace gluevo::weights_tools {

/// Renames the tensors of a LightGlue. Dialects: "lightglue", the published names; and
/// "lightglue-flat", those of its first release, `self_attn.0.Wqkv` for
/// `transformers.0.self_attn.Wqkv` and so on, whose unused scalars `log_assignment.0.r` are
/// dropped. Throws Error, naming the tensor, where a name comes in both.
CanonicalNetwork TranslateLightGlue(nn::Weights weights);

}  // namespace gluevo::weights_tools
