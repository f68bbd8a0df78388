// The table of ALIKED's and LightGlue's kernels of one instruction set.

#if defined(GLUEVO_NN_KERNELS_OPEN_TABLE_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef GLUEVO_NN_KERNELS_OPEN_TABLE_INL_H_
#undef GLUEVO_NN_KERNELS_OPEN_TABLE_INL_H_
#else
#define GLUEVO_NN_KERNELS_OPEN_TABLE_INL_H_
#endif

#include "kernels/aliked-inl.h"
#include "kernels/aliked_scores-inl.h"
#include "kernels/open_kernels.h"
#include "kernels/tokens-inl.h"

HWY_BEFORE_NAMESPACE();
namespace gluevo::nn::kernels::GLUEVO_SET_NAMESPACE {

const OpenKernels& OpenTable() {
#if HWY_TARGET <= HWY_AVX3
  constexpr Isa kIsa = Isa::kAvx512;
#elif HWY_TARGET == HWY_AVX2
  constexpr Isa kIsa = Isa::kAvx2;
#else
  constexpr Isa kIsa = Isa::kPortable;
#endif
  static constexpr OpenKernels kKernels = {
      .isa = kIsa,
      .rotate = FastRotate,
      .norm_gelu = FastNormGelu,
      .row_log_sums = FastRowLogSums,
      .column_log_sums = FastColumnLogSums,
      .selu = FastSelu,
      .average_pool = FastAveragePool,
      .deformable_rows = FastDeformableRows,
      .feature_rows = FastFeatureRows,
      .score_row = FastScoreRow,
      .planar_conv3x3 = FastPlanarConv3x3,
  };
  return kKernels;
}

}  // namespace gluevo::nn::kernels::GLUEVO_SET_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif  // per-target include guard
