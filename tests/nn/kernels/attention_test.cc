#include <gtest/gtest.h>

#include <cmath>

#include "kernels/kernels.h"
#include "nn/kernels/kernel_test.h"

namespace gluevo::nn::kernels {
namespace {

TEST(AttentionTest, AgreesWithTheReference) {
  for (const int64_t keys : {1, 2, 15, 16, 17, 70, 300}) {
    for (const int64_t head_dim : {4, 8, 20, 64}) {
      SCOPED_TRACE(testing::Message() << keys << " keys of " << head_dim);
      constexpr int64_t kQueries = 37;
      const int64_t value_size = BlocksOf(head_dim) * kBlock;
      const int64_t stride = head_dim + 5;
      const Tensor<float> q = Random(kQueries * stride);
      const Tensor<float> k = Random(keys * head_dim, -2.0F, 2.0F);
      Tensor<float> packed(Shape{PackedMatrixFloats(keys, head_dim)});
      PackMatrix(k.data(), head_dim, keys, head_dim, packed.data());
      Tensor<float> v = Random(keys * value_size);
      const auto run = [&](const Kernels& kernels) {
        Tensor<float> out = Filled(kQueries * stride, kGuard);
        Tensor<float> scratch(Shape{AttentionScratchFloats(keys)});
        Attention p{.q = q.data(),
                    .q_stride = stride,
                    .k_packed = packed.data(),
                    .v = v.data(),
                    .keys = keys,
                    .head_dim = head_dim,
                    .out = out.data(),
                    .out_stride = stride,
                    .row_begin = 1,
                    .row_end = kQueries,
                    .scratch = scratch.data()};
        kernels.attention(p);
        return out;
      };
      const Tensor<float> expected = run(ReferenceKernels());
      // A score errs by gamma_d sum |q k| <= gamma_d 2 d, as does its distance from the largest;
      // hn::Exp is documented to 1 unit in the last place; then a sum of `keys` weights and one of
      // `keys` products of weights and values below 1.
      const double score_error = 2.0 * Gamma(head_dim + 1) * 2.0 * head_dim;
      const double bound = 2.0 * (score_error + 2.0 * kUnit) + 2.0 * Gamma(keys + 3);
      for (const Kernels* const kernels : AllSets()) {
        const Tensor<float> out = run(*kernels);
        for (int64_t i = 0; i < out.size(); ++i) {
          const bool written = i >= stride && i % stride < head_dim;
          ASSERT_LE(std::abs(out[i] - expected[i]), written ? bound : 0.0)
              << IsaName(kernels->isa) << " " << i;
        }
      }
    }
  }
}

}  // namespace
}  // namespace gluevo::nn::kernels
