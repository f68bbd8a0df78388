#pragma once

#include <optional>
#include <string>

#include "gluevo/nn/weights.h"

namespace gluevo::weights_tools {

/// A SuperGlue under the published names, and the dialect that it came in.
struct TranslatedSuperGlue {
  nn::Weights weights;
  std::string dialect;
};

/// Renames the tensors of a SuperGlue. Dialects: "magic-leap", the published names; and
/// "hugging-face", SuperGlueForKeypointMatching of transformers, whose channels of queries, keys
/// and values lie head after head (channel = head * size + d), where the published ones lie
/// dimension after dimension (d * heads + head): rows of the projections and columns of the merging
/// matrix are permuted.
///
/// 1x1 convolutions may be matrices [O x I], and the dustbin score a vector of one. Where the file
/// has no batch norm at all, as exports that folded them, ones that change nothing are added.
/// `epsilon` is that of all batch norms, where the file tells and else 1e-5. Nothing where no
/// dialect knows the names. Throws Error, naming the tensor, where one lacks or does not fit.
std::optional<TranslatedSuperGlue> TranslateSuperGlue(nn::Weights weights, int64_t heads,
                                                      std::optional<double> epsilon);

}  // namespace gluevo::weights_tools
