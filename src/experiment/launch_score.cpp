#include "experiment/launch_score.hpp"

#include <algorithm>
#include <cmath>
#include <span>
#include <utility>

namespace downrange::experiment::launch {
namespace {

/// Windows and second that an instant counts for.
class Place {
 public:
  Place(Score& score, const Instant& instant) : second_(score.second[second_of(instant)]) {
    for (std::size_t i = 0; i < windows().size(); ++i) {
      if (windows()[i].from_s <= instant.t_s && instant.t_s < windows()[i].to_s) window_[count_++] = &score.window[i];
    }
    const double since_fix_s = std::fmod(instant.t_s - first_fix_s, fix_interval_s);
    bin_ = std::min(static_cast<std::size_t>(since_fix_s / fix_interval_s * ripple_bins), std::size_t{ripple_bins - 1});
  }

  void add_position(double square) {
    second_.position.add(square);
    each([&](WindowScore& w) { w.errors.position.add(square); });
  }
  void add_bias_left(int radar, double square) {
    const auto i = static_cast<std::size_t>(radar);
    second_.bias_left[i].add(square);
    each([&](WindowScore& w) {
      w.errors.bias_left[i].add(square);
      w.ripple[bin_].add(square);
    });
  }
  template <class Use>
  void each(const Use& use) {
    for (std::size_t i = 0; i < count_; ++i) use(*window_[i]);
  }
  [[nodiscard]] bool in_window() const { return count_ > 0; }

 private:
  static std::size_t second_of(const Instant& instant) {
    return static_cast<std::size_t>(std::clamp(instant.t_s - tracking_from_s, 0.0, seconds_shown - 1.0));
  }

