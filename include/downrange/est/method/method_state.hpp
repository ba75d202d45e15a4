#pragma once
/// How what a source taught a method is undone: the method's state is saved, and restored.

#include <downrange/geo/time.hpp>
#include <memory>
#include <utility>

namespace downrange {

/// What a method knew at one instant, of every target and source. Only a method of the kind and settings that made it
/// can read it.
class MethodState {
 public:
  virtual ~MethodState() = default;
};

/// What a method is beside `Method` where its state can be copied; all that `rewound` makes are. One that is not works
/// all the same: what a liar taught it is undone by a new one that begins with the oldest measurement kept.
class RestorableMethod {
 public:
  virtual ~RestorableMethod() = default;

  /// Room for a state.
  [[nodiscard]] virtual std::unique_ptr<MethodState> make_state() const = 0;
  /// The state before the first measurement with epoch >= `before`, which is inside the history, into room that
  /// `make_state` made. Room that was used before is used again without allocating.
  virtual void save(Time before, MethodState& state) const = 0;
  /// Goes on from `state` as if nothing else had ever been processed.
  virtual void restore(const MethodState& state) = 0;
};

/// The state of a method whose state is a value.
template <class State>
struct HeldState final : MethodState {
  explicit HeldState(State initial) : value(std::move(initial)) {}
  State value;
};

}  // namespace downrange
