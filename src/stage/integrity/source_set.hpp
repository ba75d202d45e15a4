#pragma once
/// Sets of sources.

#include <bit>
#include <cstdint>

namespace downrange {

/// Bit i: SourceId i of the source table. At most 64 sources.
using SourceSet = std::uint64_t;
inline constexpr int max_sources_in_set = 64;

[[nodiscard]] constexpr SourceSet set_of(int source) { return SourceSet{1} << static_cast<unsigned>(source); }
[[nodiscard]] constexpr bool contains(SourceSet set, int source) { return (set & set_of(source)) != 0; }
[[nodiscard]] constexpr int count(SourceSet set) { return std::popcount(set); }

}  // namespace downrange
