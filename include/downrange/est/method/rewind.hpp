#pragma once
/// Late data: a short history of measurements and checkpoints around any estimator that is a value.

#include <algorithm>
#include <cstddef>
#include <downrange/est/method/method.hpp>
#include <utility>
#include <vector>

namespace downrange {

/// Runs `Core` so that the state is always that of processing all measurements of the history in order, whatever the
/// order of arrival.
///
/// `Core::State` is copyable (assigning one state to another of the same configuration does not allocate) and
/// `Core::apply(State&, const Measurement&) const -> Outcome` advances it by one measurement, reading nothing else. A
/// state that is large because it serves many targets says so by `Core::checkpoint_spacing()`: more entries between two
/// checkpoints, so that keeping them costs each measurement the same. `Core::reserve(State&)`, where it is, makes room
/// in a copy for what its vectors may come to hold: a copied vector has no room to spare.
template <class Core>
class Rewinder {
 public:
  using State = typename Core::State;

  Rewinder(Core core, State initial, Duration history) : core_(std::move(core)), state_(initial), history_(history) {
    if constexpr (requires { core_.checkpoint_spacing(); }) spacing_ = core_.checkpoint_spacing();
    checkpoints_.push_back({.first = 0, .state = std::move(initial)});
    if constexpr (requires { core_.reserve(state_); }) core_.reserve(state_);
    checkpoint_count_ = 1;
  }

  /// Before the first measurement.
  void start(int target, Time epoch, const Gaussian<9>& estimate) {
    core_.start(state_, target, epoch, estimate);
    checkpoints_.front().state = state_;
  }

  Outcome process(const Measurement& m, Time now) {
    forget_before(now - history_);
    const auto place = std::upper_bound(entries_.begin(), entries_.end(), m, processed_before);
    const auto index = static_cast<std::size_t>(place - entries_.begin());
    const bool newest = place == entries_.end();
    entries_.insert(place, m);
    if (newest) return step(index);

    while (checkpoint_count_ > 1 && checkpoints_[checkpoint_count_ - 1].first > index) --checkpoint_count_;
    state_ = checkpoints_[checkpoint_count_ - 1].state;
    Outcome outcome;
    // The checkpoint holds the state *before* its entry, so that entry is applied without writing it again.
    const std::size_t first = checkpoints_[checkpoint_count_ - 1].first;
    for (std::size_t i = first; i < entries_.size(); ++i) {
      const Outcome of_entry = i == first ? core_.apply(state_, entries_[i]) : step(i);
      if (i == index) outcome = of_entry;
    }
    return outcome;
  }

  /// A state with room for all that it may come to hold.
  [[nodiscard]] State roomy_state() const {
    State room = state_;
    if constexpr (requires { core_.reserve(room); }) core_.reserve(room);
    return room;
  }
  /// The state before the first measurement with epoch >= `before`, which is inside the history.
  void state_before(Time before, State& state) const {
    const auto place = std::lower_bound(entries_.begin(), entries_.end(), before,
                                        [](const Measurement& m, Time t) { return m.epoch < t; });
    const auto index = static_cast<std::size_t>(place - entries_.begin());
    std::size_t checkpoint = checkpoint_count_ - 1;
    while (checkpoint > 0 && checkpoints_[checkpoint].first > index) --checkpoint;
    state = checkpoints_[checkpoint].state;
    for (std::size_t i = checkpoints_[checkpoint].first; i < index; ++i) (void)core_.apply(state, entries_[i]);
  }
  /// Goes on from `state`, with nothing in the history.
  void restart(const State& state) {
    entries_.clear();
    state_ = state;
    checkpoints_.front().first = 0;
    checkpoints_.front().state = state;
    checkpoint_count_ = 1;
  }

  [[nodiscard]] const State& state() const { return state_; }
  [[nodiscard]] const Core& core() const { return core_; }

 private:
  struct Checkpoint {
    std::size_t first;  ///< index of the entry that this state is the state before
    State state;
  };
  /// Forgetting moves the vectors' contents, so it is done in lumps.
  static constexpr std::size_t lump = 64;

  Outcome step(std::size_t index) {
    if (index - checkpoints_[checkpoint_count_ - 1].first >= spacing_) {
      if (checkpoint_count_ == checkpoints_.size()) {
        checkpoints_.push_back({.first = index, .state = state_});
        if constexpr (requires { core_.reserve(state_); }) core_.reserve(checkpoints_.back().state);
      }
      checkpoints_[checkpoint_count_].first = index;
      checkpoints_[checkpoint_count_].state = state_;
      ++checkpoint_count_;
    }
    return core_.apply(state_, entries_[index]);
  }

  /// Forgets whole checkpoints of entries older than `horizon`; what remains starts at or before it.
  void forget_before(Time horizon) {
    std::size_t drop = 0;
    while (drop + 1 < checkpoint_count_ && entries_[checkpoints_[drop + 1].first].epoch < horizon) ++drop;
    const std::size_t dropped_entries = checkpoints_[drop].first;
    if (dropped_entries < lump) return;
    entries_.erase(entries_.begin(), entries_.begin() + static_cast<std::ptrdiff_t>(dropped_entries));
    // Forgotten checkpoints go to the end as spares: their memory is used again.
    std::rotate(checkpoints_.begin(), checkpoints_.begin() + static_cast<std::ptrdiff_t>(drop), checkpoints_.end());
    checkpoint_count_ -= drop;
    for (std::size_t i = 0; i < checkpoint_count_; ++i) checkpoints_[i].first -= dropped_entries;
  }

  Core core_;
  State state_;
  Duration history_;
  /// Between two checkpoints: rewinding re-runs up to this many entries more than needed, memory is 1/spacing.
  std::size_t spacing_ = 8;
  std::vector<Measurement> entries_;     ///< in processing order
  std::vector<Checkpoint> checkpoints_;  ///< the first checkpoint_count_ are in use, ascending
  std::size_t checkpoint_count_ = 0;
};

}  // namespace downrange
