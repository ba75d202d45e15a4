#pragma once
/// Copies of one fix that several stations relayed describe one message: they agree to the wire's quantum. Where two
/// differ, nobody knows which is right until one agrees with what is known without; where three differ, the majority
/// is.

#include <array>
#include <downrange/est/model/measured.hpp>
#include <downrange/geo/time.hpp>
#include <optional>

#include "ring.hpp"
#include "source_set.hpp"

namespace downrange::integrity {

/// How far copies of one fix may differ.
struct CopyTolerance {
  double position_m;
  double velocity_m_s;
};

/// The copies of one receiver's fixes.
class Copies {
 public:
  static constexpr std::size_t max_stations = 8;

  explicit Copies(CopyTolerance tolerance) : tolerance_(tolerance), messages_(16) {}

  struct Copy {
    int station = -1;
    Fix fix;
  };
  /// One fix, as heard so far.
  struct Message {
    Time epoch;
    std::array<Copy, max_stations> copy{};
    std::size_t count = 0;
  };

  /// Stations that differ from the others in this fix, and how far.
  struct Odd {
    SourceSet stations = 0;  ///< named: a majority agrees without them
    SourceSet disputed = 0;  ///< two differ, and nothing says which
    SourceSet agreeing = 0;  ///< agree with each other
    double apart_m = 0;
  };

  /// The fix that the copy belongs to, with it.
  const Message& note(int station, Time epoch, const Fix& fix);
  /// `expected`: where the target is without this receiver, if that is known to some metres: settles a dispute.
  [[nodiscard]] Odd odd(const Message& message, const std::optional<Position<Ecef>>& expected) const;
  [[nodiscard]] bool same(const Fix& a, const Fix& b) const;

 private:
  CopyTolerance tolerance_;
  Ring<Message> messages_;
};

}  // namespace downrange::integrity
