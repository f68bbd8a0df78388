#include "gluevo/nn/arena.h"

#include <algorithm>
#include <numeric>

namespace gluevo::nn {

void Arena::Reset() {
  if (blocks_.size() > 1) {
    const std::size_t total = capacity();
    blocks_.clear();  // Before the new block, so that the peak is not the sum of both.
    blocks_.emplace_back(Shape{static_cast<int64_t>(total)});
  }
  used_in_last_ = 0;
}

std::size_t Arena::capacity() const {
  return std::accumulate(blocks_.begin(), blocks_.end(), std::size_t{0},
                         [](std::size_t sum, const Tensor<std::byte>& block) {
                           return sum + static_cast<std::size_t>(block.size());
                         });
}

void* Arena::AllocateBytes(std::size_t bytes) {
  bytes = (bytes + kAlignment - 1) / kAlignment * kAlignment;
  if (blocks_.empty() || used_in_last_ + bytes > static_cast<std::size_t>(blocks_.back().size())) {
    blocks_.emplace_back(Shape{static_cast<int64_t>(bytes)});
    used_in_last_ = 0;
  }
  void* const memory = blocks_.back().data() + used_in_last_;
  used_in_last_ += bytes;
  return memory;
}

}  // namespace gluevo::nn
