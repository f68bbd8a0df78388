#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "containers.h"
#include "gluevo/nn/weights.h"

namespace gluevo::weights_tools {

/// One network under the canonical names and shapes.
struct CanonicalNetwork {
  nn::Weights weights;
  std::string dialect;
};

/// Second stage of a conversion: from the names and shapes of the file's maker to the canonical
/// ones, which are the published ones (see superpoint_dialects.h, superglue_dialects.h and
/// lightglue_dialects.h). What stands before a network's names inside a program ("module.", "net.",
/// "superpoint.", anything) is taken off first. `heads` is the number of attention heads of a
/// SuperGlue.
///
/// Returns at most one each of a SuperPoint, a SuperGlue, an ALIKED and a LightGlue, in this order.
/// What no dialect knows stays as it is, for the architecture's check to name. Throws Error where
/// there is no network at all.
std::vector<CanonicalNetwork> ToCanonical(Container container, int64_t heads);

}  // namespace gluevo::weights_tools
