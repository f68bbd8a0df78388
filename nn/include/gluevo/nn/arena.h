#pragma once

#include <cstddef>
#include <vector>

#include "gluevo/nn/tensor.h"

namespace gluevo::nn {

/// Scratch memory for the tensors of one network call: handed out in order, given back all at once.
/// Memory is asked of the system only while calls still grow; a warmed-up network allocates
/// nothing. Not safe for use by several threads at once.
class Arena {
 public:
  Arena() = default;
  Arena(const Arena&) = delete;
  Arena& operator=(const Arena&) = delete;

  /// Gives back everything; views handed out before must no longer be used. If the last round did
  /// not fit one block, the blocks are replaced by one that holds it.
  void Reset();

  /// An uninitialised tensor, aligned to kAlignment.
  template <typename T>
  TensorView<T> Allocate(const Shape& shape) {
    static_assert(std::is_trivially_copyable_v<T>);
    return {static_cast<T*>(AllocateBytes(static_cast<std::size_t>(shape.size()) * sizeof(T))),
            shape};
  }

  /// Bytes held from the system.
  std::size_t capacity() const;

 private:
  void* AllocateBytes(std::size_t bytes);

  std::vector<Tensor<std::byte>> blocks_;
  std::size_t used_in_last_ = 0;  // Bytes of blocks_.back() that are handed out.
};

}  // namespace gluevo::nn
