#include "sim/sensor_models.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>

#include "sim/random_stream.hpp"

namespace downrange::sim {
namespace {

constexpr double azimuth_reference_rad = std::numbers::pi;  // south

bool inside(const Window& window, double t_s) { return t_s >= window.first && t_s < window.second; }

bool inside(const std::vector<Window>& windows, double t_s) {
  return std::any_of(windows.begin(), windows.end(), [t_s](const Window& w) { return inside(w, t_s); });
}

/// Instants phase + k / rate in [from, to), seconds after lift-off; each computed afresh so that none drifts.
std::vector<double> sample_times(double rate_hz, double phase_s, const Window& window) {
  std::vector<double> times;
  constexpr double rounding = 1e-9;
  for (double k = std::ceil((window.first - phase_s) * rate_hz - rounding);; ++k) {
    const double t_s = phase_s + k / rate_hz;
    if (t_s >= window.second - rounding) return times;
    times.push_back(t_s);
  }
}

std::string stream_name(std::string_view kind, const Name& id) {
  return std::string(kind) + "/" + std::string(id.view());
}

/// Of the azimuth axis: what is on the sky is that over cos(elevation), to half a degree off the zenith.
double axis_error(double error_rad, bool on_sky, double elevation_rad) {
  constexpr double least = 0.0087;
  return on_sky ? error_rad / std::max(std::cos(elevation_rad), least) : error_rad;
}

/// Signed size of an outlier: 0.5 to 1.5 times `size`, either way.
double outlier_size(RandomStream& random, double size) {
  const double magnitude = size * random.uniform(0.5, 1.5);
  return random.uniform() < 0.5 ? -magnitude : magnitude;
}

/// A link with memory: nothing overtakes what was sent before it.
class OrderedLink {
 public:
  Time deliver(Time sent, double delay_s) {
    last_ = std::max(last_, sent + seconds(delay_s));
    return last_;
  }

