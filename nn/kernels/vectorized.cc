// The fast kernels, compiled once for each instruction set by Highway's foreach_target.

#include "kernels/vectorized.h"

#include <chrono>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "kernels/vectorized.cc"
#include <hwy/foreach_target.h>
// The per-target headers come after foreach_target, which includes this file once more a target.
#include "kernels/conv3x3-inl.h"
#include "kernels/matmul-inl.h"
#include "kernels/softmax-inl.h"
#include "kernels/tile-inl.h"
#include "kernels/winograd-inl.h"

HWY_BEFORE_NAMESPACE();
namespace gluevo::nn::kernels::HWY_NAMESPACE {

double FastPeakFlops(double seconds) {
  const Tag d;
  Tile<kTileRows, kTileVectors> tile;
  InitTile(tile, nullptr);
  const Vector a = hn::Set(d, 0.999F);
  const Vector b = hn::Set(d, 0.001F);
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
          tile.v[r][v] = hn::MulAdd(tile.v[r][v], a, b);
        }
      }
    }
    count += 2.0 * kRepeats * kTileRows * kTileVectors * kLanes;
    elapsed = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  }
  // The values stay between 0 and 1; their use keeps the loop.
  Vector sum = hn::Zero(d);
  for (int r = 0; r < kTileRows; ++r) {
    for (int v = 0; v < kTileVectors; ++v) {
      sum = hn::Add(sum, tile.v[r][v]);
    }
  }
  return hn::GetLane(sum) < 1e9F ? count / elapsed : 0.0;
}

const Kernels& Table() {
#if HWY_TARGET <= HWY_AVX3
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
      .matmul = FastMatMul,
      .attention = FastAttention,
      .detector_softmax = FastDetectorSoftmax,
      .sinkhorn_rows = FastSinkhornRows,
      .peak_flops = FastPeakFlops,
  };
  return kKernels;
}

}  // namespace gluevo::nn::kernels::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace gluevo::nn::kernels {

std::vector<const Kernels*> VectorizedKernels() {
  const int64_t supported = hwy::SupportedTargets();
  std::vector<const Kernels*> tables;
  const auto add_if_supported = [&](int64_t target, const Kernels& table) {
    if ((supported & target) != 0) {
      tables.push_back(&table);
    }
  };
#if HWY_ARCH_X86
  // On the few x86 CPUs without SSE4 the portable kernels are scalar ones.
  if ((supported & HWY_SSE4) == 0) {
    tables.push_back(&N_SCALAR::Table());
  }
  add_if_supported(HWY_SSE4, N_SSE4::Table());
  add_if_supported(HWY_AVX2, N_AVX2::Table());
  add_if_supported(HWY_AVX3, N_AVX3::Table());
#else
  add_if_supported(HWY_STATIC_TARGET, HWY_STATIC_DISPATCH(Table)());
#endif
  return tables;
}

const Kernels& ScalarKernels() {
#if HWY_TARGETS & HWY_SCALAR
  return N_SCALAR::Table();
#else
  return HWY_STATIC_DISPATCH(Table)();
#endif
}

}  // namespace gluevo::nn::kernels
#endif  // HWY_ONCE
