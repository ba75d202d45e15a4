#pragma once
/// Which chains a target has: the subsets of its sources that the primary method is run on.

#include <downrange/geo/name.hpp>
#include <downrange/stage/range_config.hpp>
#include <downrange/stage/source_table.hpp>
#include <string_view>
#include <vector>

#include "stage/integrity/source_set.hpp"

namespace downrange {

/// What can lie by itself: a radar, an angles-only tracker, the vehicle's receiver with all the stations that relay it.
struct SourceUnit {
  Name name;  ///< of the radar or tracker; "GPS"
  SourceKind kind = SourceKind::Radar;
  SourceSet sources = 0;
  bool starts_track = false;  ///< it tells a position by itself
};

/// Those that a method uses: one that takes no angles passes over the trackers.
[[nodiscard]] std::vector<SourceUnit> source_units(const SourceTable& sources, bool takes_angles);

struct ChainPlan {
  Name name;              ///< "without-goheung", "only-GPS", "only-radars"; empty: all
  SourceSet sources = 0;  ///< that it hears
  bool alone = false;     ///< one unit
  /// Of what others may be held against: one unit, or all radars.
  bool independent = false;
};

/// The chains beside `all`, each set of sources once.
struct ChainPlans {
  static constexpr int none = -1;

  std::vector<ChainPlan> chains;
  std::vector<int>
      without;             ///< by unit: the chain that hears all but it; none where nothing that starts a track is left
  std::vector<int> alone;  ///< by unit: the chain that hears it alone
};

/// Each unit left out; each alone that can start a track; all radars. With more than `most_alone` units not each alone,
/// but GPS.
inline constexpr std::size_t most_alone = 6;
[[nodiscard]] ChainPlans plan_chains(const std::vector<SourceUnit>& units);

/// Of a range: none where INTEGRITY is off, or there is one unit alone.
[[nodiscard]] std::vector<ChainPlan> chains_of(const RangeConfig& config);

/// `prefix` and `name` as one name. What does not fit into a name's 31 characters is cut and ends in ".`number`", which
/// tells two such names apart.
[[nodiscard]] Name joined_name(std::string_view prefix, std::string_view name, std::size_t number);

}  // namespace downrange
