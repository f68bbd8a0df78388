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

// scores[key / kBlock][query][key % kBlock] for keys [key_begin, key_end), a multiple of kVectors *
// kLanes of them, and the largest score so far of every query and lane, if wanted. A tile takes all
// its keys in turn: with the few channels of a head, one panel of keys is little work.
template <int kVectors, typename Element>
HWY_NOINLINE void ScoresPanels(const Attention<Element>& p, const Element* HWY_RESTRICT q,
                               int64_t rows, int64_t key_begin, int64_t key_end,
                               float* HWY_RESTRICT scores, float* HWY_RESTRICT largest,
                               bool fetch) {
  const Tag d;
  const int64_t k_block_stride = p.head_blocks * kBlock * kBlock;
  Ahead<Element> ahead;
  if (fetch) {
    ahead = PanelAhead<kVectors>(p.k + key_end / kBlock * k_block_stride, rows);
  }
  ForBalancedTiles(0, rows, [&]<int kRows>(int64_t row) HWY_ATTR {
    for (int64_t key = key_begin; key < key_end; key += kVectors * kLanes) {
      const Element* const k = p.k + key / kBlock * k_block_stride + key % kBlock;
      Tile<kRows, kVectors> tile;
      InitTile(tile, nullptr);
      AccumulateBlocks(tile, q + row * kBlock, p.q_block_stride, p.head_blocks, k, k_block_stride,
                       ahead);
      HWY_UNROLL(16)
      for (int r = 0; r < kRows; ++r) {
        HWY_UNROLL(16)
        for (int v = 0; v < kVectors; ++v) {
          const int64_t at = key + v * kLanes;
          hn::Store(tile.v[r][v], d,
                    scores + at / kBlock * rows * kBlock + (row + r) * kBlock + at % kBlock);
        }
      }
      if (largest == nullptr) {
        continue;
      }
      HWY_UNROLL(16)
      for (int r = 0; r < kRows; ++r) {
        Vector most = hn::Load(d, largest + (row + r) * kBlock);
        HWY_UNROLL(16)
        for (int v = 0; v < kVectors; ++v) {
          most = hn::Max(most, tile.v[r][v]);
        }
        hn::Store(most, d, largest + (row + r) * kBlock);
      }
    }
  });
}

// All scores of `rows` queries and their largest lanes; padding keys score the smallest of numbers.
template <typename Element>
HWY_NOINLINE void Scores(const Attention<Element>& p, const Element* HWY_RESTRICT q, int64_t rows,
                         float* HWY_RESTRICT scores, float* HWY_RESTRICT largest, bool fetch) {
  const Tag d;
  constexpr int64_t kPanel = kTileVectors * kLanes;
  // Keys that pass through the first-level cache at a time.
  constexpr int64_t kKeys = std::max<int64_t>(64, kPanel);
  const int64_t padded_keys = BlocksOf(p.keys) * kBlock;
  const int64_t panels_end = padded_keys / kPanel * kPanel;
  const int64_t unpadded_end = p.keys / kPanel * kPanel;
  std::fill_n(largest, rows * kBlock, hwy::LowestValue<float>());
  for (int64_t key = 0; key < unpadded_end; key += kKeys) {
    ScoresPanels<kTileVectors>(p, q, rows, key, std::min(key + kKeys, unpadded_end), scores,
                               largest, fetch);
  }
  ScoresPanels<kTileVectors>(p, q, rows, unpadded_end, panels_end, scores, nullptr, false);
  ScoresPanels<1>(p, q, rows, panels_end, padded_keys, scores, nullptr, false);
  for (int64_t block = unpadded_end / kBlock; block < padded_keys / kBlock; ++block) {
    const int64_t keys = std::min<int64_t>(kBlock, p.keys - block * kBlock);
    for (int64_t row = 0; row < rows; ++row) {
      float* const values = scores + (block * rows + row) * kBlock;
      std::fill(values + keys, values + kBlock, hwy::LowestValue<float>());
      Vector most = hn::Load(d, largest + row * kBlock);
      for (int lane = 0; lane < kBlock; lane += kLanes) {
        most = hn::Max(most, hn::Load(d, values + lane));
      }
      hn::Store(most, d, largest + row * kBlock);
    }
  }
}

