#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "gluevo/nn/isa.h"

namespace gluevo::nn {

namespace kernels {
struct Kernels;
}

/// Vectors of one size, to compare one with thousands of others as fast as memory gives them: each
/// is a scale, a byte a value, and another byte for what the first one leaves out. A product by the
/// first bytes reads a quarter of the floats; where that is too coarse the second ones are there.
/// Both tell how wrong they may be.
class ByteVectors {
 public:
  /// A vector, rounded: scale * (coarse + fine / 254).
  struct Rounded {
    std::vector<int8_t> coarse, fine;  ///< Whole blocks, zeros in the padding.
    float scale = 0.0F;
    float length = 0.0F;        ///< Of the vector.
    float fine_length = 0.0F;   ///< Of what the coarse bytes leave out.
    float error = 0.0F;         ///< Of what both leave out.
    float product_loss = 0.0F;  ///< What floats may lose in an inner product, of both lengths'.
  };

  /// Where an inner product of two vectors lies for certain, as a sum of floats in whatever order.
  struct Bounds {
    float lowest = 0.0F;
    float highest = 0.0F;
  };

  /// Throws Error as ChooseIsa does.
  ByteVectors() : ByteVectors(ChooseIsa()) {}
  /// The results do not depend on the set. Throws Error where it is not supported here.
  explicit ByteVectors(Isa isa);

  std::size_t size() const { return vectors_.size(); }

  /// Throws Error for values that are not finite, another size than that of those that are there,
  /// and more than 133120 values.
  Rounded Round(const Eigen::VectorXf& vector) const;
  /// Throws as Round does.
  void Add(const Eigen::VectorXf& vector);

  /// Products, by the coarse bytes, of what Round has given with the first `count`.
  std::vector<Bounds> Products(const Rounded& vector, std::size_t count) const;
  /// The product with one of them by all bytes.
  Bounds Product(const Rounded& vector, std::size_t i) const;

 private:
  struct Stored {
    float scale = 0.0F;
    float length = 0.0F;
    float fine_length = 0.0F;
    float error = 0.0F;
  };

  void Multiply(const std::vector<int8_t>& a, const std::vector<int8_t>& b, std::size_t first,
                std::size_t count, int32_t* out) const;

  const kernels::Kernels* kernels_;
  Eigen::Index values_ = 0;            // Of a vector, once there is one.
  std::vector<int8_t> coarse_, fine_;  // As in Rounded, one after the other.
  std::vector<Stored> vectors_;
};

}  // namespace gluevo::nn
