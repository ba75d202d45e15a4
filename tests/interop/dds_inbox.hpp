#pragma once
/// Collects what readers hand over on their own threads.

#include <algorithm>
#include <chrono>
#include <condition_variable>
#include <mutex>
#include <vector>

namespace downrange::dds {

template <class Item>
class Inbox {
 public:
  void add(const Item& item) {
    const std::scoped_lock lock(mutex_);
    items_.push_back(item);
    changed_.notify_all();
  }
  /// Whether `condition` (of all items so far) holds before half a minute has passed.
  template <class Condition>
  [[nodiscard]] bool wait(Condition condition) {
    std::unique_lock lock(mutex_);
    return changed_.wait_for(lock, std::chrono::seconds(30), [&] { return condition(items_); });
  }
  [[nodiscard]] bool wait_for_size(std::size_t size) {
    return wait([size](const auto& items) { return items.size() >= size; });
  }
  [[nodiscard]] std::vector<Item> items() const {
    const std::scoped_lock lock(mutex_);
    return items_;
  }

 private:
  mutable std::mutex mutex_;
  std::condition_variable changed_;
  std::vector<Item> items_;
};

}  // namespace downrange::dds
