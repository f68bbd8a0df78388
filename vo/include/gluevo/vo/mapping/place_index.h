#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <vector>

#include "gluevo/nn/byte_vectors.h"

namespace gluevo::vo {

/// Descriptors of places (PlaceCodebook::Describe), and which of them are most like another one.
class PlaceIndex {
 public:
  struct Similar {
    std::size_t place = 0;
    double similarity = 0.0;  ///< Cosine, -1 to 1.
  };

  std::size_t size() const { return places_.size(); }
  const Eigen::VectorXf& operator[](std::size_t i) const { return places_[i]; }

  /// Throws Error for values that are not finite or another size than the first one's.
  void Add(Eigen::VectorXf place);

  /// Of the first `among` places the `count` most similar ones, the most similar first and the
  /// oldest of equals, none less similar than `least`. All are looked at in a byte a value; what
  /// may be among the best by that is in two, and then as it is: the result is that of comparing
  /// all. Throws as Add does.
  std::vector<Similar> MostSimilar(const Eigen::VectorXf& place, std::size_t among,
                                   std::size_t count, double least = -2.0) const;

 private:
  std::vector<Eigen::VectorXf> places_;
  nn::ByteVectors rounded_;
};

}  // namespace gluevo::vo
