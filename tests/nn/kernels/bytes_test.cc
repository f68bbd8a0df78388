#include <gtest/gtest.h>

#include <cstdint>
#include <random>
#include <vector>

#include "kernels/kernels.h"
#include "nn/kernels/kernel_test.h"

namespace gluevo::nn::kernels {
namespace {

std::vector<int8_t> RandomBytes(int64_t size, int smallest, int largest) {
  static std::mt19937 generator(3);
  std::uniform_int_distribution<int> uniform(smallest, largest);
  std::vector<int8_t> bytes(static_cast<std::size_t>(size));
  for (int8_t& byte : bytes) {
    byte = static_cast<int8_t>(uniform(generator));
  }
  return bytes;
}

std::vector<int32_t> Products(const Kernels& kernels, const std::vector<int8_t>& a,
                              const std::vector<int8_t>& b) {
  const std::size_t rows = b.size() / a.size();
  std::vector<int32_t> out(rows + 1, -1);  // The last one is not written.
  kernels.byte_products({.a = a.data(),
                         .b = b.data(),
                         .size = static_cast<int64_t>(a.size()),
                         .rows = static_cast<int64_t>(rows),
                         .out = out.data()});
  return out;
}

TEST(ByteProductsTest, AreTheReferencesToTheLastBit) {
  for (const int64_t size : {kByteBlock, 2 * kByteBlock, 3 * kByteBlock, int64_t{2048}}) {
    for (const int64_t rows : {0, 1, 2, 7}) {
      const std::vector<int8_t> a = RandomBytes(size, -127, 127);
      const std::vector<int8_t> b = RandomBytes(rows * size, -127, 127);
      const std::vector<int32_t> expected = Products(ReferenceKernels(), a, b);
      EXPECT_EQ(expected.back(), -1);
      for (const Kernels* const kernels : AllSets()) {
        EXPECT_EQ(Products(*kernels, a, b), expected)
            << IsaName(kernels->isa) << " " << rows << " x " << size;
      }
    }
  }
}

TEST(ByteProductsTest, OfTheLargestSizeAndValuesDoNotOverflow) {
  for (const int sign : {-1, 1}) {
    const std::vector<int8_t> a = RandomBytes(kMaxBytes, 127, 127);
    const std::vector<int8_t> b = RandomBytes(2 * kMaxBytes, sign * 127, sign * 127);
    const int64_t expected = sign * 127 * 127 * kMaxBytes;
    std::vector<const Kernels*> sets = AllSets();
    sets.push_back(&ReferenceKernels());
    for (const Kernels* const kernels : sets) {
      EXPECT_EQ(Products(*kernels, a, b)[1], expected) << IsaName(kernels->isa);
    }
  }
}

}  // namespace
}  // namespace gluevo::nn::kernels
