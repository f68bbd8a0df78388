#include "gluevo/nn/arena.h"

#include <algorithm>

namespace gluevo::nn {
namespace {

// So that small tensors share a block in the first round, too.
constexpr std::size_t kLeastBlock = std::size_t{64} << 10;

}  // namespace

void Arena::Reset() {
  if (misfit_) {
    Join();
    return;
  }
  largest_round_ = std::max(largest_round_, round_);
  current_ = 0;
  used_in_current_ = 0;
  round_ = 0;
}

void Arena::Join() {
  misfit_ = false;
  Reset();
  if (blocks_.size() > 1) {
    blocks_.clear();  // Before the new block, so that the peak is not the sum of both.
    // An eighth more: a scene with more keypoints than any before is no reason to ask again.
    blocks_.emplace_back(largest_round_ + largest_round_ / 8);
  }
}

std::size_t Arena::capacity() const {
  std::size_t bytes = 0;
  for (const Block& block : blocks_) {
    bytes += block.size;
  }
  return bytes;
}

void* Arena::AllocateBytes(std::size_t bytes) {
  bytes = (bytes + kAlignment - 1) / kAlignment * kAlignment;
  if (current_ >= blocks_.size() || bytes > blocks_[current_].size - used_in_current_) {
    TakeBlock(bytes);
  }
  void* const memory = blocks_[current_].data.get() + used_in_current_;
  used_in_current_ += bytes;
  round_ += bytes;
  return memory;
}

void Arena::TakeBlock(std::size_t bytes) {
  const std::size_t free = current_ + (used_in_current_ > 0 ? 1 : 0);
  const auto first_free = blocks_.begin() + static_cast<std::ptrdiff_t>(free);
  const auto found = std::find_if(first_free, blocks_.end(),
                                  [&](const Block& block) { return block.size >= bytes; });
  if (found != blocks_.end()) {
    // The same round again finds it in the first place.
    std::iter_swap(first_free, found);
  } else {
    // The free blocks, all too small, become part of the new one.
    std::size_t size = std::max(bytes, kLeastBlock);
    std::size_t freed = 0;
    for (auto block = first_free; block != blocks_.end(); ++block) {
      freed += block->size;
    }
    size = std::max(size, freed);
    misfit_ = misfit_ || largest_round_ > 0;
    blocks_.erase(first_free, blocks_.end());
    blocks_.emplace_back(size);
  }
  current_ = free;
  used_in_current_ = 0;
}

}  // namespace gluevo::nn
