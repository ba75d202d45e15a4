#include <algorithm>
#include <cmath>
#include <downrange/est/source_checks.hpp>

namespace downrange {

Mat<3, 3> fix_covariance(const Measurement& fix) {
  const double h2 = fix.sigma_horizontal_m * fix.sigma_horizontal_m;
  const double v2 = fix.sigma_vertical_m * fix.sigma_vertical_m;
  const Mat<3, 3> R_ecef_enu = enu_from_ecef_at(geodetic_from_ecef(fix.position)).R.transpose();
  return R_ecef_enu * Vec<3>(h2, h2, v2).asDiagonal() * R_ecef_enu.transpose();
}

bool is_frozen(LastFix& last, const Measurement& fix, const TrackVelocity& track) {
  constexpr double sigmas = 3;
  constexpr double reporting_quantum_m = 1;
  constexpr int too_often = 3;
  if (last.times == 0 || fix.position.m != last.position.m) {
    last = {.position = fix.position, .since = fix.epoch, .times = 1, .track = track};
    return false;
  }
  ++last.times;
  const double dt = (fix.epoch - last.since).seconds();
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
  const bool in_flight = fix.in_flight && dt >= 1;
  return in_flight || (fix.velocity_valid && moves(stated)) || moves(track) || moves(last.track);
}

std::uint64_t recent_sources(std::span<const Time> contributed, Time now) {
  std::uint64_t mask = 0;
  for (std::size_t i = 0; i < contributed.size(); ++i) {
    if (now - contributed[i] <= milliseconds(1000)) mask |= std::uint64_t{1} << i;
  }
  return mask;
}

void count(SourceAccount& account, const Outcome& outcome) {
  const bool weighed = outcome.verdict == Verdict::Accepted || outcome.verdict == Verdict::Gated;
  if (weighed && outcome.dof > 0) account.mismatch.add(outcome.nis, outcome.dof);
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
