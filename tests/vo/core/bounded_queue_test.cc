#include "gluevo/vo/core/bounded_queue.h"

#include <gtest/gtest.h>

#include <memory>
#include <thread>
#include <vector>

namespace gluevo::vo {
namespace {

TEST(BoundedQueueTest, GivesAllItemsInOrderFromOneThreadToAnother) {
  constexpr int kCount = 2000;
  BoundedQueue<int> queue(2);
  const std::jthread producer([&] {
    for (int i = 0; i < kCount; ++i) {
      EXPECT_TRUE(queue.Push(i));
    }
    queue.Close();
  });
  std::vector<int> items;
  while (const std::optional<int> item = queue.Pop()) {
    items.push_back(*item);
  }
  ASSERT_EQ(items.size(), static_cast<std::size_t>(kCount));
  for (int i = 0; i < kCount; ++i) {
    EXPECT_EQ(items[i], i);
  }
}

TEST(BoundedQueueTest, WhoDoesNotWaitDropsTheOldest) {
  BoundedQueue<int> queue(2);
  EXPECT_FALSE(queue.PushDroppingOldest(1));
  EXPECT_FALSE(queue.PushDroppingOldest(2));
  EXPECT_EQ(queue.PushDroppingOldest(3), 1);
  EXPECT_EQ(queue.PushDroppingOldest(4), 2);
  EXPECT_EQ(queue.Pop(), 3);
  EXPECT_EQ(queue.TryPop(), 4);
  EXPECT_EQ(queue.TryPop(), std::nullopt);
}

TEST(BoundedQueueTest, HoldsNoMoreThanItsCapacityOfWeight) {
  BoundedQueue<int> queue(2, [](const int& item) { return static_cast<std::size_t>(item); });
  for (const int item : {0, 1, 0, 1}) {  // None waits.
    EXPECT_TRUE(queue.has_room());
    EXPECT_TRUE(queue.Push(item));
  }
  EXPECT_FALSE(queue.has_room());
  EXPECT_TRUE(queue.Push(0));  // What weighs nothing does not wait.
  bool is_taken = false;
  std::jthread pusher([&] { is_taken = queue.Push(1); });
  queue.ForEach([](int& item) { item = 0; });  // Makes room.
  pusher.join();
  EXPECT_TRUE(is_taken);
  EXPECT_TRUE(queue.has_room());
}

TEST(BoundedQueueTest, ClosedItTakesNothingAndGivesWhatItHas) {
  BoundedQueue<int> queue(3);
  EXPECT_TRUE(queue.Push(1));
  EXPECT_TRUE(queue.Push(2));
  queue.Close();
  EXPECT_FALSE(queue.Push(3));
  EXPECT_EQ(queue.PushDroppingOldest(4), 4);
  EXPECT_EQ(queue.Pop(), 1);
  EXPECT_EQ(queue.Pop(), 2);
  EXPECT_EQ(queue.Pop(), std::nullopt);
}

TEST(BoundedQueueTest, ClosingWakesWhoWaits) {
  BoundedQueue<int> empty(1);
  BoundedQueue<std::unique_ptr<int>> full(1);
  EXPECT_TRUE(full.Push(std::make_unique<int>(1)));
  std::jthread consumer([&] { EXPECT_EQ(empty.Pop(), std::nullopt); });
  std::jthread producer([&] { EXPECT_FALSE(full.Push(std::make_unique<int>(2))); });
  empty.Close();
  full.Close();
  consumer.join();
  producer.join();
  EXPECT_EQ(**full.Pop(), 1);
}

}  // namespace
}  // namespace gluevo::vo
