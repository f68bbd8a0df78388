#pragma once

#include "kernels/aliked_kernels.h"
#include "kernels/kernels.h"
#include "kernels/token_kernels.h"

namespace gluevo::nn::kernels {

/// The kernels that only ALIKED and LightGlue use, of one instruction set. A table and a unit of
/// their own: those of Kernels take minutes to compile.
struct OpenKernels {
  Isa isa = Isa::kReference;
  void (*rotate)(const Rotation&) = nullptr;
  void (*norm_gelu)(const NormGelu&) = nullptr;
  void (*row_log_sums)(const RowLogSums&) = nullptr;
  void (*column_log_sums)(const ColumnLogSums&) = nullptr;
  void (*selu)(const Selu&) = nullptr;
  void (*average_pool)(const AveragePool&) = nullptr;
  void (*deformable_rows)(const DeformableRows&) = nullptr;
  void (*feature_rows)(const FeatureRows&) = nullptr;
  void (*score_row)(const ScoreRow&) = nullptr;
  void (*planar_conv3x3)(const PlanarConv3x3&) = nullptr;
};

/// Of the same instruction sets as KernelsFor; throws Error unless SupportedIsas() has it.
const OpenKernels& OpenKernelsFor(Isa isa);

/// Plain loops, sums in double: the specification.
const OpenKernels& ReferenceOpenKernels();
/// As ScalarKernels.
const OpenKernels& ScalarOpenKernels();

/// The parts of ReferenceOpenKernels that reference_aliked.cc has not got: LightGlue's.
void ReferenceRotate(const Rotation& p);
void ReferenceNormGelu(const NormGelu& p);
void ReferenceRowLogSums(const RowLogSums& p);
void ReferenceColumnLogSums(const ColumnLogSums& p);

}  // namespace gluevo::nn::kernels