  Errors& second_;
  std::array<WindowScore*, 3> window_{};
  std::size_t count_ = 0;
  std::size_t bin_ = 0;
};

std::span<const BiasTerm> terms_of(const BiasEstimate& bias) {
  return {bias.term.data(), static_cast<std::size_t>(bias.terms)};
}
std::span<const double> values_of(const BiasEstimate& bias) {
  return {bias.value.data(), static_cast<std::size_t>(bias.terms)};
}

/// Normalised squared error of the terms. None where the radar has biases that are not among them.
std::optional<double> bias_nees(const BiasEstimate& bias, const BiasVector& truth) {
  using Terms = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, BiasEstimate::max_terms, 1>;
  using Covariance =
      Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, BiasEstimate::max_terms, BiasEstimate::max_terms>;
  BiasVector unexplained = truth;
  Terms error(bias.terms);
  for (int i = 0; i < bias.terms; ++i) {
    const auto term = static_cast<Eigen::Index>(bias.term[static_cast<std::size_t>(i)]);
    error[i] = bias.value[i] - truth[term];
    unexplained[term] = 0;
  }
  if (bias.terms == 0 || unexplained.any()) return std::nullopt;
  const Covariance cov = bias.cov.topLeftCorner(bias.terms, bias.terms);
  // Metres and scales of 1e-5 side by side: solved in units of sigma.
  const Terms sigma = cov.diagonal().cwiseSqrt();
  const Covariance correlation = sigma.cwiseInverse().asDiagonal() * cov * sigma.cwiseInverse().asDiagonal();
  const Terms normalised = error.cwiseQuotient(sigma);
  return normalised.dot(correlation.llt().solve(normalised));
}

PlotResidual residual_of(const Measurement& m, const Instant& instant, const Method& method, const RadarModel& radar) {
  const TrackEstimate track = method.fused(0, m.epoch).value();
  const BiasEstimate bias = method.bias(m.source);
  const Displacement<Enu> d_enu = radar.site.enu_of({track.mean.head<3>()});
  const Polar predicted = polar_from_enu(d_enu);
  const Polar plot = compensate(plot_of(m.measured).measured, terms_of(bias), values_of(bias));
  const Mat<3, 3> H = d_polar_d_enu(d_enu) * radar.site.R_enu_ecef().R;
  const Vec<3> sigma(radar.sigma.range_m, radar.sigma.azimuth_rad, radar.sigma.elevation_rad);
  const Mat<3, 3> S = H * track.cov.topLeftCorner<3, 3>() * H.transpose() + Mat<3, 3>(sigma.cwiseAbs2().asDiagonal());
  return {{.t_s = instant.t_s,
           .value = {plot.range_m - predicted.range_m, wrap_pi(plot.azimuth_rad - predicted.azimuth_rad),
                     plot.elevation_rad - predicted.elevation_rad},
           .sigma = S.diagonal().cwiseSqrt()},
          m.source};
}

void score_plot(Place& place, const Measurement& m, const Instant& instant, const Method& method, const Scene& scene,
                const sim::RadarBias& truth) {
  const TrackEstimate track = method.fused(0, m.epoch).value();
  const Vec<3> error = track.mean.head<3>() - instant.motion.head<3>();
  place.add_position(error.squaredNorm());
  const BiasEstimate bias = method.bias(m.source);
  place.add_bias_left(m.source,
                      bias_left(instant, truth, scene.site(m.source), terms_of(bias), values_of(bias)).m.squaredNorm());
  if (!place.in_window()) return;
  const std::optional<double> nees = bias_nees(bias, bias_vector(truth));
  place.each([&](WindowScore& w) {
    for (int axis = 0; axis < 3; ++axis) w.two_sigma.add(std::abs(error[axis]) < 2 * std::sqrt(track.cov(axis, axis)));
    if (nees) w.bias_nees.add(score::inside_95(*nees, bias.terms));
  });
}

/// d(bias_left)/d(value of each term) of an unbiased radar, by central differences.
Eigen::Matrix3Xd d_bias_left(const Instant& instant, const Site& site, const BiasModel& bias) {
  Eigen::Matrix3Xd J(3, static_cast<Eigen::Index>(bias.terms.size()));
  std::vector<double> value(bias.terms.size());
  for (std::size_t i = 0; i < value.size(); ++i) {
    const auto term = static_cast<Eigen::Index>(bias.terms[i]);
    const double step = 1e-3 * std::sqrt(bias.prior_cov(term, term));
    const auto left_with = [&](double v) {
      value[i] = v;
      return bias_left(instant, {}, site, bias.terms, value).m;
    };
    J.col(static_cast<Eigen::Index>(i)) = (left_with(step) - left_with(-step)) / (2 * step);
    value[i] = 0;
  }
  return J;
}

/// `instant` moved on to the one of `m`: a case may lack fixes.
void move_on(std::vector<Instant>::const_iterator& instant, const Measurement& m, Time liftoff) {
  const auto is_of = [&](const Instant& i) { return i.source == m.source && liftoff + seconds(i.t_s) == m.epoch; };
  while (!is_of(*instant)) ++instant;
}

}  // namespace

Errors& Errors::operator+=(const Errors& other) {
  position += other.position;
  for (std::size_t i = 0; i < bias_left.size(); ++i) bias_left[i] += other.bias_left[i];
  return *this;
}

WindowScore& WindowScore::operator+=(const WindowScore& other) {
  errors += other.errors;
  nis += other.nis;
  two_sigma += other.two_sigma;
  bias_nees += other.bias_nees;
  for (std::size_t i = 0; i < ripple.size(); ++i) ripple[i] += other.ripple[i];
  return *this;
}

Score& Score::operator+=(const Score& other) {
  for (std::size_t i = 0; i < window.size(); ++i) window[i] += other.window[i];
  for (std::size_t i = 0; i < second.size(); ++i) second[i] += other.second[i];
  return *this;
}

Score fly(const Contestant& contestant, const Scene& scene, const Drawn& drawn, std::vector<PlotResidual>* residuals) {
  const MethodSettings settings = scene.settings(contestant.kinematics, contestant.bias);
  const std::unique_ptr<Method> method = make_method(contestant.method, settings);
  const auto starts_track = [&](const Measurement& m) { return !contestant.starts_with_plot || !is_fix(m); };
  const Time start = std::find_if(drawn.measurements.begin(), drawn.measurements.end(), starts_track)->epoch;
  method->start(0, start, {.mean = scene.motion(start) + drawn.start_error, .cov = start_covariance()});

  Score score;
  auto instant = scene.instants().begin();
  for (const Measurement& m : drawn.measurements) {
    const bool plot = !is_fix(m);
    if (!plot && !contestant.gets_fixes) continue;
    move_on(instant, m, scene.liftoff());
    Place place(score, *instant);
    if (residuals != nullptr && plot && place.in_window())
      residuals->push_back(residual_of(m, *instant, *method, settings.radars[static_cast<std::size_t>(m.source)]));
    const Outcome outcome = method->process(m, m.epoch);
    if (outcome.dof > 0) place.each([&](WindowScore& w) { w.nis.add(score::inside_95(outcome.nis, outcome.dof)); });
    if (plot) score_plot(place, m, *instant, *method, scene, drawn.bias[static_cast<std::size_t>(m.source)]);
  }
  return score;
}

Score bound_of(Case which, const BiasModel& bias, const Scene& scene) {
  // Its Jacobians change with the bias of a run by a part in a thousand: it is taken at none.
  Bound bound(
      scene.settings(Kinematics::Ca, bias), [&scene](Time t) { return scene.motion(t); },
      std::vector<BiasVector>(radars, BiasVector::Zero()));
  const std::vector<Measurement> measurements = scene.draw(which, 0, 0).measurements;
  bound.start(measurements.front().epoch, start_covariance());
  Score score;
  auto instant = scene.instants().begin();
  for (const Measurement& m : measurements) {
    bound.apply(m);
    if (is_fix(m)) continue;
    move_on(instant, m, scene.liftoff());
    Place place(score, *instant);
    place.add_position(bound.track_covariance().topLeftCorner<3, 3>().trace());
    const Eigen::Matrix3Xd J = d_bias_left(*instant, scene.site(m.source), bias);
    place.add_bias_left(m.source, (J * bound.bias_covariance(m.source) * J.transpose()).trace());
  }
  return score;
}

}  // namespace downrange::experiment::launch
