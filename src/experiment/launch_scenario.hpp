#pragma once
/// The launch scenario of est/THEORY.md section 10: its truth, computed once, and the measurements of each run.

#include <array>
#include <cstdint>
#include <downrange/est/method/bound.hpp>
#include <downrange/est/method/method.hpp>
#include <span>
#include <string_view>
#include <vector>

#include "sim/scenario.hpp"

namespace downrange::experiment::launch {

inline constexpr int radars = 2;
inline constexpr std::array<std::string_view, radars> radar_names{"goheung", "jeju"};
inline constexpr double first_fix_s = 80.4;
inline constexpr double fix_interval_s = 1;
inline constexpr double tracking_from_s = 100;
inline constexpr double end_s = 480;
inline constexpr double gps_lost_s = 370;
inline constexpr double time_tag_s = 5e-3;

/// The figures' windows.
[[nodiscard]] const std::array<score::Phase, 3>& windows();

/// What the radars' true biases are, and what of the GPS there is.
enum class Case : std::uint8_t {
  Base,         ///< polar biases, GPS to the end
  GpsLost,      ///< the same data, no fix from 370 s on
  WrongBlocks,  ///< offsets and scales along south, east, zenith
  TimeTag,      ///< polar biases, and stamps 5 ms late
};

/// Bias by BiasTerm; entries of all terms, zero where there is none.
using BiasVector = Eigen::Matrix<double, bias_term_count, 1>;

/// What all runs share of one measurement, whatever its case.
struct Instant {
  double t_s = 0;       ///< after lift-off
  bool is_plot = true;  ///< else a fix
  int source = 0;
  Vec<9> motion = Vec<9>::Zero();  ///< true position, velocity, acceleration, ECEF
  Displacement<Enu> from_radar{};  ///< true, of a plot
};

/// One run's measurements: those of `Scene::instants`, in that order.
struct Drawn {
  std::vector<Measurement> measurements;
  std::array<sim::RadarBias, radars> bias;
  Vec<9> start_error = Vec<9>::Zero();
};

/// Read-only once made: shared by the threads.
class Scene {
 public:
  Scene();

  /// In order of epoch.
  [[nodiscard]] const std::vector<Instant>& instants() const { return instants_; }
  /// Noise is the same in every case: cases differ by what they are named for only.
  [[nodiscard]] Drawn draw(Case which, std::uint64_t seed, int run) const;
  [[nodiscard]] Vec<9> motion(Time t) const;
  [[nodiscard]] Time liftoff() const { return scenario_.liftoff; }
  [[nodiscard]] const Site& site(int radar) const { return scenario_.radars[static_cast<std::size_t>(radar)].site; }

  /// What every method is given: R as it is and not learnt, no gate, no GPS error states, no regime without GPS, no
  /// history (nothing is late), GPS without velocity; song2015 with the paper's windowed process noise alone.
  [[nodiscard]] MethodSettings settings(Kinematics kinematics, const BiasModel& bias) const;

 private:
  sim::Scenario scenario_;
  sim::LaunchTrajectory trajectory_;
  std::vector<Instant> instants_;
};

/// 1-sigma of the first estimate: 100 m, 100 m/s, 20 m/s^2.
[[nodiscard]] Mat<9, 9> start_covariance();

[[nodiscard]] BiasVector bias_vector(const sim::RadarBias& bias);

/// Where a plot of a target truly at `instant` is put by a radar of true bias `truth` once `term`, `value` were taken
/// out of it: displacement from the true position, in the radar's axes.
[[nodiscard]] Displacement<Enu> bias_left(const Instant& instant, const sim::RadarBias& truth, const Site& site,
                                          std::span<const BiasTerm> term, std::span<const double> value);

}  // namespace downrange::experiment::launch
