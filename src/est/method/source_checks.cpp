#include <algorithm>
#include <cmath>
#include <downrange/est/method/source_checks.hpp>
#include <downrange/est/model/plot_model.hpp>
#include <downrange/est/model/slow_pointing.hpp>
#include <utility>

namespace downrange {

Gaussian<9> first_motion(const Measurement& m, const MethodSettings& settings, const Vec<bias_term_count>& bias) {
  Gaussian<9> motion{.mean = Vec<9>::Zero(), .cov = Mat<9, 9>::Zero()};
  double velocity_sigma = settings.start.sigma_velocity_m_s;
  if (is_fix(m)) {
    const Fix& fix = fix_of(m);
    motion.mean.head<3>() = fix.position.m;
    const double sigma = std::max(fix.sigma_horizontal_m, fix.sigma_vertical_m);
    const double slow = settings.gps.error.enabled ? settings.gps.error.sigma_m : 0;
    motion.cov.diagonal().head<3>().setConstant(sigma * sigma + slow * slow);
    if (fix.velocity_valid && settings.gps_use.velocity) {
      motion.mean.segment<3>(3) = fix.velocity.m_s;
      velocity_sigma = fix.sigma_velocity_m_s;
    }
  } else {
    const RadarModel& radar = settings.radars[static_cast<std::size_t>(m.source)];
    std::array<BiasTerm, bias_term_count> terms{};
    for (std::size_t i = 0; i < terms.size(); ++i) terms[i] = static_cast<BiasTerm>(i);
    const Polar plot =
        without_refraction(radar, compensate(plot_of(m.measured).measured, terms, {bias.data(), terms.size()}));
    const ConvertedMeasurement converted = convert_unbiased(plot, radar.sigma);
    const Mat<3, 3> R_ecef_enu = radar.site.R_enu_ecef().R.transpose();
    motion.mean.head<3>() = radar.site.ecef_of(converted.z).m;
    motion.cov.topLeftCorner<3, 3>() = R_ecef_enu * converted.R * R_ecef_enu.transpose();
  }
  motion.cov.diagonal().segment<3>(3).setConstant(velocity_sigma * velocity_sigma);
  motion.cov.diagonal().tail<3>().setConstant(std::pow(settings.start.sigma_acceleration_m_s2, 2));
  return motion;
}

bool is_frozen(LastFix& last, const Measurement& m, const TrackVelocity& track) {
  constexpr double sigmas = 3;
  constexpr double reporting_quantum_m = 1;
  constexpr int too_often = 3;
  const Fix& fix = fix_of(m);
  if (last.times == 0 || fix.position.m != last.position.m) {
    last = {.position = fix.position, .since = m.epoch, .times = 1, .track = track};
    return false;
  }
  ++last.times;
  const double dt = (m.epoch - last.since).seconds();
  const double of_fix =
      2 * fix.sigma_horizontal_m * fix.sigma_horizontal_m + fix.sigma_vertical_m * fix.sigma_vertical_m;
  const double of_velocity = last.track.sigma_m_s * dt;
  if (last.track.m_s.norm() * dt > sigmas * std::sqrt(of_fix + of_velocity * of_velocity) + reporting_quantum_m)
    return true;
  if (last.times < too_often) return false;
  const auto moves = [dt](const TrackVelocity& v) {
    return (v.m_s.norm() - sigmas * v.sigma_m_s) * dt > reporting_quantum_m;
  };
  const TrackVelocity stated{.m_s = fix.velocity.m_s, .sigma_m_s = std::sqrt(3) * fix.sigma_velocity_m_s};
  // At its very lift-off a vehicle moves less than some receivers resolve.
  const bool in_flight = m.in_flight && dt >= 1;
  return in_flight || (fix.velocity_valid && moves(stated)) || moves(track) || moves(last.track);
}

MethodSettings with_wander_as_states(MethodSettings settings) {
  settings.radars = with_wander_as_states(std::move(settings.radars));
  return settings;
}

std::vector<SourceAccount> accounts_of(const MethodSettings& settings, bool knows_wander) {
  std::vector<SourceAccount> accounts(settings.radars.size() + static_cast<std::size_t>(settings.stations));
  for (std::size_t i = 0; i < settings.radars.size(); ++i) {
    const RadarModel& radar = settings.radars[i];
    accounts[i].noise = NoiseScale::of_radar(radar.angle_inflation, knows_wander);
  }
  return accounts;
}

void note_part(SourceAccount& account, const Outcome& outcome) {
  const bool tested = outcome.verdict == Verdict::Accepted || outcome.verdict == Verdict::Gated;
  if (tested && outcome.dof > 0) account.mismatch.add(outcome.nis, outcome.dof);
}

void count(SourceAccount& account, const Outcome& outcome) {
  note_part(account, outcome);
  switch (outcome.verdict) {
    case Verdict::Accepted:
      ++account.accepted;
      account.rejected_in_row = 0;
      return;
    case Verdict::Frozen:
      ++account.frozen;
      break;
    case Verdict::Gated:
    case Verdict::Singular:
      ++account.gated;
      break;
  }
  ++account.rejected_in_row;
}

std::array<BiasState, BiasEstimate::max_terms> bias_states(const BiasEstimate& bias,
                                                           const Vec<BiasEstimate::max_terms>& prior_sigma,
                                                           bool frozen) {
  constexpr double hardly_below = 0.7;
  constexpr double well_below = 0.2;
  constexpr double alike = 0.99;
  std::array<BiasState, BiasEstimate::max_terms> states{};
  for (int i = 0; i < bias.terms; ++i) {
    const double sigma = std::sqrt(bias.cov(i, i));
    double correlation = 0;
    for (int j = 0; j < bias.terms; ++j) {
      if (j != i) correlation = std::max(correlation, std::abs(bias.cov(i, j)) / (sigma * std::sqrt(bias.cov(j, j))));
    }
    states[static_cast<std::size_t>(i)] = frozen ? BiasState::Frozen
                                          : sigma > hardly_below * prior_sigma[i] || correlation > alike
                                              ? BiasState::NotObservable
                                          : sigma < well_below * prior_sigma[i] ? BiasState::Converged
                                                                                : BiasState::Estimating;
  }
  return states;
}

}  // namespace downrange