 private:
  Time last_{INT64_MIN};
};

GpsFix make_fix(const Scenario& scenario, double t_s, const score::TrueState& state, const Eigen::Vector3d& error_enu,
                const Eigen::Vector3d& velocity_error) {
  const GpsScenario& gps = scenario.gps;
  GpsFix fix;
  fix.target = scenario.target;
  fix.epoch = scenario.liftoff + seconds(t_s);
  const Rotation<Enu, Ecef> R_enu_ecef = enu_from_ecef_at(geodetic_from_ecef(state.position));
  fix.position = state.position + R_enu_ecef.inverse() * Displacement<Enu>{error_enu};
  fix.velocity_valid = gps.sigma_velocity_m_s > 0;
  if (fix.velocity_valid) fix.velocity = {state.velocity.m_s + velocity_error};
  if (gps.states_accuracy) {
    const Eigen::Vector3d sigma = (gps.sigma_enu_m.array().square() + gps.coloured_sigma_enu_m.array().square()).sqrt();
    fix.sigma_horizontal_m = sigma.head<2>().norm() / std::numbers::sqrt2;
    fix.sigma_vertical_m = sigma.z();
    fix.sigma_velocity_m_s = gps.sigma_velocity_m_s;
  }
  fix.satellites = static_cast<std::uint8_t>(gps.satellites);
  fix.satellites_valid = gps.satellites_stated;
  fix.simulated = scenario.simulated;
  return fix;
}

/// The receiver's fixes before any station relays them.
std::vector<GpsFix> receiver_fixes(const Scenario& scenario, const score::TruthFunction& truth, std::uint64_t seed) {
  const GpsScenario& gps = scenario.gps;
  RandomStream white(seed, "gps/white");
  RandomStream slow(seed, "gps/coloured");
  const double step_s = 1 / gps.rate_hz;
  ColouredNoise east(slow, gps.coloured_sigma_enu_m.x(), gps.coloured_tau_s, step_s);
  ColouredNoise north(slow, gps.coloured_sigma_enu_m.y(), gps.coloured_tau_s, step_s);
  ColouredNoise up(slow, gps.coloured_sigma_enu_m.z(), gps.coloured_tau_s, step_s);
  const auto normal3 = [&white] {
    const double x = white.normal();
    const double y = white.normal();
    return Eigen::Vector3d(x, y, white.normal());
  };

  std::vector<GpsFix> fixes;
  for (const double t_s : sample_times(gps.rate_hz, gps.phase_s, gps.active)) {
    const Eigen::Vector3d coloured(east.next(), north.next(), up.next());
    const Eigen::Vector3d error_enu = gps.sigma_enu_m.cwiseProduct(normal3()) + coloured;
    const Eigen::Vector3d velocity_error = gps.sigma_velocity_m_s * normal3();
    const std::optional<score::TrueState> state = truth(scenario.liftoff + seconds(t_s));
    if (!state || inside(gps.outages, t_s)) continue;
    Eigen::Vector3d fault_enu = Eigen::Vector3d::Zero();
    for (const GpsFault& fault : gps.faults) {
      if (inside(fault.when, t_s)) fault_enu += fault.offset_enu_m + (t_s - fault.when.first) * fault.drift_enu_m_s;
    }
    fixes.push_back(make_fix(scenario, t_s, *state, error_enu + fault_enu, velocity_error));
  }
  return fixes;
}

}  // namespace

RadarBias draw_bias(const RadarScenario& radar, std::uint64_t seed) {
  RandomStream random(seed, stream_name("bias", radar.id));
  const auto drawn = [&random](double fixed, double sigma) { return fixed + sigma * random.normal(); };
  const RadarBias& sigma = radar.bias_sigma;
  RadarBias bias = radar.bias;
  bias.offset = {drawn(bias.offset.range_m, sigma.offset.range_m),
                 drawn(bias.offset.azimuth_rad, sigma.offset.azimuth_rad),
                 drawn(bias.offset.elevation_rad, sigma.offset.elevation_rad)};
  for (int i = 0; i < 3; ++i) {
    bias.scale[i] = drawn(bias.scale[i], sigma.scale[i]);
    bias.sez_offset_m[i] = drawn(bias.sez_offset_m[i], sigma.sez_offset_m[i]);
    bias.sez_scale[i] = drawn(bias.sez_scale[i], sigma.sez_scale[i]);
  }
  bias.time_tag_s = drawn(bias.time_tag_s, sigma.time_tag_s);
  return bias;
}

Polar biased(const Displacement<Enu>& true_enu, const RadarBias& bias, const Atmosphere& atmosphere) {
  const Rotation<Sez, Enu> R_sez_enu = sez_from_enu();
  const Displacement<Sez> d_sez = R_sez_enu * true_enu;
  const Displacement<Sez> displaced{d_sez.m + bias.sez_offset_m + bias.sez_scale.cwiseProduct(d_sez.m)};
  Polar q = polar_from_enu(R_sez_enu.inverse() * displaced);
  const Refraction refraction = refraction_at_true(atmosphere, q.range_m, q.elevation_rad);
  q.range_m += refraction.range_m;
  q.elevation_rad += refraction.elevation_rad;
  const double from_south = wrap_pi(q.azimuth_rad - azimuth_reference_rad);
  return {q.range_m + bias.offset.range_m + bias.scale[0] * q.range_m,
          wrap_two_pi(q.azimuth_rad + bias.offset.azimuth_rad + bias.scale[1] * from_south),
          q.elevation_rad + bias.offset.elevation_rad + bias.scale[2] * q.elevation_rad};
}

double true_range_rate(const RadarScenario& radar, const RadarBias& bias, const score::TruthFunction& truth, Time t) {
  RadarBias displacement;  // what acts before the instrument's own errors
  displacement.sez_offset_m = bias.sez_offset_m;
  displacement.sez_scale = bias.sez_scale;
  const Atmosphere atmosphere = atmosphere_over(radar.site.geodetic(), radar.refractivity);
  constexpr double step_s = 0.01;
  const auto state = truth(t);
  if (!state) return 0;
  const Eigen::Vector3d step_m = step_s * state->velocity.m_s;
  const auto range_at = [&](double sign) {
    return biased(radar.site.enu_of({state->position.m + sign * step_m}), displacement, atmosphere).range_m;
  };
  return (range_at(1) - range_at(-1)) / (2 * step_s);
}

RadarRun simulate_radar(const RadarScenario& radar, const Scenario& scenario, const score::TruthFunction& truth,
                        std::uint64_t seed) {
  RadarRun run{draw_bias(radar, seed), {}, {}};
  RandomStream white(seed, stream_name("radar/white", radar.id));
  RandomStream slow(seed, stream_name("radar/coloured", radar.id));
  RandomStream faults(seed, stream_name("radar/faults", radar.id));
  RandomStream network(seed, stream_name("radar/network", radar.id));
  RandomStream doppler(seed, stream_name("radar/range_rate", radar.id));
  const double step_s = 1 / radar.rate_hz;
  ColouredNoise slow_azimuth(slow, radar.coloured_angle_sigma_rad, radar.coloured_angle_tau_s, step_s);
  ColouredNoise slow_elevation(slow, radar.coloured_angle_sigma_rad, radar.coloured_angle_tau_s, step_s);
  const Atmosphere atmosphere = atmosphere_over(radar.site.geodetic(), radar.refractivity);
  OrderedLink link;

  for (const double t_s : sample_times(radar.rate_hz, radar.phase_s, radar.track)) {
    // Every plot draws all its numbers, seen or not, so that the next plot's do not depend on it.
    const double range_noise = radar.sigma.range_m * white.normal();
    const double azimuth_white = radar.sigma.azimuth_rad * white.normal();
    const double azimuth_slow = slow_azimuth.next();
    const double elevation_noise = radar.sigma.elevation_rad * white.normal() + slow_elevation.next();
    const bool dropped = faults.uniform() < radar.dropout_probability;
    const bool outlier = faults.uniform() < radar.outlier_probability;
    const Polar outlier_error{outlier_size(faults, radar.outlier_range_m),
                              outlier_size(faults, radar.outlier_angle_rad),
                              outlier_size(faults, radar.outlier_angle_rad)};
    const double range_rate_noise = radar.sigma_range_rate_m_s * doppler.normal();
    const double delay_s = radar.latency_s + radar.latency_jitter_s * network.uniform(-1, 1);

    const Time true_time = scenario.liftoff + seconds(t_s - run.bias.time_tag_s);
    const std::optional<score::TrueState> state = truth(true_time);
    if (!state || dropped || inside(radar.outages, t_s)) continue;
    const Displacement<Enu> d_enu = radar.site.enu_of(state->position);
    const Polar q = polar_from_enu(d_enu);
    const bool visible = q.elevation_rad >= radar.elevation_min_rad && q.range_m <= radar.range_max_m;
    if (!visible) continue;

    RadarTspi plot;
    plot.sensor = radar.id;
    plot.target = scenario.target;
    plot.sequence = run.plots.size() + 1;
    plot.epoch = scenario.liftoff + seconds(t_s);
    plot.received = link.deliver(true_time, delay_s);
    plot.measured = biased(d_enu, run.bias, atmosphere);
    plot.measured.range_m += range_noise;
    plot.measured.azimuth_rad += axis_error(azimuth_white, radar.azimuth_sigma_on_sky, q.elevation_rad) +
                                 axis_error(azimuth_slow, radar.coloured_on_sky, q.elevation_rad);
    plot.measured.elevation_rad += elevation_noise;
    if (outlier) {
      plot.measured.range_m += outlier_error.range_m;
      plot.measured.azimuth_rad += outlier_error.azimuth_rad;
      plot.measured.elevation_rad += outlier_error.elevation_rad;
      run.outlier_sequences.push_back(plot.sequence);
    }
    for (const RadarFault& fault : radar.faults) {
      if (!inside(fault.when, t_s)) continue;
      plot.measured.range_m = fault.range_factor * plot.measured.range_m + fault.range_offset_m;
      plot.measured.azimuth_rad = fault.azimuth_factor * plot.measured.azimuth_rad + fault.azimuth_offset_rad;
      plot.measured.elevation_rad += fault.elevation_offset_rad;
    }
    plot.measured.azimuth_rad = wrap_two_pi(plot.measured.azimuth_rad);
    plot.range_rate_valid = radar.sigma_range_rate_m_s > 0;
    if (plot.range_rate_valid)
      plot.range_rate_m_s =
          true_range_rate(radar, run.bias, truth, true_time) + radar.range_rate_offset_m_s + range_rate_noise;
    plot.snr_valid = true;
    plot.snr_db = 20 - 20 * std::log10(q.range_m / 1e6);  // beacon: one-way loss, 20 dB at 1 000 km
    plot.range_valid = radar.measures.range;
    plot.azimuth_valid = plot.elevation_valid = radar.measures.angles;
    if (!plot.range_valid) plot.measured.range_m = 0;
    if (!radar.measures.angles) plot.measured.azimuth_rad = plot.measured.elevation_rad = 0;
    plot.simulated = scenario.simulated;
    run.plots.push_back(plot);
  }
  return run;
}

std::vector<AngleTspi> simulate_angles(const RadarScenario& sensor, const Scenario& scenario,
                                       const score::TruthFunction& truth, std::uint64_t seed) {
  std::vector<AngleTspi> angles;
  for (const RadarTspi& plot : simulate_radar(sensor, scenario, truth, seed).plots)
    angles.push_back({.sensor = plot.sensor,
                      .target = plot.target,
                      .sequence = plot.sequence,
                      .epoch = plot.epoch,
                      .received = plot.received,
                      .azimuth_rad = plot.measured.azimuth_rad,
                      .elevation_rad = plot.measured.elevation_rad,
                      .mode = plot.mode,
                      .simulated = plot.simulated});
  return angles;
}

std::vector<GpsFix> simulate_gps(const Scenario& scenario, const score::TruthFunction& truth, std::uint64_t seed) {
  const std::vector<GpsFix> fixes = receiver_fixes(scenario, truth, seed);
  std::vector<GpsFix> relayed;
  for (const StationScenario& station : scenario.stations) {
    RandomStream random(seed, stream_name("station", station.id));
    OrderedLink link;
    std::uint64_t sequence = 0;
    for (const GpsFix& fix : fixes) {
      const bool lost = random.uniform() < station.loss_probability;
      const double delay_s = scenario.gps.latency_s + station.delay_s + station.delay_jitter_s * random.uniform(-1, 1);
      const double t_s = (fix.epoch - scenario.liftoff).seconds();
      const Time sent = fix.epoch;
      const std::optional<score::TrueState> state = truth(sent);
      const bool visible =
          polar_from_enu(station.site.enu_of(state->position)).elevation_rad >= station.elevation_min_rad;
      if (lost || !visible || inside(station.outages, t_s)) continue;
      GpsFix copy = fix;
      copy.station = station.id;
      copy.sequence = ++sequence;
      copy.received = link.deliver(sent, delay_s);
      relayed.push_back(copy);
    }
  }
  return relayed;
}

}  // namespace downrange::sim
