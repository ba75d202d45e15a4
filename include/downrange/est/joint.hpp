#pragma once
/// One filter for everything: kinematics of the targets, biases of the radars, coloured error of the GPS. Every plot
/// and fix is processed one by one in time order: the optimum of its class (ALGORITHMS.md, method `joint`).

#include <Eigen/Core>
#include <array>
#include <downrange/est/method.hpp>
#include <downrange/est/source_checks.hpp>

namespace downrange {

/// Extended Kalman filter over the whole range. State vector, blocks in this order:
///
///  per target, 12 entries: position x y z (m, ECEF); velocity (m/s); acceleration (m/s^2, white jerk); slowly varying
///  GPS error x y z (m, ECEF, first-order Gauss-Markov): fix = position + error + noise.
///
///  per radar, 10 entries: offsets of range (m), azimuth, elevation (rad); scales of the same (1, azimuth about south);
///  offsets of the site south, east, zenith (m); time tag (s). measured(t) = true(t - time tag) + bias.
///
/// Plots are used as measured (range, azimuth, elevation), linearised at the bias-compensated prediction: linearising
/// at the plot drifts 20-30 % off the bound.
class Joint {
 public:
  static constexpr int target_size = 12;
  static constexpr int radar_size = 10;
  /// What intermediate results on the stack are sized for.
  static constexpr int max_targets = 8;
  static constexpr int max_radars = 64;
  static constexpr int max_states = max_targets * target_size + max_radars * radar_size;

  struct Target {
    bool started = false;
    Time data_epoch;  ///< newest accepted measurement
    std::array<Time, max_radars> contributed{};
    LastFix last_fix;
    double nis = 0;
    int nis_dof = 0;
    int plots_rejected_in_row = 0;
    int fixes_rejected_in_row = 0;
  };
  struct Radar {
    Time epoch;    ///< newest accepted plot
    Time updated;  ///< newest accepted plot while GPS was there
    std::uint64_t samples = 0;
    bool referenced = false;
  };
  struct State {
    bool started = false;
    Time epoch;  ///< of x and P
    Eigen::VectorXd x;
    Eigen::MatrixXd P;
    std::vector<Target> targets;
    std::vector<Radar> radars;
    std::optional<Time> last_fix;
    std::vector<SourceAccount> accounts;
  };

  /// Throws std::invalid_argument for more than max_targets or max_radars.
  explicit Joint(MethodSettings settings);

  [[nodiscard]] State initial() const;
  Outcome apply(State& state, const Measurement& m) const;
  void start(State& state, int target, Time epoch, const Gaussian<9>& estimate) const;

  [[nodiscard]] const MethodSettings& settings() const { return settings_; }
  /// First index of a target's and a radar's block.
  [[nodiscard]] int target_at(int target) const { return target_size * target; }
  [[nodiscard]] int radar_at(int radar) const { return target_size * settings_.targets + radar_size * radar; }

  /// Position, velocity and acceleration of a started target, predicted by dt seconds (either sign).
  [[nodiscard]] Gaussian<9> kinematics(const State& state, int target, double dt) const;
  [[nodiscard]] BiasEstimate describe(const State& state, int radar) const;

 private:
  void predict(State& s, Time t) const;
  void start_target(State& s, const Measurement& m) const;
  void open_radar(State& s, int radar) const;
  Outcome apply_fix(State& s, const Measurement& m) const;
  Outcome apply_plot(State& s, const Measurement& m) const;
  void after_rejection(State& s, const Measurement& m, Verdict verdict) const;
  [[nodiscard]] int source_of(const Measurement& m) const;

  MethodSettings settings_;
  double gate3_;
  double gate6_;
};

}  // namespace downrange
