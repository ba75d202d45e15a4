#pragma once
/// What every method asks of a source: GPS noise, the frozen receiver, the account of verdicts and innovations, the
/// state of bias terms.

#include <downrange/est/method.hpp>
#include <span>

namespace downrange {

/// Rejected fixes in a row after which a track starts again on the receiver: at 1 Hz one that returns wins in 5 s.
inline constexpr int gps_restart_after = 5;

/// Position covariance of a fix, ECEF, m^2.
[[nodiscard]] Mat<3, 3> fix_covariance(const Measurement& fix);

/// The last fix of a receiver, and the track's velocity when it first gave that fix: what follows may be made of the
/// repeated fixes themselves and is no witness.
struct LastFix {
  Position<Ecef> position;
  Velocity<Ecef> velocity;
  Time since;
  Velocity<Ecef> track_velocity;
  double sigma_velocity_m_s = 0;
};

[[nodiscard]] bool repeats(const Measurement& fix, const LastFix& last);

/// The receiver repeats its fix to the last bit although the vehicle, moving as it did at the first of them, is
/// elsewhere: further than 3 sigma and a metre. A repeat at rest is a repeat, not a fault.
[[nodiscard]] bool is_frozen(const Measurement& fix, const LastFix& last);

/// To be called with every fix, after it was used: `track_velocity` with `cov` is what the track then knows.
void remember(LastFix& last, const Measurement& fix, const Vec<3>& track_velocity, const Mat<3, 3>& cov);

/// Bit i: source i contributed (newest accepted measurement in `contributed`) within the last second before `now`.
[[nodiscard]] std::uint64_t recent_sources(std::span<const Time> contributed, Time now);

/// Counts what became of one measurement. What was weighed (dof > 0) tells the mismatch alarm, the gated ones too: of a
/// wrong model they are the evidence.
void count(SourceAccount& account, const Outcome& outcome);

/// The innovation of an accepted measurement, with its covariance, into the running statistics.
template <int M>
void note_innovation(SourceAccount& account, const Vec<M>& nu, const Mat<M, M>& S, double nis) {
  const Vec<M> normalised = nu.cwiseQuotient(S.diagonal().cwiseSqrt());
  account.residual.add(normalised.mean(), normalised.squaredNorm() / M, nis / M);
}

/// State of each term: frozen, or not observable (sigma above 0.7 of its prior, or correlation above 0.99 with another
/// term), or converged (below 0.2 of its prior), else estimating. `prior_sigma` holds `terms` entries.
[[nodiscard]] std::array<BiasState, BiasEstimate::max_terms> bias_states(
    const BiasEstimate& bias, const Vec<BiasEstimate::max_terms>& prior_sigma, bool frozen);

}  // namespace downrange
