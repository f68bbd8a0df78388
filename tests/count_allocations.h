#pragma once

#include <atomic>
#include <cerrno>
#include <cstdint>
#include <cstdlib>
// Eigen includes it: clang takes its declarations only before ours.
#if __has_include(<mm_malloc.h>)
#include <mm_malloc.h>
#endif

/// Counts how often a program asks the system for memory: what includes this, one source of a
/// program, has a malloc family that stands before glibc's.

// Sanitisers bring a malloc of their own; g++ says by macros that they are there, clang by
// features.
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
#define GLUEVO_COUNTS_ALLOCATIONS 0
#elif defined(__has_feature)
#if __has_feature(address_sanitizer) || __has_feature(thread_sanitizer)
#define GLUEVO_COUNTS_ALLOCATIONS 0
#endif
#endif
#ifndef GLUEVO_COUNTS_ALLOCATIONS
#define GLUEVO_COUNTS_ALLOCATIONS 1
#endif

namespace gluevo {
inline std::atomic<int64_t> allocations = 0;
}  // namespace gluevo

#if GLUEVO_COUNTS_ALLOCATIONS
extern "C" {
// The names are glibc's.
// NOLINTBEGIN(bugprone-reserved-identifier,readability-identifier-naming)
void* __libc_malloc(std::size_t size);
void* __libc_calloc(std::size_t count, std::size_t size);
void* __libc_realloc(void* memory, std::size_t size);
void* __libc_memalign(std::size_t alignment, std::size_t size);
// NOLINTEND(bugprone-reserved-identifier,readability-identifier-naming)

void* malloc(std::size_t size) noexcept {
  ++gluevo::allocations;
  return __libc_malloc(size);
}
void* calloc(std::size_t count, std::size_t size) noexcept {
  ++gluevo::allocations;
  return __libc_calloc(count, size);
}
void* realloc(void* memory, std::size_t size) noexcept {
  ++gluevo::allocations;
  return __libc_realloc(memory, size);
}
void* memalign(std::size_t alignment, std::size_t size) noexcept {
  ++gluevo::allocations;
  return __libc_memalign(alignment, size);
}
void* aligned_alloc(std::size_t alignment, std::size_t size) noexcept {
  ++gluevo::allocations;
  return __libc_memalign(alignment, size);
}
int posix_memalign(void** memory, std::size_t alignment, std::size_t size) noexcept {
  ++gluevo::allocations;
  *memory = __libc_memalign(alignment, size);
  return *memory != nullptr ? 0 : ENOMEM;
}
}  // extern "C"
#endif

namespace gluevo {

/// How often the call asks for memory; always 0 where they are not counted.
template <typename Call>
int64_t AllocationsOf(const Call& call) {
  const int64_t before = allocations;
  call();
  return allocations - before;
}

}  // namespace gluevo
