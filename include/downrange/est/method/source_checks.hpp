#pragma once
/// What every method asks of a source: a target's first motion, the frozen receiver, the account of verdicts and
/// innovations, the state of bias terms.

#include <cmath>
#include <downrange/est/method/method.hpp>
#include <limits>
#include <span>

namespace downrange {

/// What a track says of its own velocity, all axes together.
struct TrackVelocity {
  Vec<3> m_s = Vec<3>::Zero();
  double sigma_m_s = std::numeric_limits<double>::infinity();
};

/// The velocity of a motion (position, velocity, acceleration), as the check for frozen receivers takes it.
[[nodiscard]] inline TrackVelocity velocity_of(const Gaussian<9>& motion) {
  return {.m_s = motion.mean.segment<3>(3), .sigma_m_s = std::sqrt(motion.cov.block<3, 3>(3, 3).trace())};
}

/// The last position of a receiver, and the track's velocity when it first gave it: what follows may be made of the
/// repeated fixes themselves.
struct LastFix {
  Position<Ecef> position;
  Time since;
  int times = 0;
  TrackVelocity track;
};

/// Notes the fix, to be called with every one before it is used, and tells whether the receiver is frozen: its position
/// is that of the fixes before, to the last bit,
/// - although the vehicle, moving as it did at the first of them, is elsewhere, further than 3 sigma and a metre;
/// - or for the third time although the vehicle moves: it is in flight, or by the fix's own velocity, or by the track's
///   at the first of them or now.
/// A repeat at rest is a repeat, not a fault.
[[nodiscard]] bool is_frozen(LastFix& last, const Measurement& m, const TrackVelocity& track);

/// What one measurement that tells a position says of the motion of a target that nothing is known of yet. Of a plot:
/// with the bias (indexed by BiasTerm) taken out, and its noise only; what is not known of the bias is for
/// `tie_to_bias`.
[[nodiscard]] Gaussian<9> first_motion(const Measurement& m, const MethodSettings& settings,
                                       const Vec<bias_term_count>& bias);

/// The same with its radars as a method sees them that has states of wander (model/slow_pointing.hpp).
[[nodiscard]] MethodSettings with_wander_as_states(MethodSettings settings);

/// By source id, of sources that have told nothing yet. `knows_wander`: the method has the wander of mounts as states.
[[nodiscard]] std::vector<SourceAccount> accounts_of(const MethodSettings& settings, bool knows_wander);

/// Counts what became of one measurement. What was weighed (dof > 0) tells the mismatch alarm, the gated ones too: of a
/// wrong model they are the evidence.
void count(SourceAccount& account, const Outcome& outcome);

/// A part of a plot that is judged by itself, its range rate, tells the mismatch alarm likewise; the message's verdict
/// is that of its position.
void note_part(SourceAccount& account, const Outcome& outcome);

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
