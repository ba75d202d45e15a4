#pragma once
/// Inside src/dds: the one field of discovery that is changed on the way in.

#include <cstdint>
#include <span>

namespace downrange::dds {

/// Puts `seconds` in place of the lease that a participant announces of itself, wherever an RTPS message holds such an
/// announcement (SPDP: OMG formal/2022-04-01, 8.3, 9.4.5, 9.6.2). Anything else, malformed messages included, stays as
/// it is.
void put_lease(std::span<std::uint8_t> message, std::int32_t seconds);

}  // namespace downrange::dds
