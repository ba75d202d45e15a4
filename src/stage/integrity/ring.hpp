#pragma once
/// The newest entries of a series, in place: pushing allocates nothing.

#include <algorithm>
#include <cstddef>
#include <vector>

namespace downrange::integrity {

template <class T>
class Ring {
 public:
  explicit Ring(std::size_t capacity) : entries_(capacity) {}

  void push(const T& entry) {
    next_ = (next_ + 1) % entries_.size();
    entries_[next_] = entry;
    size_ = std::min(size_ + 1, entries_.size());
  }
  void clear() { size_ = 0; }
  [[nodiscard]] std::size_t size() const { return size_; }
  [[nodiscard]] bool empty() const { return size_ == 0; }
  /// `back` entries before the newest; back < size().
  [[nodiscard]] const T& newest(std::size_t back = 0) const {
    return entries_[(next_ + entries_.size() - back) % entries_.size()];
  }
  [[nodiscard]] T& newest(std::size_t back = 0) { return entries_[(next_ + entries_.size() - back) % entries_.size()]; }

 private:
  std::vector<T> entries_;
  std::size_t next_ = 0;
  std::size_t size_ = 0;
};

}  // namespace downrange::integrity
