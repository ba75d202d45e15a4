#pragma once
/// The sensors of a simulated flight: what each would have reported, and when the report reached the centre.
/// Every source delivers in order, as a reliable link does: lateness differs between sources, never within one.

#include <cstdint>
#include <downrange/geo/polar.hpp>
#include <downrange/geo/refraction.hpp>
#include <downrange/geo/site.hpp>
#include <downrange/stage/event.hpp>
#include <vector>

#include "score/truth.hpp"
#include "sim/scenario.hpp"

namespace downrange::sim {

/// The true bias of a radar in one run: the fixed part plus what `seed` draws.
[[nodiscard]] RadarBias draw_bias(const RadarScenario& radar, std::uint64_t seed);

/// What a noise-free radar with `bias` measures of a target at `true_enu` from it (the time tag apart): the target is
/// displaced, its echo refracted, then the polar terms act. Azimuth in [0, 2 pi).
[[nodiscard]] Polar biased(const Displacement<Enu>& true_enu, const RadarBias& bias, const Atmosphere& atmosphere = {});

/// How fast the range of a target grows at `t`, displaced and refracted as in `biased`; polar terms do not touch it.
[[nodiscard]] double true_range_rate(const RadarScenario& radar, const RadarBias& bias,
                                     const score::TruthFunction& truth, Time t);

struct RadarRun {
  RadarBias bias;
  std::vector<RadarTspi> plots;                  ///< sequences from 1
  std::vector<std::uint64_t> outlier_sequences;  ///< plots that carry a planted outlier
};

/// The plots of one radar. Noise does not depend on dropouts, outages, delays or other sensors.
[[nodiscard]] RadarRun simulate_radar(const RadarScenario& radar, const Scenario& scenario,
                                      const score::TruthFunction& truth, std::uint64_t seed);

/// The same of an angles-only tracker.
[[nodiscard]] std::vector<AngleTspi> simulate_angles(const RadarScenario& sensor, const Scenario& scenario,
                                                     const score::TruthFunction& truth, std::uint64_t seed);

/// The receiver's fixes as every station relayed them: one fix comes from several stations with equal epoch and
/// position, sequences from 1 per station.
[[nodiscard]] std::vector<GpsFix> simulate_gps(const Scenario& scenario, const score::TruthFunction& truth,
                                               std::uint64_t seed);

}  // namespace downrange::sim
