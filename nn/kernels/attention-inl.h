// Attention: two products around a softmax, for so few queries at a time that their scores stay in
// the second-level cache.

#if defined(GLUEVO_NN_KERNELS_ATTENTION_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef GLUEVO_NN_KERNELS_ATTENTION_INL_H_
#undef GLUEVO_NN_KERNELS_ATTENTION_INL_H_
#else
#define GLUEVO_NN_KERNELS_ATTENTION_INL_H_
#endif

#include <algorithm>

#include "kernels/exp-inl.h"
#include "kernels/tile-inl.h"

HWY_BEFORE_NAMESPACE();
namespace gluevo::nn::kernels::GLUEVO_SET_NAMESPACE {

// scores[key / kBlock][query][key % kBlock] for keys [key, key + kVectors * kLanes).
template <int kVectors, typename Element>
HWY_NOINLINE void ScoresPanel(const Attention<Element>& p, const Element* HWY_RESTRICT q,
                              int64_t rows, int64_t key, float* HWY_RESTRICT scores) {
  const Tag d;
  const int64_t k_block_stride = p.head_blocks * kBlock * kBlock;
  const Element* const k = p.k + key / kBlock * k_block_stride + key % kBlock;
  ForBalancedTiles(0, rows, [&]<int kRows>(int64_t row) HWY_ATTR {
    Tile<kRows, kVectors> tile;
    InitTile(tile, nullptr);
    AccumulateBlocks(tile, q + row * kBlock, p.q_block_stride, p.head_blocks, k, k_block_stride);
    HWY_UNROLL(16)
    for (int r = 0; r < kRows; ++r) {
      HWY_UNROLL(16)
      for (int v = 0; v < kVectors; ++v) {
        const int64_t at = key + v * kLanes;
        hn::Store(tile.v[r][v], d,
                  scores + at / kBlock * rows * kBlock + (row + r) * kBlock + at % kBlock);
      }
    }
  });
}

// Replaces a row of scores by exp(score - largest), as elements of a left operand; returns 1 over
// their sum. Padding keys get the smallest of numbers.
template <typename Element>
HWY_NOINLINE float ExponentialsOfRow(float* HWY_RESTRICT scores, int64_t row_stride, int64_t keys) {
  const Tag d;
  const int64_t blocks = BlocksOf(keys);
  for (int64_t key = keys; key < blocks * kBlock; ++key) {
    scores[key / kBlock * row_stride + key % kBlock] = hwy::LowestValue<float>();
  }
  Vector largest_lanes = hn::Load(d, scores);
  for (int64_t block = 0; block < blocks; ++block) {
    for (int lane = 0; lane < kBlock; lane += kLanes) {
      largest_lanes = hn::Max(largest_lanes, hn::Load(d, scores + block * row_stride + lane));
    }
  }
  const Vector largest = hn::MaxOfLanes(d, largest_lanes);
  Vector sum = hn::Zero(d);
  // An element of a pair takes half the room of the scores that it replaces, so that what is
  // written was read before.
  constexpr int64_t kPerBlock = kChannelsPer<Element>;
  for (int64_t block = 0; block < blocks; ++block) {
    Element* const to = reinterpret_cast<Element*>(scores + block / kPerBlock * row_stride);
    const int first = static_cast<int>(block % kPerBlock) * kBlock;
    for (int lane = 0; lane < kBlock; lane += kLanes) {
      const Vector e = Exp(hn::Sub(hn::Load(d, scores + block * row_stride + lane), largest));
      sum = hn::Add(sum, e);
      StoreChannels(e, to, first + lane);
    }
  }
  if (blocks % kPerBlock != 0) {
    Element* const to = reinterpret_cast<Element*>(scores + blocks / kPerBlock * row_stride);
    for (int lane = 0; lane < kBlock; lane += kLanes) {
      StoreChannels(hn::Zero(d), to, kBlock + lane);
    }
  }
  return 1.0F / hn::GetLane(hn::SumOfLanes(d, sum));
}

// Channels [channel, channel + kVectors * kLanes) of the sums of values.
template <int kVectors, typename Element>
HWY_NOINLINE void ValuesPanel(const Attention<Element>& p, const Element* HWY_RESTRICT weights,
                              const float* HWY_RESTRICT inverse_sums, int64_t rows, int64_t channel,
                              Element* HWY_RESTRICT out) {
  const Tag d;
  constexpr int64_t kOutBlock = kChannelsPer<Element> * kBlock;
  const Element* const v = p.v + channel / kBlock * p.v_block_stride + channel % kBlock;
  ForBalancedTiles(0, rows, [&]<int kRows>(int64_t row) HWY_ATTR {
    Tile<kRows, kVectors> tile;
    InitTile(tile, nullptr);
    AccumulateBlocks(tile, weights + row * kBlock, rows * kBlock, ElementBlocks<Element>(p.keys), v,
                     p.v_block_stride);
    HWY_UNROLL(16)
    for (int r = 0; r < kRows; ++r) {
      const Vector scale = hn::Set(d, inverse_sums[row + r]);
      HWY_UNROLL(16)
      for (int i = 0; i < kVectors; ++i) {
        const int64_t c = channel + i * kLanes;
        StoreChannels(hn::Mul(tile.v[r][i], scale),
                      out + c / kOutBlock * p.out_block_stride + (row + r) * kBlock,
                      static_cast<int>(c % kOutBlock));
      }
    }
  });
}

template <typename Element>
void FastAttention(const Attention<Element>& p) {
  const int64_t padded_keys = BlocksOf(p.keys) * kBlock;
  const int64_t channels = p.head_blocks * kBlock * kChannelsPer<Element>;
  const int64_t parts = (p.queries + kAttentionRows - 1) / kAttentionRows;
  for (int64_t part = 0; part < parts; ++part) {
    const int64_t begin = p.queries * part / parts;
    const int64_t rows = p.queries * (part + 1) / parts - begin;
    const Element* const q = p.q + begin * kBlock;
    int64_t key = 0;
    for (; key + kTileVectors * kLanes <= padded_keys; key += kTileVectors * kLanes) {
      ScoresPanel<kTileVectors>(p, q, rows, key, p.scratch);
    }
    for (; key < padded_keys; key += kLanes) {
      ScoresPanel<1>(p, q, rows, key, p.scratch);
    }
    float inverse_sums[kAttentionRows];
    for (int64_t row = 0; row < rows; ++row) {
      inverse_sums[row] =
          ExponentialsOfRow<Element>(p.scratch + row * kBlock, rows * kBlock, p.keys);
    }
    const auto* const weights = reinterpret_cast<const Element*>(p.scratch);
    for (int64_t channel = 0; channel < channels; channel += kTileVectors * kLanes) {
      if (channel + kTileVectors * kLanes <= channels) {
        ValuesPanel<kTileVectors>(p, weights, inverse_sums, rows, channel, p.out + begin * kBlock);
      } else {
        for (int64_t c = channel; c < channels; c += kLanes) {
          ValuesPanel<1>(p, weights, inverse_sums, rows, c, p.out + begin * kBlock);
        }
      }
    }
  }
}

}  // namespace gluevo::nn::kernels::GLUEVO_SET_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif  // per-target include guard
