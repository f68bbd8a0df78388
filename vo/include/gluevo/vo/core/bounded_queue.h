#pragma once

#include <condition_variable>
#include <cstddef>
#include <deque>
#include <mutex>
#include <optional>
#include <utility>

namespace gluevo::vo {

/// What one stage of a pipeline hands the next, in order, from any number of threads to any number.
/// Holds at most so many items: who is faster waits (Push) or does without the oldest
/// (PushDroppingOldest).
template <typename Item>
class BoundedQueue {
 public:
  /// `capacity`: at least 1.
  explicit BoundedQueue(std::size_t capacity) : capacity_(capacity) {}
  BoundedQueue(const BoundedQueue&) = delete;
  BoundedQueue& operator=(const BoundedQueue&) = delete;

  /// Waits while the queue is full. False where it is closed: the item is not taken.
  bool Push(Item item) {
    {
      std::unique_lock lock(mutex_);
      has_room_.wait(lock, [&] { return is_closed_ || items_.size() < capacity_; });
      if (is_closed_) {
        return false;
      }
      items_.push_back(std::move(item));
    }
    has_items_.notify_one();
    return true;
  }

  /// Never waits. Returns what had to go: the oldest item of a full queue, or the item itself where
  /// the queue is closed.
  std::optional<Item> PushDroppingOldest(Item item) {
    std::optional<Item> dropped;
    {
      const std::lock_guard lock(mutex_);
      if (is_closed_) {
        return item;
      }
      if (items_.size() == capacity_) {
        dropped = std::move(items_.front());
        items_.pop_front();
      }
      items_.push_back(std::move(item));
    }
    has_items_.notify_one();
    return dropped;
  }

  /// Waits for an item; nothing once the queue is closed and empty.
  std::optional<Item> Pop() {
    std::unique_lock lock(mutex_);
    has_items_.wait(lock, [&] { return is_closed_ || !items_.empty(); });
    return Take(std::move(lock));
  }

  /// Never waits: nothing where there is nothing.
  std::optional<Item> TryPop() { return Take(std::unique_lock(mutex_)); }

  /// Nothing is taken any more; what is there can still be had.
  void Close() {
    {
      const std::lock_guard lock(mutex_);
      is_closed_ = true;
    }
    has_items_.notify_all();
    has_room_.notify_all();
  }

 private:
  std::optional<Item> Take(std::unique_lock<std::mutex> lock) {
    std::optional<Item> item;
    if (items_.empty()) {
      return item;
    }
    item = std::move(items_.front());
    items_.pop_front();
    lock.unlock();
    has_room_.notify_one();
    return item;
  }

  const std::size_t capacity_;
  std::mutex mutex_;
  std::condition_variable has_items_, has_room_;
  std::deque<Item> items_;
  bool is_closed_ = false;
};

}  // namespace gluevo::vo
