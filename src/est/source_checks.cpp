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

bool repeats(const Measurement& fix, const LastFix& last) {
  return fix.position.m == last.position.m && (!fix.velocity_valid || fix.velocity.m_s == last.velocity.m_s);
}

bool is_frozen(const Measurement& fix, const LastFix& last) {
  if (!repeats(fix, last)) return false;
  constexpr double sigmas = 3;
  constexpr double reporting_quantum_m = 1;
  const double dt = (fix.epoch - last.since).seconds();
  const double of_fix =
      2 * fix.sigma_horizontal_m * fix.sigma_horizontal_m + fix.sigma_vertical_m * fix.sigma_vertical_m;
  const double of_velocity = last.sigma_velocity_m_s * dt;
  return last.track_velocity.m_s.norm() * dt >
         sigmas * std::sqrt(of_fix + of_velocity * of_velocity) + reporting_quantum_m;
}

void remember(LastFix& last, const Measurement& fix, const Vec<3>& track_velocity, const Mat<3, 3>& cov) {
  if (repeats(fix, last)) return;
  last = {.position = fix.position,
          .velocity = fix.velocity,
          .since = fix.epoch,
          .track_velocity = {track_velocity},
          .sigma_velocity_m_s = std::sqrt(cov.trace())};
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
