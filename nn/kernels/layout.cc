#include <algorithm>

#include "kernels/bf16.h"
#include "kernels/kernels.h"

namespace gluevo::nn::kernels {

void ClearHalo(const BlockedMap& map) {
  for (int64_t block = 0; block < map.blocks; ++block) {
    std::fill_n(map.pixel(block, -1, -1), map.row_stride(), 0.0F);
    std::fill_n(map.pixel(block, map.height, -1), map.row_stride(), 0.0F);
    for (int64_t y = 0; y < map.height; ++y) {
      std::fill_n(map.pixel(block, y, -1), kBlock, 0.0F);
      std::fill_n(map.pixel(block, y, map.width), kBlock, 0.0F);
    }
  }
}

int64_t PackedConv3x3Floats(int64_t out_channels, int64_t in_channels) {
  const int64_t in_padded = in_channels == 1 ? 1 : BlocksOf(in_channels) * kBlock;
  return BlocksOf(out_channels) * kBlock * in_padded * 9;
}

void PackConv3x3(const float* weights, int64_t out_channels, int64_t in_channels, float* packed) {
  const int64_t in_block_width = in_channels == 1 ? 1 : kBlock;
  for (int64_t out_block = 0; out_block < BlocksOf(out_channels); ++out_block) {
    for (int64_t in_begin = 0; in_begin < in_channels; in_begin += in_block_width) {
      for (int64_t tap = 0; tap < 9; ++tap) {
        for (int64_t in = in_begin; in < in_begin + in_block_width; ++in) {
          for (int64_t out = out_block * kBlock; out < (out_block + 1) * kBlock; ++out) {
            *packed++ = out < out_channels && in < in_channels
                            ? weights[(out * in_channels + in) * 9 + tap]
                            : 0.0F;
          }
        }
      }
    }
  }
}

namespace {

void StoreFeature(float value, float* element, int64_t /*feature*/) { *element = value; }
void StoreFeature(float value, Bf16Pair* element, int64_t feature) {
  (feature % 2 == 0 ? element->low : element->high) = ToBf16(value);
}

}  // namespace

template <typename Element>
void PackMatrix(const float* weights, int64_t stride, int64_t out_features, int64_t in_features,
                Element* packed) {
  constexpr int64_t kChannels = kChannelsPer<Element>;
  const int64_t depth = ElementBlocks<Element>(in_features) * kBlock;
  std::fill_n(packed, PackedMatrixSize<Element>(out_features, in_features), Element{});
  for (int64_t out = 0; out < out_features; ++out) {
    for (int64_t in = 0; in < in_features; ++in) {
      Element* const element =
          packed + (out / kBlock * depth + in / kChannels) * kBlock + out % kBlock;
      StoreFeature(weights[out * stride + in], element, in);
    }
  }
}

template <typename Element>
void PackRows(const Element* rows, int64_t block_stride, int64_t blocks, int64_t count,
              Element* packed) {
  for (int64_t first = 0; first < count; first += kBlock) {
    const int64_t here = std::min<int64_t>(kBlock, count - first);
    for (int64_t block = 0; block < blocks; ++block, packed += kBlock * kBlock) {
      const Element* const from = rows + block * block_stride + first * kBlock;
      if (here == kBlock) {
        for (int i = 0; i < kBlock; ++i) {
          for (int row = 0; row < kBlock; ++row) {
            packed[i * kBlock + row] = from[row * kBlock + i];
          }
        }
      } else {
        for (int i = 0; i < kBlock; ++i) {
          for (int row = 0; row < kBlock; ++row) {
            packed[i * kBlock + row] = row < here ? from[row * kBlock + i] : Element{};
          }
        }
      }
    }
  }
}

void PackValues(const Bf16Pair* rows, int64_t block_stride, int64_t blocks, int64_t count,
                Bf16Pair* packed, int64_t packed_block_stride) {
  for (int64_t block = 0; block < blocks; ++block) {
    for (int64_t pair = 0; pair < (count + 1) / 2; ++pair) {
      const Bf16Pair* const row0 = rows + block * block_stride + 2 * pair * kBlock;
      const Bf16Pair* const row1 = row0 + kBlock;
      const bool both = 2 * pair + 1 < count;
      for (int half = 0; half < 2; ++half) {
        Bf16Pair* const to = packed + (2 * block + half) * packed_block_stride + pair * kBlock;
        for (int i = 0; i < kBlock / 2; ++i) {
          const Bf16Pair a = row0[half * kBlock / 2 + i];
          const Bf16Pair b = both ? row1[half * kBlock / 2 + i] : Bf16Pair{};
          to[2 * i] = {a.low, b.low};
          to[2 * i + 1] = {a.high, b.high};
        }
      }
    }
  }
}

template void PackMatrix(const float*, int64_t, int64_t, int64_t, float*);
template void PackMatrix(const float*, int64_t, int64_t, int64_t, Bf16Pair*);
template void PackRows(const float*, int64_t, int64_t, int64_t, float*);
template void PackRows(const Bf16Pair*, int64_t, int64_t, int64_t, Bf16Pair*);

}  // namespace gluevo::nn::kernels