// Replaces scores by exp(score - largest), as elements of a left operand, and gives 1 over their
// sums. By blocks of keys, in the order in which the scores lie in memory.
template <typename Element>
HWY_NOINLINE void Exponentials(float* HWY_RESTRICT scores, int64_t rows, int64_t keys,
                               float* HWY_RESTRICT largest, float* HWY_RESTRICT inverse_sums,
                               Ahead<Element> ahead) {
  const Tag d;
  const int64_t blocks = BlocksOf(keys);
  alignas(64) float sums[kAttentionRows * kBlock];
  for (int64_t row = 0; row < rows; ++row) {
    float* const lanes = largest + row * kBlock;
    hn::Store(hn::MaxOfLanes(d, hn::Load(d, lanes)), d, lanes);
    hn::Store(hn::Zero(d), d, sums + row * kBlock);
  }
  // An element of a pair takes half the room of the scores that it replaces, so that what is
  // written was read before.
  constexpr int64_t kPerBlock = kChannelsPer<Element>;
  for (int64_t block = 0; block < blocks; ++block) {
    const float* const from = scores + block * rows * kBlock;
    Element* const to = reinterpret_cast<Element*>(scores + block / kPerBlock * rows * kBlock);
    const int first = static_cast<int>(block % kPerBlock) * kBlock;
    Fetch(ahead);
    for (int64_t row = 0; row < rows; ++row) {
      const Vector most = hn::Load(d, largest + row * kBlock);
      Vector sum = hn::Load(d, sums + row * kBlock);
      HWY_UNROLL(4)
      for (int lane = 0; lane < kBlock; lane += kLanes) {
        const Vector e = Exp(hn::Sub(hn::Load(d, from + row * kBlock + lane), most));
        sum = hn::Add(sum, e);
        StoreChannels(e, to + row * kBlock, first + lane);
      }
      hn::Store(sum, d, sums + row * kBlock);
    }
  }
  if (blocks % kPerBlock != 0) {
    Element* const to = reinterpret_cast<Element*>(scores + blocks / kPerBlock * rows * kBlock);
    for (int64_t row = 0; row < rows; ++row) {
      for (int lane = 0; lane < kBlock; lane += kLanes) {
        StoreChannels(hn::Zero(d), to + row * kBlock, kBlock + lane);
      }
    }
  }
  for (int64_t row = 0; row < rows; ++row) {
    inverse_sums[row] = 1.0F / hn::GetLane(hn::SumOfLanes(d, hn::Load(d, sums + row * kBlock)));
  }
}

// Channels [channel, channel + kVectors * kLanes) of the sums of values.
template <int kVectors, typename Element>
HWY_NOINLINE void ValuesPanel(const Attention<Element>& p, const Element* HWY_RESTRICT weights,
                              const float* HWY_RESTRICT inverse_sums, int64_t rows, int64_t channel,
                              Element* HWY_RESTRICT out, bool fetch) {
  const Tag d;
  constexpr int64_t kOutBlock = kChannelsPer<Element> * kBlock;
  const Element* const v = p.v + channel / kBlock * p.v_block_stride + channel % kBlock;
  constexpr int64_t kPanelBlocks = (kVectors * kLanes + kBlock - 1) / kBlock;
  Ahead<Element> ahead;
  if (fetch) {
    ahead = PanelAhead<kVectors>(v + kPanelBlocks * p.v_block_stride, rows);
  }
  ForBalancedTiles(0, rows, [&]<int kRows>(int64_t row) HWY_ATTR {
    Tile<kRows, kVectors> tile;
    InitTile(tile, nullptr);
    AccumulateBlocks(tile, weights + row * kBlock, rows * kBlock, ElementBlocks<Element>(p.keys), v,
                     p.v_block_stride, ahead);
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
  const int64_t channels = p.head_blocks * kBlock * kChannelsPer<Element>;
  const int64_t parts = (p.queries + kAttentionRows - 1) / kAttentionRows;
  for (int64_t part = 0; part < parts; ++part) {
    const int64_t begin = p.queries * part / parts;
    const int64_t rows = p.queries * (part + 1) / parts - begin;
    const Element* const q = p.q + begin * kBlock;
    alignas(64) float largest[kAttentionRows * kBlock];
    // The others find keys and values close.
    const bool fetch = part == 0;
    Scores(p, q, rows, p.scratch, largest, fetch);
    float inverse_sums[kAttentionRows];
    Exponentials<Element>(p.scratch, rows, p.keys, largest, inverse_sums,
                          {p.v, fetch ? kBlock / kChannelsPer<Element> : 0});
    const auto* const weights = reinterpret_cast<const Element*>(p.scratch);
    for (int64_t channel = 0; channel < channels; channel += kTileVectors * kLanes) {
      if (channel + kTileVectors * kLanes <= channels) {
        ValuesPanel<kTileVectors>(p, weights, inverse_sums, rows, channel, p.out + begin * kBlock,
                                  fetch);
      } else {
        for (int64_t c = channel; c < channels; c += kLanes) {
          ValuesPanel<1>(p, weights, inverse_sums, rows, c, p.out + begin * kBlock, fetch);
        }
      }
    }
  }
}

}  // namespace gluevo::nn::kernels::GLUEVO_SET_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif  // per-target include guard
