#pragma once
/// What INTEGRITY found, in words: for the log and for screens.

#include <downrange/stage/result.hpp>
#include <optional>
#include <string>
#include <string_view>

namespace downrange {

/// "agrees", "suspect", "excluded", "ambiguous".
[[nodiscard]] std::string_view to_string(IntegrityVerdict verdict);
/// "fine position", "implausible bias" and so on; "none" of Finding::None.
[[nodiscard]] std::string_view to_string(Finding finding);

/// "T+241.3", or "08:04:16" UTC where no lift-off is known.
[[nodiscard]] std::string mission_time(Time t, std::optional<Time> liftoff);
/// "12 m", "5.0 km".
[[nodiscard]] std::string distance_text(double m);

/// Of record.sources[source]: "jeju disagrees with goheung and optical by 5.0 km since T+241.0; these agree within 12
/// m; excluded by integrity since T+243.2 (fine position)".
[[nodiscard]] std::string sentence(const Integrity& record, std::size_t source);
/// Whom the antennas follow, and how far one lie could move that: "kslv follows without-jeju, bound 75 m".
[[nodiscard]] std::string selection(const Integrity& record);

}  // namespace downrange
