#pragma once

#include "gluevo/nn/tensor.h"
#include "gluevo/nn/workspace.h"
#include "kernels/kernels.h"

namespace gluevo::nn {

/// Optimal transport between n0 and n1 keypoints with a dustbin each (SuperGlue, section 3.3), by
/// Sinkhorn's iterations in the log domain. In: scores [(n0 + 1) x stride] of which the first
/// n1 + 1 columns count, dustbins last, stride a multiple of kernels::kBlock. Out: in the same
/// place the logarithm of the assignment, scaled so that a keypoint's mass is 1.
void LogOptimalTransport(TensorView<float> scores, int64_t n1, int iterations,
                         const kernels::Kernels& kernels, Workspace& workspace);

}  // namespace gluevo::nn
