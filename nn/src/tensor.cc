#include "gluevo/nn/tensor.h"

#include <algorithm>

namespace gluevo::nn {

Shape::Shape(const int64_t* extents, std::size_t rank) {
  if (rank > kMaxRank) {
    throw Error("a tensor of rank " + std::to_string(rank) + ": at most rank " +
                std::to_string(kMaxRank) + " is supported");
  }
  rank_ = static_cast<int>(rank);
  int64_t span = 1;  // The size without extents of zero, so that no product of extents overflows.
  for (int axis = 0; axis < rank_; ++axis) {
    extents_[axis] = extents[axis];
    // Half of the range is left so that a size in bytes of any element type cannot overflow.
    constexpr int64_t kLargest = int64_t{1} << 58;
    if (extents[axis] < 0 || (extents[axis] > 0 && span > kLargest / extents[axis])) {
      throw Error("a tensor's extent " + std::to_string(extents[axis]) +
                  " is negative or makes its size overflow");
    }
    size_ *= extents[axis];
    span *= std::max<int64_t>(extents[axis], 1);
  }
}

std::string Shape::ToString() const {
  std::string text = "[";
  for (int axis = 0; axis < rank_; ++axis) {
    text += (axis > 0 ? " x " : "") + std::to_string(extents_[axis]);
  }
  return text + "]";
}

void CheckShape(const Shape& actual, const Shape& expected, const std::string& what) {
  if (actual != expected) {
    throw Error(what + " has shape " + actual.ToString() + ", expected " + expected.ToString());
  }
}

}  // namespace gluevo::nn
