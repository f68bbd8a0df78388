#pragma once

#include "gluevo/nn/tensor.h"
#include "gluevo/nn/workspace.h"
#include "kernels/kernels.h"

namespace gluevo::nn {

/// Optimal transport between n0 and n1 keypoints with a dustbin each (SuperGlue, section 3.3), by
/// Sinkhorn's iterations. In: scores [(n0 + 1) x stride] of which the first n1 + 1 columns count,
/// dustbins last, stride a multiple of kernels::kBlock. Out: in the same place the logarithm of the
/// assignment, scaled so that a keypoint's mass is 1.
///
/// Iterations scale rows and columns of exp(scores + u + v) by factors a and b (Cuturi 2013), two
/// multiply-adds an entry. Where factors leave [1e-6, 1e6], their logarithms go into u and v and
/// the exponentials are taken anew (Chizat et al. 2018, section 3.4), so nothing can overflow, and
/// what underflows is below 1e-22 of a keypoint's mass: the same as iterations in the log domain.
void LogOptimalTransport(TensorView<float> scores, int64_t n1, int iterations,
                         const kernels::Kernels& kernels, Workspace& workspace);

}  // namespace gluevo::nn
