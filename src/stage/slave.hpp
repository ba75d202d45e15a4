#pragma once
/// Stage 4: where every antenna shall point.

#include <downrange/est/method/method.hpp>
#include <downrange/stage/range_config.hpp>
#include <downrange/stage/result.hpp>
#include <optional>
#include <span>
#include <vector>

namespace downrange {

/// Azimuth `wrapped` (any turn) brought into the antenna's travel.
struct TravelAzimuth {
  double azimuth_rad = 0;
  std::uint8_t limits = LimitNone;
};
/// The turn nearest to `previous` (to the middle of the travel when there is none) that lies inside [min, max]; a turn
/// further away is flagged LimitUnwrapped; when no turn lies inside, the nearer end with LimitAzimuth.
[[nodiscard]] TravelAzimuth unwrap_into_travel(double wrapped_rad, std::optional<double> previous_rad, double min_rad,
                                               double max_rad);

class Slave {
 public:
  explicit Slave(const RangeConfig& config);

  /// One command per antenna that has a target to follow. `newest`: of each target, the epoch of the newest measurement
  /// that the method was given; the method is not asked for what is too old to coast on.
  void tick(Time tick, const Method& method, std::span<const Time> newest, ResultSink& sink);

 private:
  struct Antenna {
    AntennaConfig config;
    int target = 0;
    std::optional<double> previous_azimuth_rad;
  };
  struct Chosen {
    TrackEstimate estimate;
    SlavingSource source;
  };

  /// The ladder of sources: fused, fused coasting, GPS. Nothing: no command is better than a wrong one.
  [[nodiscard]] std::optional<Chosen> choose(const Method& method, int target, Time tick, Time apply_at) const;
  [[nodiscard]] std::optional<SlavingCommand> command(Antenna& antenna, const Chosen& chosen, Time tick,
                                                      Time apply_at) const;

  RangeConfig config_;
  std::vector<Antenna> antennas_;
};

}  // namespace downrange
