#include "event_queue.hpp"

#include <algorithm>
#include <downrange/stage/catalogue.hpp>

namespace downrange::app {

bool is_measured(const Event& event) {
  return std::visit(
      []<class Record>(const Record&) { return Measurements::contains<Record> || std::is_same_v<Record, Observation>; },
      event);
}

EventQueue::EventQueue(std::vector<Name> sources, int capacity_per_ring) : sources_(std::move(sources)) {
  rings_.resize(sources_.size() + 2);
  for (Ring& ring : rings_) ring.slots.resize(static_cast<std::size_t>(capacity_per_ring));
}

void EventQueue::push(const Event& event) {
  {
    const std::lock_guard lock(mutex_);
    Ring* const own = ring_of(event);
    if (own == nullptr) {
      ++refused_;
      return;
    }
    Ring& ring = *own;
    const std::size_t capacity = ring.slots.size();
    if (ring.size == capacity) {
      ring.first = (ring.first + 1) % capacity;
      --ring.size;
      --depth_;
      ++ring.dropped;
    }
    ring.slots[(ring.first + ring.size) % capacity] = {arrivals_++, event};
    ++ring.size;
    ++depth_;
  }
  filled_.notify_one();
}

void EventQueue::wait(std::chrono::nanoseconds at_most) {
  std::unique_lock lock(mutex_);
  filled_.wait_for(lock, at_most, [this] { return depth_ > 0 || closed_; });
}

std::optional<Event> EventQueue::pop() {
  const std::lock_guard lock(mutex_);
  Ring* ring = oldest_locked();
  if (ring == nullptr) return std::nullopt;
  const Event event = ring->slots[ring->first].event;
  ring->first = (ring->first + 1) % ring->slots.size();
  --ring->size;
  --depth_;
  return event;
}

void EventQueue::close() {
  {
    const std::lock_guard lock(mutex_);
    closed_ = true;
  }
  filled_.notify_all();
}

std::size_t EventQueue::depth() const {
  const std::lock_guard lock(mutex_);
  return depth_;
}

EventQueue::Losses EventQueue::losses() const {
  const std::lock_guard lock(mutex_);
  Losses losses;
  losses.refused = refused_;
  for (std::size_t i = 0; i < rings_.size(); ++i) {
    const std::uint64_t dropped = rings_[i].dropped;
    losses.dropped += dropped;
    if (dropped <= losses.worst_dropped) continue;
    const bool of_source = i < sources_.size();
    losses.worst = of_source ? std::string(sources_[i].view()) : i == sources_.size() ? "orders" : "others";
    losses.worst_dropped = dropped;
  }
  return losses;
}

EventQueue::Ring* EventQueue::ring_of(const Event& event) {
  if (is_mark(event)) return &rings_[sources_.size()];
  const auto known = std::ranges::find(sources_, source_of(event));
  if (known != sources_.end()) return &rings_[static_cast<std::size_t>(known - sources_.begin())];
  return is_measured(event) ? nullptr : &rings_.back();
}

EventQueue::Ring* EventQueue::oldest_locked() {
  Ring* oldest = nullptr;
  for (Ring& ring : rings_) {
    if (ring.size == 0) continue;
    if (oldest == nullptr || ring.slots[ring.first].order < oldest->slots[oldest->first].order) oldest = &ring;
  }
  return oldest;
}

}  // namespace downrange::app
