#pragma once

#include <cstddef>
#include <memory>
#include <new>
#include <type_traits>
#include <vector>

#include "gluevo/nn/tensor.h"

namespace gluevo::nn {

/// Scratch memory for the tensors of one network call: handed out in order, given back all at once.
/// A round is what is allocated between two Resets. The system is asked for memory only
/// - in the first round, and in one that asks for more in all than any before;
/// - in a round of other sizes than the one before, unless Join came between.
/// Holds at most some two times the largest round. Not safe for use by several threads at once.
class Arena {
 public:
  Arena() = default;
  Arena(const Arena&) = delete;
  Arena& operator=(const Arena&) = delete;

  /// Gives back everything to this arena: views handed out before must no longer be used.
  void Reset();

  /// Reset, and replaces the blocks of memory by one that fits all rounds so far, whatever their
  /// order of sizes. Free where there is one block already: for the end of a call that hands out no
  /// views.
  void Join();

  /// An uninitialised tensor, aligned to kAlignment. Throws std::bad_alloc where the system has no
  /// such memory.
  template <typename T>
  TensorView<T> Allocate(const Shape& shape) {
    static_assert(std::is_trivially_copyable_v<T>);
    return {static_cast<T*>(AllocateBytes(static_cast<std::size_t>(shape.size()) * sizeof(T))),
            shape};
  }

  /// Bytes held from the system.
  std::size_t capacity() const;

 private:
  // Uninitialised: memory that no tensor touches costs nothing.
  struct Block {
    struct Free {
      void operator()(std::byte* p) const { ::operator delete (p, std::align_val_t{kAlignment}); }
    };
    explicit Block(std::size_t bytes)
        : data(static_cast<std::byte*>(::operator new (bytes, std::align_val_t{kAlignment}))),
          size(bytes) {}
    std::unique_ptr<std::byte, Free> data;
    std::size_t size;
  };

  void* AllocateBytes(std::size_t bytes);
  // Makes a block of at least so many bytes the current one.
  void TakeBlock(std::size_t bytes);

  std::vector<Block> blocks_;
  std::size_t current_ = 0;          // The block that is handed out of; those after it are free.
  std::size_t used_in_current_ = 0;  // Bytes.
  std::size_t round_ = 0;            // Bytes handed out since the last Reset,
  std::size_t largest_round_ = 0;    // and the most of any round.
  // Blocks left by an earlier round did not do for this one.
  bool misfit_ = false;
};

}  // namespace gluevo::nn
