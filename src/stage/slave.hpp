#pragma once
/// Stage 4: where every antenna shall point.

#include <downrange/stage/range_config.hpp>
#include <downrange/stage/result.hpp>
#include <optional>
#include <span>
#include <vector>

#include "stage/followed.hpp"

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

  /// One command per antenna that has a target to follow. `followed`: of each target; a method is not asked for what is
  /// too old to coast on.
  ///
  /// When what is followed changes (another chain, a chain that was run again, GPS for the fused track), the command
  /// goes over by a blend: it starts where the last one would be now, and what is left of the difference shrinks by
  /// slave.blend_rate_deg_s.
  void tick(Time tick, std::span<const Followed> followed, ResultSink& sink);

 private:
  /// What was commanded last.
  struct Previous {
    Time tick;
    std::uint64_t revision = 0;
    bool gps = false;
    double azimuth_rad = 0;  ///< of the command, blend included, travel left out
    double elevation_rad = 0;
    double azimuth_rate_rad_s = 0;  ///< of the target
    double elevation_rate_rad_s = 0;
  };
  struct Antenna {
    AntennaConfig config;
    int target = 0;
    std::optional<double> previous_azimuth_rad;
    std::optional<Previous> previous{};
    double blend_azimuth_rad = 0;  ///< what the command is still away from the target
    double blend_elevation_rad = 0;
  };
  struct Chosen {
    TrackEstimate estimate;
    SlavingSource source;
  };
  /// Per second, what a blend adds to the axis rates.
  struct BlendRates {
    double azimuth_rad_s = 0;
    double elevation_rad_s = 0;
  };

  /// The ladder of sources: fused, fused coasting, GPS. Nothing: no command is better than a wrong one.
  [[nodiscard]] std::optional<Chosen> choose(const Followed& followed, Time tick, Time apply_at) const;
  [[nodiscard]] std::optional<SlavingCommand> command(Antenna& antenna, const Followed& followed, const Chosen& chosen,
                                                      Time tick, Time apply_at) const;
  /// The blend at this tick, for a target at `q` that moves with `rates` (range, azimuth, elevation).
  [[nodiscard]] BlendRates blend(Antenna& antenna, const Followed& followed, const Chosen& chosen, Time tick,
                                 const Polar& q, const Eigen::Vector3d& rates) const;

  RangeConfig config_;
  std::vector<Antenna> antennas_;
};

}  // namespace downrange
