// The register tile that convolution, matrix product and attention share: kTileRows rows (pixels,
// tokens or queries) by kTileVectors vectors of output channels, accumulated in registers.

#if defined(GLUEVO_NN_KERNELS_TILE_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef GLUEVO_NN_KERNELS_TILE_INL_H_
#undef GLUEVO_NN_KERNELS_TILE_INL_H_
#else
#define GLUEVO_NN_KERNELS_TILE_INL_H_
#endif

#include <hwy/highway.h>

#include <type_traits>

#include "kernels/kernels.h"

HWY_BEFORE_NAMESPACE();
namespace gluevo::nn::kernels::GLUEVO_SET_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

using Tag = hn::CappedTag<float, kBlock>;
using Vector = hn::Vec<Tag>;
inline constexpr int kLanes = static_cast<int>(hn::MaxLanes(Tag()));

// As many accumulators as the register file holds beside the weights and one broadcast: 32
// registers with AVX-512 and NEON, 16 with SSE and AVX2.
#if HWY_TARGET <= HWY_AVX3
inline constexpr int kTileRows = 14;
inline constexpr int kTileVectors = 2;
#elif HWY_TARGET == HWY_NEON
inline constexpr int kTileRows = 6;
inline constexpr int kTileVectors = 4;
#elif HWY_TARGET == HWY_SCALAR
inline constexpr int kTileRows = 2;
inline constexpr int kTileVectors = 4;
#else
inline constexpr int kTileRows = 6;
inline constexpr int kTileVectors = 2;
#endif

// Steps of depth without a loop's own instructions in between. Where a processor core runs two
// threads, they share what it takes up in a cycle, and a step in a loop of its own takes so much
// that the multiply-adds wait: beside a busy other thread 75 % of the peak instead of 85.
template <typename Element>
inline constexpr int kTileSteps = std::is_same_v<Element, float> && (HWY_TARGET == HWY_AVX2)
                                      ? kBlock
                                      : 1;

template <int kRows, int kVectors>
struct Tile {
  // Not left to the compiler, which g++ then compiles without the instruction set.
  HWY_INLINE Tile() {}
  Vector v[kRows][kVectors];
};

// A packed operand stores blocks of kBlock columns `block_stride` floats apart; this is where
// vector v of a tile that starts at a block (or inside one) lies.
HWY_INLINE int64_t VectorOffset(int v, int64_t block_stride) {
  const int lane = v * kLanes;
  return lane / kBlock * block_stride + lane % kBlock;
}

template <int kRows, int kVectors>
HWY_INLINE void InitTile(Tile<kRows, kVectors>& tile, const float* HWY_RESTRICT bias) {
  const Tag d;
  HWY_UNROLL(16)
  for (int v = 0; v < kVectors; ++v) {
    const Vector value = bias != nullptr ? hn::Load(d, bias + v * kLanes) : hn::Zero(d);
    HWY_UNROLL(16)
    for (int r = 0; r < kRows; ++r) {
      tile.v[r][v] = value;
    }
  }
}

// An element of a left operand in all lanes, and vectors of elements of a right one.
HWY_INLINE Vector BroadcastElement(const float* a) { return hn::Set(Tag(), *a); }
HWY_INLINE Vector LoadElements(const float* b) { return hn::Load(Tag(), b); }
HWY_INLINE Vector Dot(Vector a, Vector b, Vector sum) {
#if HWY_TARGET == HWY_AVX2
  // g++ 12 would let sums move from register to register, of which there are none to spare, and
  // spill some as soon as two steps of depth stand in one body.
  asm("vfmadd231ps %2, %1, %0" : "+x"(sum.raw) : "x"(a.raw), "x"(b.raw));
  return sum;
#else
  return hn::MulAdd(a, b, sum);
#endif
}

