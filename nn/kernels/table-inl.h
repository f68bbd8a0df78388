// The table of kernels of one instruction set.

#if defined(GLUEVO_NN_KERNELS_TABLE_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef GLUEVO_NN_KERNELS_TABLE_INL_H_
#undef GLUEVO_NN_KERNELS_TABLE_INL_H_
#else
#define GLUEVO_NN_KERNELS_TABLE_INL_H_
#endif

#include <algorithm>
#include <chrono>

#include "kernels/attention-inl.h"
#include "kernels/bytes-inl.h"
#include "kernels/conv3x3-inl.h"
#include "kernels/matmul-inl.h"
#include "kernels/sinkhorn-inl.h"
#include "kernels/softmax-inl.h"
#include "kernels/tile-inl.h"
#include "kernels/winograd-inl.h"

HWY_BEFORE_NAMESPACE();
namespace gluevo::nn::kernels::GLUEVO_SET_NAMESPACE {

// Multiply-adds on registers only, as many at once as the register tile has.
template <typename Element>
double FastPeakFlops(double seconds) {
  const Tag d;
  Tile<kTileRows, kTileVectors> tile;
  InitTile(tile, nullptr);
  // Of two floats, 2^-40 each: the sums stay small.
  alignas(64) uint32_t bits[kBlock];
  std::fill_n(bits, kBlock, 0x2B802B80U);
  const auto a = LoadElements(reinterpret_cast<const Element*>(bits));
  constexpr int kRepeats = 20000;
  double count = 0.0;
  double elapsed = 0.0;
  const auto start = std::chrono::steady_clock::now();
  while (elapsed < seconds) {
    for (int i = 0; i < kRepeats; ++i) {
      HWY_UNROLL(16)
      for (int r = 0; r < kTileRows; ++r) {
        HWY_UNROLL(16)
        for (int v = 0; v < kTileVectors; ++v) {
          tile.v[r][v] = Dot(a, a, tile.v[r][v]);
        }
      }
    }
    count += 2.0 * kRepeats * kTileRows * kTileVectors * kLanes * kChannelsPer<Element>;
    elapsed = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  }
  // Their use keeps the loop.
  Vector sum = hn::Zero(d);
  for (int r = 0; r < kTileRows; ++r) {
    for (int v = 0; v < kTileVectors; ++v) {
      sum = hn::Add(sum, tile.v[r][v]);
    }
  }
  return hn::GetLane(sum) < 1e9F ? count / elapsed : 0.0;
}

const Kernels& Table() {
#if GLUEVO_SET_HAS_BF16
  constexpr Isa kIsa = Isa::kAvx512Bf16;
#elif HWY_TARGET <= HWY_AVX3
  constexpr Isa kIsa = Isa::kAvx512;
#elif HWY_TARGET == HWY_AVX2
  constexpr Isa kIsa = Isa::kAvx2;
#else
  constexpr Isa kIsa = Isa::kPortable;
#endif
  static constexpr Kernels kKernels = {
      .isa = kIsa,
      .conv3x3 = FastConv3x3,
      .winograd3x3 = FastWinogradConv3x3,
      .matmul = FastMatMul<float>,
      .matmul_bf16 = FastMatMul<Bf16Pair>,
      .attention = FastAttention<float>,
      .attention_bf16 = FastAttention<Bf16Pair>,
      .detector_softmax = FastDetectorSoftmax,
      .sinkhorn_exponentials = FastSinkhornExponentials,
      .sinkhorn_rows = FastSinkhornRows,
      .byte_products = FastByteProducts,
      .peak_flops = FastPeakFlops<float>,
      .peak_flops_bf16 = FastPeakFlops<Bf16Pair>,
  };
  return kKernels;
}

}  // namespace gluevo::nn::kernels::GLUEVO_SET_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif  // per-target include guard
