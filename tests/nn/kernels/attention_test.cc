#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "gluevo/nn/elements.h"
#include "kernels/bf16.h"
#include "kernels/kernels.h"
#include "nn/kernels/kernel_test.h"

namespace gluevo::nn::kernels {
namespace {

void Set(float& element, int64_t /*part*/, float value) { element = value; }
void Set(Bf16Pair& element, int64_t part, float value) {
  (part % 2 == 0 ? element.low : element.high) = ToBf16(value);
}
double Get(float element, int64_t /*part*/) { return element; }
double Get(Bf16Pair element, int64_t part) {
  return Bfloat16ToFloat(part % 2 == 0 ? element.low : element.high);
}

template <typename Element>
void Check(int64_t keys, int64_t blocks, int64_t queries) {
  constexpr int64_t kPer = kChannelsPer<Element>;
  const int64_t channels = blocks * kBlock * kPer;
  SCOPED_TRACE(testing::Message() << keys << " keys of " << channels << ", " << queries
                                  << " queries, " << (kPer == 1 ? "float" : "bf16"));
  const auto random = [&](int64_t size, float range) {
    Tensor<Element> tensor(Shape{size});
    const Tensor<float> values = Random(size * kPer, -range, range);
    for (int64_t i = 0; i < size * kPer; ++i) {
      Set(tensor[i / kPer], i, values[i]);
    }
    return tensor;
  };
  const int64_t key_elements = ElementBlocks<Element>(keys) * kBlock;
  const Tensor<Element> q = random(blocks * queries * kBlock, 1.0F);
  const Tensor<Element> k_rows = random(blocks * keys * kBlock, 2.0F);
  Tensor<Element> k(Shape{BlocksOf(keys) * blocks * kBlock * kBlock});
  PackRows(k_rows.data(), keys * kBlock, blocks, keys, k.data());
  Tensor<Element> v(Shape{channels / kBlock * key_elements * kBlock});
  for (int64_t channel = 0; channel < channels; ++channel) {
    const Tensor<float> values = Random(keys);
    for (int64_t key = 0; key < keys; ++key) {
      Set(v[(channel / kBlock * key_elements + key / kPer) * kBlock + channel % kBlock], key,
          values[key]);
    }
  }
  const auto run = [&](const Kernels& kernels) {
    Tensor<Element> out(Shape{blocks * queries * kBlock});
    Tensor<float> scratch = Filled(AttentionScratchFloats(keys), kGuard);
    Attend<Element>(kernels, {.q = q.data(),
                              .q_block_stride = queries * kBlock,
                              .head_blocks = blocks,
                              .k = k.data(),
                              .v = v.data(),
                              .v_block_stride = key_elements * kBlock,
                              .keys = keys,
                              .out = out.data(),
                              .out_block_stride = queries * kBlock,
                              .queries = queries,
                              .scratch = scratch.data()});
    return out;
  };
  const Tensor<Element> expected = run(ReferenceKernels());
  // A score errs by gamma_d sum |q k| <= gamma_d 2 d, as does its distance from the largest; the
  // exponential by kExpError; then a sum of `keys` weights and one of `keys` products of weights
  // and values below 1. In bf16 each weight is rounded to 8 bits, and so are both results.
  const double score_error = 2.0 * Gamma(2 * channels + 1) * 2.0 * static_cast<double>(channels);
  double bound = 2.0 * (score_error + kExpError) + 2.0 * Gamma(2 * keys + 3);
  if (kPer == 2) {
    bound += 0x1p-9 + 2.0 * 0x1p-9;
  }
  for (const Kernels* const kernels : AllSets()) {
    const Tensor<Element> out = run(*kernels);
    for (int64_t i = 0; i < out.size(); ++i) {
      for (int64_t part = 0; part < kPer; ++part) {
        ASSERT_LE(std::abs(Get(out[i], part) - Get(expected[i], part)), bound)
            << IsaName(kernels->isa) << " " << i;
      }
    }
  }
}

TEST(AttentionTest, AgreesWithTheReference) {
  for (const int64_t keys : {1, 2, 15, 16, 17, 31, 33, 70, 300}) {
    for (const int64_t blocks : {1, 2, 4}) {
      Check<float>(keys, blocks, 37);
      Check<Bf16Pair>(keys, blocks, 37);
    }
  }
  for (const int64_t queries : {1, 5, 14, 28, 29}) {
    Check<float>(20, 4, queries);
    Check<Bf16Pair>(20, 2, queries);
  }
}

// The reference itself: with equal scores the result is the mean of the values.
TEST(AttentionTest, EqualScoresGiveTheMean) {
  constexpr int64_t kKeys = 3;
  const Tensor<float> q(Shape{kBlock});
  const Tensor<float> k(Shape{kBlock * kBlock});
  Tensor<float> v(Shape{kBlock * kBlock});
  for (int64_t key = 0; key < kKeys; ++key) {
    v[key * kBlock + 5] = static_cast<float>(key + 1);
  }
  Tensor<float> out(Shape{kBlock});
  Tensor<float> scratch(Shape{AttentionScratchFloats(kKeys)});
  ReferenceKernels().attention({.q = q.data(),
                                .q_block_stride = kBlock,
                                .head_blocks = 1,
                                .k = k.data(),
                                .v = v.data(),
                                .v_block_stride = kBlock * kBlock,
                                .keys = kKeys,
                                .out = out.data(),
                                .out_block_stride = kBlock,
                                .queries = 1,
                                .scratch = scratch.data()});
  EXPECT_FLOAT_EQ(out[5], 2.0F);
  EXPECT_FLOAT_EQ(out[4], 0.0F);
}

}  // namespace
}  // namespace gluevo::nn::kernels
