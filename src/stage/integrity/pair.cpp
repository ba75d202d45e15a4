#include "pair.hpp"

#include <algorithm>
#include <cmath>

namespace downrange::integrity {
namespace {

constexpr Duration short_lag = milliseconds(5000);
constexpr Duration middle_lag = milliseconds(12'000);
constexpr Duration long_lag = milliseconds(30'000);
constexpr Duration least_long_lag = milliseconds(10'000);
constexpr Duration span = milliseconds(6000);  // that a reference is gathered from
/// Of agreement in flight with the biases that GPS taught, after which these count between two sensors on the ground.
/// Taught for longer on the pad, where nothing moves, they are no surer than before: with a receiver too.
constexpr Duration long_proven = milliseconds(60'000);
constexpr int in_a_row = 3;  // from `noticed` on, the last of them beyond the threshold
constexpr double noticed = 0.7;
/// Two in a row are enough where both are this far beyond the threshold and alike.
constexpr int gross_in_a_row = 2;
constexpr double gross = 4;
constexpr double gross_alike = 0.3;
/// A lie keeps its direction; outliers do not.
constexpr double same_direction = 0.5;
/// Below this share of the threshold, 2.5 sigma, nothing speaks of a disagreement.
constexpr double calm = 0.2;
/// Who failed agrees again below this share only: with the time since the reference grows what wander may explain.
constexpr double forgiven = 0.35;
/// The oldest of the references is this old: what two sources drift apart shows against it by then, however slowly they
/// do.
constexpr Duration longest_onset = milliseconds(30'000);
/// Longer than this nobody compares two sources that are both heard.
constexpr Duration unbroken = milliseconds(2500);

}  // namespace

void Pair::renew_references(const Witness& first, const Witness& second, Time at) {
  const auto from = [&](Time t) { return std::max(not_before_, t); };
  const std::array<ReferenceSpan, ages> spans{
      {{.from = from(at - short_lag - span), .to = at - short_lag, .newest = true},
       {.from = from(at - middle_lag - span), .to = at - middle_lag, .newest = true},
       {.from = from(at - long_lag - span), .to = at - least_long_lag, .newest = false}}};
  for (std::size_t i = 0; i < ages; ++i) {
    if (auto found = reference_of(first, second, spans[i], Knowledge::Learnt)) learnt_[i] = *found;
    if (second.is_receiver()) continue;
    if (auto found = reference_of(first, second, spans[i], Knowledge::Prior)) prior_[i] = *found;
  }
}

void Pair::compare(const Witness& first, const Sample& a, const Witness& second, const Sample& b, bool hold,
                   bool elsewhere, bool in_flight, const Threshold& threshold) {
  if (!hold && !fails_ && exceeding_ == 0) renew_references(first, second, a.epoch);
  const TestResult coarse = coarse_test(first, a, second, b, threshold);
  TestResult worst = coarse;
  if (first.is_receiver() && second.is_receiver()) {
    const TestResult steady = steady_test(first, second, a.epoch, threshold);
    if (steady.ratio > worst.ratio) worst = steady;
  }
  if (!compared_) taught_well_since_ = a.epoch;
  if (!in_flight) last_on_pad_ = a.epoch;
  if (!fails_ && exceeding_ == 0) proven_ = proven_at(a.epoch, first.is_receiver());
  for (std::size_t i = 0; i < ages; ++i) {
    if (!learnt_[i]) continue;
    TestResult fine = fine_test(first, a, second, b, *learnt_[i], threshold);
    // A receiver that lies taught the sensors their biases: what these make of each other is not held against them,
    // unless they agreed with it for long.
    if (prior_[i] && fine.ratio >= calm && !proven_) {
      const TestResult untaught = fine_test(first, a, second, b, *prior_[i], threshold);
      if (untaught.ratio < fine.ratio) {
        fine = untaught;
        taught_well_since_ = a.epoch;
      }
    }
    if (fine.ratio > worst.ratio) worst = fine;
  }
  const bool failed = fails_;
  // What disagrees at once is no question of clocks, and would only teach the wrong ones.
  const bool steps = worst.ratio >= 1 || elsewhere;
  if (failed ? by_clock_ : !steps) {
    const TestResult clocks = clock_test_(first, a, second, b, threshold);
    if (!failed) by_clock_ = clocks.ratio >= noticed;
    if (clocks.ratio > worst.ratio) worst = clocks;
  }
  if (!std::isfinite(worst.ratio)) return;
  judge(a.epoch, worst);
  if (by_clock_ && !failed) {
    // Clocks are told late: what they say now has been so since they jumped.
    onset_ = std::min(onset_, clock_test_.since());
    if (fails_) forget(onset_, a.epoch);
  }
  // What was sampled since a slow lie began is no measure: of it one that tells the truth again would differ.
  if (fails_ && !failed) renew_references(first, second, onset_);
  coarsely_ = coarse.ratio >= 1;
}

bool Pair::proven_at(Time at, bool with_receiver) const {
  const bool taught_on_pad = last_on_pad_ && compared_ && *last_on_pad_ - compared_first_ >= long_proven;
  if (taught_on_pad && at - *last_on_pad_ < long_proven) return false;
  return with_receiver || at - taught_well_since_ >= long_proven;
}

void Pair::judge(Time at, const TestResult& result) {
  const double along = result.whitened.dot(whitened_);
  const bool same_way = along >= same_direction * result.whitened.norm() * whitened_.norm();
  const bool alike = (result.whitened - whitened_).norm() <= gross_alike * result.whitened.norm();
  if (result.ratio >= noticed) {
    exceeding_ = exceeding_ > 0 && same_way ? exceeding_ + 1 : 1;
    passing_ = 0;
    if (exceeding_ == 1 && !fails_) {
      onset_ = onset_noticed(at, result.ratio);
      noticed_at_ = at;
    }
    const bool far_beyond = exceeding_ >= gross_in_a_row && result.ratio >= gross && value_ >= gross && alike;
    if ((exceeding_ >= in_a_row && result.ratio >= 1) || far_beyond) fails_ = true;
  } else if (exceeding_ = 0; fails_ && result.ratio >= forgiven) {
    passing_ = 0;
  } else {
    if (++passing_ == 1) agrees_since_ = at;
    if (fails_ && passing_ >= in_a_row) {
      fails_ = false;
      not_before_ = agrees_since_;
    }
  }
  if (result.ratio < calm || !compared_) calm_ = at;
  if (!compared_) compared_first_ = at;
  whitened_ = result.whitened;
  apart_m_ = result.apart_m;
  value_before_ = value_;
  value_ = result.ratio;
  compared_before_ = compared_;
  compared_ = at;
}

Time Pair::onset_noticed(Time at, double ratio) const {
  if (!compared_) return at;
  // Not noticed before and gross now: a step; where they were not compared for a while, one that came meanwhile.
  if (ratio >= gross && value_ < noticed) return at - *compared_ <= unbroken ? at : *compared_;
  if (at - calm_ > longest_onset) return std::max(at - longest_onset, compared_first_);
  // Where it grows steadily it began before it was noticeable.
  const double growth = std::sqrt(calm) / (1 - std::sqrt(calm));
  return std::max(calm_ - seconds(growth * (at - calm_).seconds()), compared_first_);
}

double Pair::doubt_since(Time onset) const {
  if (!compared_before_ || *compared_before_ <= onset) return 0;
  return std::min(value_, value_before_);
}

void Pair::forget(Time from, Time until) {
  not_before_ = std::max(not_before_, until);
  for (auto* references : {&learnt_, &prior_}) {
    for (std::optional<Reference>& r : *references) {
      if (r && r->epoch >= from && r->epoch < until) r.reset();
    }
  }
}

Duration Pair::agreement() const { return compared_ && passing_ > 0 ? *compared_ - agrees_since_ : Duration{0}; }

double clock_acquittal(std::span<const Pair> pairs, const Pair& disagreement, int accused, int third) {
  const std::optional<ClocksApart> apart = disagreement.clocks();
  if (!apart) return 0;
  // Fast by, if it is the one that is wrong.
  const auto fast_s = [&](int witness) { return disagreement.second() == witness ? apart->by_s : -apart->by_s; };
  // chi2 of what the third sees: this one wrong, less: this one right.
  const auto chi2_of_wrong = [&](int witness) {
    for (const Pair& p : pairs) {
      const std::optional<ClocksApart> seen = p.clocks();
      if (!p.has(witness) || !p.has(third) || !seen) continue;
      const double seen_fast_s = p.second() == witness ? seen->by_s : -seen->by_s;
      const double by_s = fast_s(witness);
      return ((seen_fast_s - by_s) * (seen_fast_s - by_s) - seen_fast_s * seen_fast_s) /
             (seen->sigma_s * seen->sigma_s + apart->sigma_s * apart->sigma_s);
    }
    return 0.0;
  };
  const double speaks = chi2_of_wrong(accused) - chi2_of_wrong(disagreement.other(accused));
  return std::max(speaks, 0.0) / ClockTest::threshold();
}

}  // namespace downrange::integrity
