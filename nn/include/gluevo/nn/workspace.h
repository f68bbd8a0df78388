#pragma once

#include <cstdint>
#include <vector>

#include "gluevo/nn/arena.h"
#include "gluevo/nn/thread_pool.h"

namespace gluevo::nn {

/// What a network call needs beside the network: threads, and memory that calls use again. Networks
/// are constant and may be shared; a workspace serves one call at a time.
struct Workspace {
  explicit Workspace(ThreadPool& pool_in) : pool(pool_in) {}

  ThreadPool& pool;
  Arena arena;
  std::vector<int64_t> candidates;  ///< Of SuperPoint's keypoint selection.
};

}  // namespace gluevo::nn
