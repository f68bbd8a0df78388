#pragma once

#include <condition_variable>
#include <cstddef>
#include <deque>
#include <mutex>
#include <optional>
#include <utility>

namespace gluevo::vo {

/// What one stage of a pipeline hands the next, in order, from any number of threads to any number.
/// Holds at most so much: who is faster waits (Push) or does without the oldest
/// (PushDroppingOldest).
template <typename Item>
class BoundedQueue {
 public:
  using Weight = std::size_t (*)(const Item&);

  /// `capacity`: at least 1; of items, or of their weights: what weighs nothing always finds room.
  explicit BoundedQueue(
      std::size_t capacity, Weight weight = [](const Item& /*item*/) { return std::size_t{1}; })
      : capacity_(capacity), weight_(weight) {}
  BoundedQueue(const BoundedQueue&) = delete;
  BoundedQueue& operator=(const BoundedQueue&) = delete;

  /// Waits until the queue has room. False where it is closed: the item is not taken.
  bool Push(Item item) {
    {
      const std::size_t weight = weight_(item);
      std::unique_lock lock(mutex_);
      has_room_.wait(lock, [&] { return is_closed_ || Fits(weight); });
      if (is_closed_) {
        return false;
      }
      weight_of_all_ += weight;
      items_.push_back(std::move(item));
    }
    has_items_.notify_one();
    return true;
  }

  /// Never waits; for items that all weigh 1. Returns what had to go: the oldest item of a full
  /// queue, or the item itself where the queue is closed.
  std::optional<Item> PushDroppingOldest(Item item) {
    std::optional<Item> dropped;
    {
      const std::lock_guard lock(mutex_);
      if (is_closed_) {
        return item;
      }
      if (!Fits(weight_(item))) {
        dropped = TakeFirst();
      }
      weight_of_all_ += weight_(item);
      items_.push_back(std::move(item));
    }
    has_items_.notify_one();
    return dropped;
  }

  /// Whether Push would not wait for an item that weighs 1, as far as others do not push meanwhile.
  bool has_room() const {
    const std::lock_guard lock(mutex_);
    return is_closed_ || Fits(1);
  }

  /// Changes all items that wait, in order.
  template <typename Change>
  void ForEach(const Change& change) {
    {
      const std::lock_guard lock(mutex_);
      weight_of_all_ = 0;
      for (Item& item : items_) {
        change(item);
        weight_of_all_ += weight_(item);
      }
    }
    has_room_.notify_all();
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
  bool Fits(std::size_t weight) const {
    return weight == 0 || weight_of_all_ + weight <= capacity_;
  }

  Item TakeFirst() {
    Item item = std::move(items_.front());
    items_.pop_front();
    weight_of_all_ -= weight_(item);
    return item;
  }

  std::optional<Item> Take(std::unique_lock<std::mutex> lock) {
    if (items_.empty()) {
      return std::nullopt;
    }
    std::optional<Item> item = TakeFirst();
    lock.unlock();
    has_room_.notify_one();
    return item;
  }

  const std::size_t capacity_;
  const Weight weight_;
  mutable std::mutex mutex_;
  std::condition_variable has_items_, has_room_;
  std::deque<Item> items_;
  std::size_t weight_of_all_ = 0;  // Of them.
  bool is_closed_ = false;
};

}  // namespace gluevo::vo
