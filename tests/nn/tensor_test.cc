#include "gluevo/nn/tensor.h"

#include <gtest/gtest.h>

#include <cstdint>

namespace gluevo::nn {
namespace {

TEST(ShapeTest, SizeIsTheProductOfTheExtents) {
  EXPECT_EQ((Shape{2, 3, 4}.size()), 24);
  EXPECT_EQ(Shape{}.size(), 1);
  EXPECT_EQ((Shape{5, 0}.size()), 0);
}

TEST(ShapeTest, RefusesNegativeOverflowingAndTooManyExtents) {
  EXPECT_THROW((Shape{-1}), Error);
  EXPECT_THROW((Shape{int64_t{1} << 40, int64_t{1} << 40}), Error);
  EXPECT_THROW((Shape{0, int64_t{1} << 40, int64_t{1} << 40}), Error);
  EXPECT_THROW((Shape{1, 1, 1, 1, 1}), Error);
}

TEST(ShapeTest, MismatchNamesBothShapes) {
  try {
    CheckShape(Shape{2, 3}, Shape{3, 2}, "conv1a.weight");
    FAIL();
  } catch (const Error& error) {
    EXPECT_STREQ(error.what(), "conv1a.weight has shape [2 x 3], expected [3 x 2]");
  }
}

TEST(TensorTest, IsAlignedZeroedAndRowMajor) {
  for (const int64_t columns : {1, 3, 17}) {
    Tensor<float> tensor(Shape{2, columns});
    EXPECT_EQ(reinterpret_cast<std::uintptr_t>(tensor.data()) % kAlignment, 0U);
    EXPECT_EQ(tensor.Matrix().cwiseAbs().maxCoeff(), 0.0F);
    tensor.Matrix()(1, columns - 1) = 5.0F;
    EXPECT_EQ(tensor[tensor.size() - 1], 5.0F);
  }
}

TEST(TensorTest, CopiesAreDeepAndMovesKeepTheElements) {
  Tensor<float> a(Shape{3});
  a[1] = 2.0F;
  Tensor<float> b = a;
  a[1] = 7.0F;
  EXPECT_EQ(b[1], 2.0F);
  const Tensor<float> c = std::move(b);
  EXPECT_EQ(c[1], 2.0F);
  EXPECT_EQ(c.shape(), Shape{3});
}

TEST(TensorTest, ReshapeKeepsElementsAndRefusesAnotherSize) {
  Tensor<float> tensor(Shape{2, 3, 4});
  EXPECT_EQ(tensor.Matrix().rows(), 6);
  EXPECT_EQ(tensor.view().Reshaped({4, 6}).Matrix().rows(), 4);
  EXPECT_THROW(tensor.view().Reshaped({5, 5}), Error);
}

}  // namespace
}  // namespace gluevo::nn