using PairTag = hn::RebindToUnsigned<Tag>;
using PairVector = hn::Vec<PairTag>;
HWY_INLINE PairVector BroadcastElement(const Bf16Pair* a) {
  uint32_t bits;
  hwy::CopyBytes<sizeof(bits)>(a, &bits);
  return hn::Set(PairTag(), bits);
}
HWY_INLINE PairVector LoadElements(const Bf16Pair* b) {
  return hn::Load(PairTag(), reinterpret_cast<const uint32_t*>(b));
}
#if GLUEVO_SET_HAS_BF16
HWY_INLINE Vector Dot(PairVector a, PairVector b, Vector sum) {
  return Vector{_mm512_dpbf16_ps(sum.raw, reinterpret_cast<__m512bh>(a.raw),
                                 reinterpret_cast<__m512bh>(b.raw))};
}
#else
HWY_INLINE Vector Dot(PairVector a, PairVector b, Vector sum) {
  const Tag d;
  const PairVector upper = hn::Set(PairTag(), 0xFFFF0000U);
  const Vector low =
      hn::MulAdd(hn::BitCast(d, hn::ShiftLeft<16>(a)), hn::BitCast(d, hn::ShiftLeft<16>(b)), sum);
  return hn::MulAdd(hn::BitCast(d, hn::And(a, upper)), hn::BitCast(d, hn::And(b, upper)), low);
}
#endif

// Stores a vector of channels that starts at channel `lane` of a row of a block, as floats or
// rounded to the nearest bf16 (ties to even).
HWY_INLINE void StoreChannels(Vector v, float* row, int lane) { hn::Store(v, Tag(), row + lane); }
HWY_INLINE void StoreChannels(Vector v, Bf16Pair* row, int lane) {
  uint16_t* const to = reinterpret_cast<uint16_t*>(row) + lane;
#if GLUEVO_SET_HAS_BF16
  _mm256_store_si256(reinterpret_cast<__m256i*>(to),
                     reinterpret_cast<__m256i>(_mm512_cvtneps_pbh(v.raw)));
#else
  const Tag d;
  const PairTag du;
  const PairVector bits = hn::BitCast(du, v);
  const PairVector odd = hn::And(hn::ShiftRight<16>(bits), hn::Set(du, 1U));
  const PairVector rounded = hn::Add(bits, hn::Add(odd, hn::Set(du, 0x7FFFU)));
  const hn::Rebind<hwy::bfloat16_t, Tag> d_bf16;
  const hn::Rebind<uint16_t, Tag> d_u16;
  hn::StoreU(hn::BitCast(d_u16, hn::DemoteTo(d_bf16, hn::BitCast(d, rounded))), d_u16, to);
#endif
}

// tile += a b for one step of depth: a[r * a_stride] is broadcast, kVectors vectors of b loaded.
template <int kRows, int kVectors, typename Element>
HWY_INLINE void AccumulateStep(Tile<kRows, kVectors>& tile, const Element* HWY_RESTRICT a,
                               int64_t a_stride, const Element* HWY_RESTRICT b,
                               int64_t b_block_stride) {
  decltype(LoadElements(b)) w[kVectors];
  HWY_UNROLL(16)
  for (int v = 0; v < kVectors; ++v) {
    w[v] = LoadElements(b + VectorOffset(v, b_block_stride));
  }
  HWY_UNROLL(16)
  for (int r = 0; r < kRows; ++r) {
    const auto x = BroadcastElement(a + r * a_stride);
    HWY_UNROLL(16)
    for (int v = 0; v < kVectors; ++v) {
      tile.v[r][v] = Dot(x, w[v], tile.v[r][v]);
    }
  }
}

// Part of a right operand that is wanted next and meanwhile fetched into the second-level cache: so
// many cache lines for every block of depth of every tile. Fetching never fails, so it may run over
// the operand's end.
template <typename Element>
struct Ahead {
  const Element* next = nullptr;
  int lines = 0;
};

template <typename Element>
HWY_INLINE void Fetch(Ahead<Element>& ahead) {
  for (int i = 0; i < ahead.lines; ++i, ahead.next += kBlock) {
    __builtin_prefetch(ahead.next, 0, 2);
  }
}

// The panel of kVectors vectors at `next`, as deep as the one that tiles over so many rows share
// meanwhile.
template <int kVectors, typename Element>
HWY_INLINE Ahead<Element> PanelAhead(const Element* next, int64_t rows) {
  constexpr int64_t kLinesDeep = (kVectors * kLanes + kBlock - 1) / kBlock * kBlock;
  const int64_t tiles = (rows + kTileRows - 1) / kTileRows;
  return {next, static_cast<int>((kLinesDeep + tiles - 1) / tiles)};
}

