#include <algorithm>

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

int64_t PackedMatrixFloats(int64_t out_features, int64_t in_features) {
  return BlocksOf(out_features) * kBlock * in_features;
}

void PackMatrix(const float* weights, int64_t stride, int64_t out_features, int64_t in_features,
                float* packed) {
  for (int64_t block = 0; block < BlocksOf(out_features); ++block) {
    for (int64_t in = 0; in < in_features; ++in) {
      for (int64_t out = block * kBlock; out < (block + 1) * kBlock; ++out) {
        *packed++ = out < out_features ? weights[out * stride + in] : 0.0F;
      }
    }
  }
}

}  // namespace gluevo::nn::kernels
