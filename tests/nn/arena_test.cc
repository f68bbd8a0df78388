#include "gluevo/nn/arena.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <numeric>
#include <random>
#include <vector>

namespace gluevo::nn {
namespace {

constexpr std::size_t kMiB = std::size_t{1} << 20;

std::vector<std::byte*> Allocate(Arena& arena, const std::vector<std::size_t>& sizes) {
  std::vector<std::byte*> tensors;
  for (const std::size_t size : sizes) {
    tensors.push_back(arena.Allocate<std::byte>({static_cast<int64_t>(size)}).data());
  }
  return tensors;
}

TEST(ArenaTest, TensorsAreAlignedAndApart) {
  Arena arena;
  const std::vector<std::size_t> sizes = {1, 0, 64, 3 * kMiB, 65, 7, kMiB};
  for (int round = 0; round < 3; ++round) {
    const std::vector<std::byte*> tensors = Allocate(arena, sizes);
    for (std::size_t i = 0; i < sizes.size(); ++i) {
      EXPECT_EQ(reinterpret_cast<std::uintptr_t>(tensors[i]) % kAlignment, 0U);
      std::memset(tensors[i], static_cast<int>(i), sizes[i]);
    }
    for (std::size_t i = 0; i < sizes.size(); ++i) {
      EXPECT_EQ(std::count(tensors[i], tensors[i] + sizes[i], static_cast<std::byte>(i)),
                static_cast<std::ptrdiff_t>(sizes[i]));
    }
    arena.Reset();
  }
}

TEST(ArenaTest, TheSameRoundAgainGetsTheSameMemory) {
  Arena arena;
  const std::vector<std::size_t> sizes = {5 * kMiB, 100, kMiB, 2 * kMiB, 3 * kMiB, 70000, 8};
  const std::vector<std::byte*> first = Allocate(arena, sizes);
  const std::size_t capacity = arena.capacity();
  for (int round = 0; round < 3; ++round) {
    arena.Reset();
    EXPECT_EQ(Allocate(arena, sizes), first);
    EXPECT_EQ(arena.capacity(), capacity);
  }
}

TEST(ArenaTest, RoundsOfOtherSizesSettleAfterOneMore) {
  Arena arena;
  Allocate(arena, {4 * kMiB, kMiB});
  EXPECT_EQ(arena.capacity(), 5 * kMiB);
  arena.Reset();
  Allocate(arena, {kMiB, 4 * kMiB});  // Fits the blocks in the other order only.
  EXPECT_LE(arena.capacity(), 10 * kMiB);
  arena.Reset();
  const std::size_t capacity = arena.capacity();
  EXPECT_GE(capacity, 5 * kMiB);
  EXPECT_LE(capacity, 6 * kMiB);
  const std::byte* const memory = Allocate(arena, {5 * kMiB})[0];
  for (const std::vector<std::size_t>& sizes :
       {std::vector<std::size_t>{kMiB, 4 * kMiB}, {2 * kMiB, 3 * kMiB}, {8, 5 * kMiB - 64}, {}}) {
    arena.Reset();
    const std::vector<std::byte*> tensors = Allocate(arena, sizes);
    EXPECT_TRUE(tensors.empty() || tensors[0] == memory);
    EXPECT_EQ(arena.capacity(), capacity);
  }
}

TEST(ArenaTest, JoinFitsEveryOrderAndALittleMore) {
  Arena arena;
  std::vector<std::size_t> sizes = {kMiB, 2 * kMiB, 3 * kMiB, 4 * kMiB, 100};
  Allocate(arena, sizes);
  arena.Join();
  const std::size_t capacity = arena.capacity();
  const std::byte* const memory = Allocate(arena, {1})[0];
  do {
    arena.Join();
    EXPECT_EQ(Allocate(arena, sizes)[0], memory);
  } while (std::next_permutation(sizes.begin(), sizes.end()));
  arena.Join();
  Allocate(arena, {11 * kMiB});  // A tenth more than before.
  arena.Join();
  EXPECT_EQ(arena.capacity(), capacity);
}

TEST(ArenaTest, BlocksThatAreTooSmallBecomePartOfALargerOne) {
  Arena arena;
  Allocate(arena, {4 * kMiB, 3 * kMiB, 2 * kMiB});
  arena.Reset();
  Allocate(arena, {5 * kMiB, 2 * kMiB, 2 * kMiB});
  EXPECT_EQ(arena.capacity(), 9 * kMiB);
}

TEST(ArenaTest, HoldsAtMostSomeTwoTimesTheLargestRound) {
  std::mt19937 random(1);
  for (const bool join : {false, true}) {
    Arena arena;
    std::size_t largest = 0;
    for (int round = 0; round < 500; ++round) {
      std::vector<std::size_t> sizes(random() % 12);
      for (std::size_t& size : sizes) {
        size = kAlignment * (random() % (std::size_t{1} << (random() % 16)));
      }
      largest = std::max(largest, std::accumulate(sizes.begin(), sizes.end(), std::size_t{0}));
      Allocate(arena, sizes);
      // A joined block of 9/8 of the largest round, and this round beside it; small tensors of the
      // first round share blocks of 64 KiB.
      EXPECT_LE(arena.capacity(), largest * 17 / 8 + 12 * (kMiB / 16));
      join ? arena.Join() : arena.Reset();
    }
    EXPECT_LE(arena.capacity(), largest * 17 / 8);
  }
}

}  // namespace
}  // namespace gluevo::nn