// tile += a b for a left operand of `blocks` blocks, [block][row][kBlock], and the rows of b that
// belong to it, kBlock elements apart.
template <int kRows, int kVectors, typename Element>
HWY_INLINE void AccumulateBlocks(Tile<kRows, kVectors>& tile, const Element* HWY_RESTRICT a,
                                 int64_t a_block_stride, int64_t blocks,
                                 const Element* HWY_RESTRICT b, int64_t b_block_stride,
                                 Ahead<Element>& ahead) {
  constexpr int kSteps = kTileSteps<Element>;
  Ahead<Element> still_ahead = ahead;  // In registers, not where the caller's is.
  for (int64_t block = 0; block < blocks; ++block, a += a_block_stride) {
    Fetch(still_ahead);
    for (int k = 0; k < kBlock; k += kSteps, b += kSteps * kBlock) {
      HWY_UNROLL(16)
      for (int i = 0; i < kSteps; ++i) {
        AccumulateStep(tile, a + k + i, kBlock, b + i * kBlock, b_block_stride);
      }
    }
  }
  ahead = still_ahead;
}

template <int kRows, int kVectors, typename Element>
HWY_INLINE void AccumulateBlocks(Tile<kRows, kVectors>& tile, const Element* HWY_RESTRICT a,
                                 int64_t a_block_stride, int64_t blocks,
                                 const Element* HWY_RESTRICT b, int64_t b_block_stride) {
  Ahead<Element> nothing;
  AccumulateBlocks(tile, a, a_block_stride, blocks, b, b_block_stride, nothing);
}

// Row after row.
template <int kRows, int kVectors>
HWY_INLINE void StoreTile(const Tile<kRows, kVectors>& tile, float* HWY_RESTRICT to) {
  HWY_UNROLL(16)
  for (int r = 0; r < kRows; ++r) {
    HWY_UNROLL(16)
    for (int v = 0; v < kVectors; ++v) {
      hn::Store(tile.v[r][v], Tag(), to + (r * kVectors + v) * kLanes);
    }
  }
}

template <int kRows, int kVectors>
HWY_INLINE void Relu(Tile<kRows, kVectors>& tile) {
  const Vector zero = hn::Zero(Tag());
  HWY_UNROLL(16)
  for (int r = 0; r < kRows; ++r) {
    HWY_UNROLL(16)
    for (int v = 0; v < kVectors; ++v) {
      tile.v[r][v] = hn::Max(tile.v[r][v], zero);
    }
  }
}

template <int kRows, int kVectors>
HWY_INLINE void ScaleAndShift(Tile<kRows, kVectors>& tile, const float* HWY_RESTRICT scale,
                              const float* HWY_RESTRICT shift) {
  const Tag d;
  for (int v = 0; v < kVectors; ++v) {
    const Vector factor = hn::Load(d, scale + v * kLanes);
    const Vector offset = hn::Load(d, shift + v * kLanes);
    HWY_UNROLL(16)
    for (int r = 0; r < kRows; ++r) {
      tile.v[r][v] = hn::MulAdd(tile.v[r][v], factor, offset);
    }
  }
}

template <int kMost, typename F>
HWY_INLINE void CallWithRows(int64_t rows, int64_t begin, const F& f) {
  if (rows == kMost) {
    f.template operator()<kMost>(begin);
  } else if constexpr (kMost > 1) {
    CallWithRows<kMost - 1>(rows, begin, f);
  }
}

// Calls f.template operator()<rows>(row) for the fewest tiles that cover [begin, end), all of about
// the same height: a tile of a few rows waits for its multiply-adds. Its divisions are of 32 bits,
// for it may be called for every few hundred cycles of work.
template <typename F>
HWY_INLINE void ForBalancedTiles(int64_t begin, int64_t end, const F& f) {
  const auto count = static_cast<uint32_t>(end - begin);
  const uint32_t parts = (count + kTileRows - 1) / kTileRows;
  if (parts == 0) {
    return;
  }
  const uint32_t height = count / parts;
  const uint32_t taller = count % parts;
  int64_t row = begin;
  for (uint32_t part = 0; part < parts; ++part) {
    const uint32_t rows = height + (part < taller ? 1 : 0);
    CallWithRows<kTileRows>(rows, row, f);
    row += rows;
  }
}

}  // namespace gluevo::nn::kernels::GLUEVO_SET_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif  // per-target include guard
