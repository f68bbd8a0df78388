#include "gluevo/nn/byte_vectors.h"

#include <gtest/gtest.h>

#include <limits>
#include <random>
#include <vector>

#include "gluevo/nn/error.h"

namespace gluevo::nn {
namespace {

// Of any length, some of them zero, some with one value that is larger than all others.
std::vector<Eigen::VectorXf> RandomVectors(int count, int size) {
  std::mt19937 random(5);
  std::normal_distribution<float> normal;
  std::vector<Eigen::VectorXf> vectors;
  for (int i = 0; i < count; ++i) {
    Eigen::VectorXf vector(size);
    for (float& value : vector) {
      value = normal(random);
    }
    vector *= i % 5 == 0 ? 0.0F : static_cast<float>(i % 7);
    if (i % 3 == 0) {
      vector[i % size] = -200.0F;
    }
    vectors.push_back(vector);
  }
  return vectors;
}

TEST(ByteVectorsTest, ProductsLieWithinTheirBoundsWhichAreNarrow) {
  for (const int size : {1, 63, 64, 1000}) {
    const std::vector<Eigen::VectorXf> vectors = RandomVectors(40, size);
    for (const Isa isa : SupportedIsas()) {
      ByteVectors bytes(isa);
      for (const Eigen::VectorXf& vector : vectors) {
        bytes.Add(vector);
      }
      ASSERT_EQ(bytes.size(), vectors.size());
      for (const Eigen::VectorXf& vector : vectors) {
        const ByteVectors::Rounded rounded = bytes.Round(vector);
        const std::vector<ByteVectors::Bounds> bounds = bytes.Products(rounded, vectors.size());
        ASSERT_EQ(bounds.size(), vectors.size());
        for (std::size_t i = 0; i < vectors.size(); ++i) {
          const float product = vector.dot(vectors[i]);
          const ByteVectors::Bounds fine = bytes.Product(rounded, i);
          for (const ByteVectors::Bounds& one : {bounds[i], fine}) {
            EXPECT_LE(one.lowest, product) << IsaName(isa) << " " << size;
            EXPECT_GE(one.highest, product) << IsaName(isa) << " " << size;
          }
          // Half a step of 1/127 of the largest value is left out of each value of the one; of both
          // by all bytes a hundredth of that.
          const float step = 0.5F / 127.0F * std::sqrt(static_cast<float>(size));
          const float lengths = vector.norm() * vectors[i].norm();
          const float largest = vectors[i].cwiseAbs().maxCoeff() * vector.norm() +
                                vector.cwiseAbs().maxCoeff() * vectors[i].norm();
          const float loss = 2.0F * 0x1p-24F * static_cast<float>(size + 8) * lengths;
          EXPECT_LE(bounds[i].highest - bounds[i].lowest,
                    2.1F * step * vectors[i].cwiseAbs().maxCoeff() * vector.norm() +
                        0.02F * step * largest + loss);
          EXPECT_LE(fine.highest - fine.lowest, 0.02F * step * largest +
                                                    2.1F * step * step *
                                                        vector.cwiseAbs().maxCoeff() *
                                                        vectors[i].cwiseAbs().maxCoeff() +
                                                    loss);
        }
      }
    }
  }
}

TEST(ByteVectorsTest, ComparesWithTheFirstOnesOnly) {
  ByteVectors bytes;
  const ByteVectors::Rounded ones = bytes.Round(Eigen::VectorXf::Ones(3));
  EXPECT_TRUE(bytes.Products(ones, 0).empty());
  bytes.Add(Eigen::VectorXf::Ones(3));
  bytes.Add(Eigen::VectorXf::Zero(3));
  EXPECT_EQ(bytes.Products(ones, 1).size(), 1U);
  EXPECT_NEAR(bytes.Products(ones, 2)[0].highest, 3.0F, 1e-4F);
  EXPECT_EQ(bytes.Products(ones, 2)[1].highest, 0.0F);
}

TEST(ByteVectorsTest, RefusesWhatItCannotCompare) {
  ByteVectors bytes;
  bytes.Add(Eigen::VectorXf::Ones(3));
  EXPECT_THROW(bytes.Add(Eigen::VectorXf::Ones(4)), Error);
  EXPECT_THROW(bytes.Round(Eigen::VectorXf::Ones(2)), Error);
  EXPECT_THROW(bytes.Add(Eigen::VectorXf::Constant(3, std::numeric_limits<float>::quiet_NaN())),
               Error);
  EXPECT_THROW(ByteVectors().Add(Eigen::VectorXf::Ones(200'000)), Error);
  EXPECT_EQ(bytes.size(), 1U);
}

}  // namespace
}  // namespace gluevo::nn
