/// Judge: from the tests to the verdicts.

#include <algorithm>
#include <cmath>

#include "exclusions.hpp"
#include "judge.hpp"
#include "nominal_test.hpp"
#include "own_past.hpp"

namespace downrange {
namespace {

using integrity::Accusation;
using integrity::only;
using integrity::Pair;
using integrity::WitnessSet;

/// A tie of which a third witness may yet tell more is not called one before.
constexpr Duration tie_wait = milliseconds(4000);
constexpr Duration recent = milliseconds(3000);
/// A break with the own past belongs to a disagreement that began so near to it.
constexpr Duration break_before = milliseconds(1000);
constexpr Duration break_after = milliseconds(5000);
constexpr double quiet_beside = 0.3;
/// A lie that grows slowly has taught something before it could be told. Little is lost by undoing too much.
constexpr Duration slow_beginning = milliseconds(10'000);
/// Who began to disagree before anybody could compare it for so long may have lied all along.
constexpr Duration long_agreement = milliseconds(30'000);
constexpr int odd_copies = 2;  // in a row: the station is named

bool has(WitnessSet set, int witness) { return (set & only(witness)) != 0; }

int severity(IntegrityVerdict verdict) {
  switch (verdict) {
    case IntegrityVerdict::Agrees:
      return 0;
    case IntegrityVerdict::Ambiguous:
      return 1;
    case IntegrityVerdict::Suspect:
      return 2;
    case IntegrityVerdict::Excluded:
      return 3;
  }
  return 0;
}

}  // namespace

bool Judge::excluded(int witness) const {
  return standing_[static_cast<std::size_t>(witness)].judgement.verdict == IntegrityVerdict::Excluded;
}

Finding Judge::guilty_alone(int witness) const {
  const Standing& s = standing_[static_cast<std::size_t>(witness)];
  if (!s.active) return Finding::None;
  if (s.held_for != Finding::None) return s.held_for;
  if (s.leap.since()) return Finding::Impossible;
  if (s.velocity.guilty) return Finding::CoarseVelocity;
  if (s.pad.guilty) return Finding::OffPad;
  return Finding::None;
}

double Judge::own_break_about(int witness, Time onset, Time noticed) const {
  const Time last = std::max(onset + break_after, noticed + break_before);
  const auto& samples = witnesses_[static_cast<std::size_t>(witness)].series.samples();
  double most = 0;
  for (std::size_t i = 0; i < samples.size(); ++i) {
    const integrity::Sample& sample = samples.newest(i);
    if (sample.epoch < onset - break_before) break;
    if (sample.epoch > last) continue;
    // A break that goes on is a reference track whose velocity is wrong. One in the midst of a sample's measurements
    // shows in two samples: their median may lie between.
    const double quiet = quiet_beside * sample.own_break;
    std::size_t newer = i;
    std::size_t older = i;
    while (newer > 0 && samples.newest(newer - 1).own_break > quiet) --newer;
    while (older + 1 < samples.size() && samples.newest(older + 1).own_break > quiet) ++older;
    if (older - newer < 2) most = std::max(most, sample.own_break);
  }
  return most;
}

template <class Fails>
double Judge::own_break_when(int witness, const Fails& fails) const {
  double most = 0;
  for (const Pair& p : pairs_) {
    const bool counts = p.has(witness) && fails(p) && standing_[static_cast<std::size_t>(p.other(witness))].active;
    if (counts) most = std::max(most, own_break_about(witness, p.onset(), p.noticed_at()));
  }
  return most;
}

template <class Fails>
double Judge::clock_acquittal(int witness, const Fails& fails) const {
  double most = 0;
  for (const Pair& p : pairs_) {
    if (!p.has(witness) || !p.by_clock() || !fails(p)) continue;
    const int other = p.other(witness);
    for (int third = 0; third < static_cast<int>(witnesses_.size()); ++third) {
      if (third == witness || third == other || !standing_[static_cast<std::size_t>(third)].active) continue;
      most = std::max(most, integrity::clock_acquittal(pairs_, p, witness, third));
    }
  }
  return most;
}

int Judge::distrust(int witness) const {
  const integrity::Witness& w = witnesses_[static_cast<std::size_t>(witness)];
  for (std::size_t place = 0; place < settings_.trust.size(); ++place) {
    const Name& name = settings_.trust[place];
    if (w.is_receiver() && name == w.receiver) return static_cast<int>(place);
    for (std::size_t id = 0; id < names_.size(); ++id) {
      if (contains(w.sources, static_cast<int>(id)) && names_[id] == name) return static_cast<int>(place);
    }
  }
  return static_cast<int>(settings_.trust.size());
}

Accusation Judge::accuse(Evidence evidence, const JudgedTick& tick, WitnessSet innocent) {
  const auto active = [&](int w) { return standing_[static_cast<std::size_t>(w)].active; };
  const auto fails = [&](const Pair& p) { return evidence == Evidence::Doubtful ? p.doubtful() : p.fails(); };
  std::optional<Time> onset;
  for (const Pair& p : pairs_) {
    if (active(p.first()) && active(p.second()) && fails(p)) onset = onset ? std::min(*onset, p.onset()) : p.onset();
  }
  edges_.clear();
  for (const Pair& p : pairs_) {
    if (!active(p.first()) || !active(p.second())) continue;
    edges_.push_back({.first = p.first(),
                      .second = p.second(),
                      .fails = fails(p),
                      .doubt = fails(p) || !onset ? 0 : p.doubt_since(*onset)});
  }
  WitnessSet alone = 0;
  WitnessSet named = 0;
  for (int w = 0; w < static_cast<int>(witnesses_.size()); ++w) {
    const Standing& s = standing_[static_cast<std::size_t>(w)];
    if (guilty_alone(w) != Finding::None) alone |= only(w);
    if (excluded(w)) named |= only(w);
    integrity::Character& c = characters_[static_cast<std::size_t>(w)];
    c = {};
    if (!s.active) continue;
    c.own_break = own_break_when(w, fails);
    c.acquittal = clock_acquittal(w, fails);
    if (evidence == Evidence::FailingAndCharacter) {
      c.impossible = integrity::impossible(witnesses_[static_cast<std::size_t>(w)]);
      if (tick.liftoff)
        c.off_nominal = integrity::off_nominal(witnesses_[static_cast<std::size_t>(w)], nominal_, *tick.liftoff);
      c.distrust = distrust(w);
    }
  }
  return integrity::identify(edges_, characters_, alone, innocent, named);
}

bool Judge::undecided_third(Time epoch, WitnessSet involved) const {
  for (std::size_t w = 0; w < witnesses_.size(); ++w) {
    const auto heard = witnesses_[w].series.heard();
    if (standing_[w].active && !has(involved, static_cast<int>(w)) && !excluded(static_cast<int>(w)) && heard &&
        epoch - *heard <= recent)
      return true;
  }
  return false;
}

void Judge::decide(const JudgedTick& tick, WitnessSet innocent) {
  const Time epoch = tick.epoch;
  Accusation named = accuse(Evidence::Failing, tick, innocent);
  bool tie_stands = false;
  if (named.tied != 0) {
    if (!tied_since_) tied_since_ = epoch;
    tie_stands = epoch - *tied_since_ >= tie_wait || !undecided_third(epoch, named.tied | named.guilty);
    if (tie_stands) named = accuse(Evidence::FailingAndCharacter, tick, innocent);
  } else {
    tied_since_.reset();
  }
  const WitnessSet disputed = disputed_ & ~named.guilty & ~innocent;
  if (disputed != 0 && named.guilty == 0) {
    named.tied |= disputed;
    tie_stands = tie_stands || tied_since_ == std::nullopt;
  }
  const Accusation suspected = accuse(Evidence::Doubtful, tick, innocent);
  for (int w = 0; w < static_cast<int>(witnesses_.size()); ++w) {
    Standing& s = standing_[static_cast<std::size_t>(w)];
    s.is_back = s.back.since() && epoch - *s.back.since() <= settings_.readmit_after;
    describe(w);
    const IntegrityVerdict verdict = verdict_on(w, named, suspected, tie_stands);
    const bool forced = has(innocent, w) && verdict == IntegrityVerdict::Excluded;
    set_verdict(w, forced ? IntegrityVerdict::Suspect : verdict, epoch);
  }
}

IntegrityVerdict Judge::verdict_on(int w, const Accusation& named, const Accusation& suspected, bool tie_stands) const {
  const Standing& s = standing_[static_cast<std::size_t>(w)];
  if (!s.active) return IntegrityVerdict::Agrees;
  if (has(named.guilty, w)) return IntegrityVerdict::Excluded;
  if (excluded(w) && !explained(w, named.guilty) && !agrees_again(w)) return IntegrityVerdict::Excluded;
  if (tie_stands && has(named.tied, w)) return IntegrityVerdict::Ambiguous;
  if (s.judgement.verdict == IntegrityVerdict::Ambiguous && has(named.tied, w)) return IntegrityVerdict::Ambiguous;
  const bool suspect = has(suspected.guilty, w) || s.repeats_since || s.is_back;
  return suspect ? IntegrityVerdict::Suspect : IntegrityVerdict::Agrees;
}

bool Judge::explained(int witness, WitnessSet guilty) const {
  return std::ranges::any_of(
      pairs_, [&](const Pair& p) { return p.has(witness) && p.fails() && has(guilty, p.other(witness)); });
}

bool Judge::is_compared(int witness) const {
  return std::ranges::any_of(pairs_, [&](const Pair& p) { return p.has(witness) && p.compared(); });
}

bool Judge::agrees_again(int witness) const {
  std::optional<Time> newest;
  for (const Pair& p : pairs_) {
    if (!p.has(witness) || !p.compared() || excluded(p.other(witness))) continue;
    if (!standing_[static_cast<std::size_t>(p.other(witness))].active) continue;
    if (p.fails()) return false;
    newest = newest ? std::max(*newest, *p.compared()) : *p.compared();
  }
  // With nobody to agree with it is enough that it is guilty of nothing any more.
  if (!newest) return !is_compared(witness);
  return std::ranges::all_of(pairs_, [&](const Pair& p) {
    if (!p.has(witness) || !p.compared() || excluded(p.other(witness))) return true;
    if (!standing_[static_cast<std::size_t>(p.other(witness))].active || *newest - *p.compared() > recent) return true;
    return p.agreement() >= settings_.readmit_after;
  });
}

void Judge::set_verdict(int witness, IntegrityVerdict verdict, Time epoch) {
  Judgement& j = standing_[static_cast<std::size_t>(witness)].judgement;
  if (j.verdict == IntegrityVerdict::Excluded && verdict != IntegrityVerdict::Excluded) {
    const Time right_since = j.why == Finding::Impossible ? epoch : epoch - settings_.readmit_after;
    for (Pair& p : pairs_) {
      if (p.has(witness)) p.forget(j.onset, right_since);
    }
  }
  if (verdict == IntegrityVerdict::Agrees) {
    j.why = Finding::None;
    j.against = 0;
    j.apart_m = j.agree_m = 0;
  }
  if (verdict == j.verdict) return;
  j.verdict = verdict;
  j.since = epoch;
}

void Judge::describe(int witness) {
  Standing& s = standing_[static_cast<std::size_t>(witness)];
  Judgement& j = s.judgement;
  const bool begins = j.verdict == IntegrityVerdict::Agrees;
  j.receiver = witnesses_[static_cast<std::size_t>(witness)].receiver;
  j.test_value = std::max({s.velocity.value, s.pad.value, s.bias.value});
  std::optional<Time> onset;
  SourceSet against = 0;
  double apart_m = 0;
  bool coarsely = false;
  bool only_clocks = true;
  double clocks_apart_s = 0;
  for (const Pair& p : pairs_) {
    if (!p.has(witness) || !p.compared() || !standing_[static_cast<std::size_t>(p.other(witness))].active) continue;
    j.test_value = std::max(j.test_value, p.value());
    if (!p.doubtful() || excluded(p.other(witness))) continue;
    against |= witnesses_[static_cast<std::size_t>(p.other(witness))].sources;
    apart_m = std::max(apart_m, p.apart_m());
    coarsely = coarsely || p.coarsely();
    only_clocks = only_clocks && p.by_clock();
    if (const auto clocks = p.clocks()) clocks_apart_s = std::max(clocks_apart_s, std::abs(clocks->by_s));
    onset = onset ? std::min(*onset, p.onset()) : p.onset();
  }
  const Finding alone = guilty_alone(witness);
  const bool disputed = has(disputed_, witness);
  if (alone == Finding::None && against == 0 && !disputed && !s.repeats_since && !s.is_back)
    return;  // what was said of it before stands as long as its verdict does
  j.against = against;
  j.apart_m = only_clocks ? clocks_apart_s : apart_m;
  j.why = only_clocks ? Finding::Clock : coarsely ? Finding::CoarsePosition : Finding::FinePosition;
  j.agree_m = agreement_among(against);
  if (alone == Finding::None && against == 0 && !disputed) {
    j.why = Finding::Impossible;
    onset = s.repeats_since ? s.repeats_since : s.back.since();
    if (!s.repeats_since) j.apart_m = s.back.step_m().norm();
  } else if (alone == Finding::None && against == 0) {
    j.why = Finding::ImplausibleBias;
    j.apart_m = s.bias.apart_m;
    onset = s.bias.calm_at;
    for (int w = 0; w < static_cast<int>(witnesses_.size()); ++w) {
      const bool one_receives = witnesses_[static_cast<std::size_t>(w)].is_receiver() !=
                                witnesses_[static_cast<std::size_t>(witness)].is_receiver();
      if (has(disputed_, w) && one_receives) j.against |= witnesses_[static_cast<std::size_t>(w)].sources;
    }
  } else if (alone != Finding::None) {
    j.why = alone;
    const bool leap = alone == Finding::Impossible;
    const bool velocity = alone == Finding::CoarseVelocity;
    const bool pad = alone == Finding::OffPad;
    const AloneTest& test = velocity ? s.velocity : pad ? s.pad : s.bias;
    const Time began = leap ? *s.leap.since() : test.calm_at;
    j.apart_m = leap ? s.leap.apart_m() : test.apart_m;
    onset = onset ? std::min(*onset, began) : began;
  }
  if (begins) j.onset = *onset;
  j.onset = std::min(j.onset, *onset);
  j.undone_from = undone_from(witness, j.onset);
}

double Judge::agreement_among(SourceSet sources) const {
  double most_m = 0;
  for (const Pair& p : pairs_) {
    const SourceSet both = witnesses_[static_cast<std::size_t>(p.first())].sources |
                           witnesses_[static_cast<std::size_t>(p.second())].sources;
    if (!p.compared() || (both & ~sources) != 0) continue;
    if (p.doubtful()) return 0;
    most_m = std::max(most_m, p.apart_m());
  }
  return most_m;
}

Time Judge::undone_from(int witness, Time onset) const {
  const Finding alone = guilty_alone(witness);
  if (alone == Finding::OffPad) return before_all;
  // Clocks are told late: what they say now has been so for long.
  if (alone == Finding::CommonBias && common_clock_.guilty) return before_all;
  const bool agreed_before = std::ranges::any_of(
      pairs_, [&](const Pair& p) { return p.has(witness) && p.known_for(onset) >= long_agreement; });
  return agreed_before ? onset - slow_beginning : before_all;
}

void Judge::judge_stations(Time epoch, SourceSet forced) {
  for (std::size_t id = 0; id < stations_.size(); ++id) {
    Station& station = stations_[id];
    Judgement& j = station.judgement;
    IntegrityVerdict verdict = IntegrityVerdict::Agrees;
    if (station.odd > 0) verdict = station.odd >= odd_copies ? IntegrityVerdict::Excluded : IntegrityVerdict::Suspect;
    if (station.disputed >= odd_copies) verdict = IntegrityVerdict::Ambiguous;
    const bool waits = j.verdict == IntegrityVerdict::Excluded && epoch - station.right_since < settings_.readmit_after;
    if (waits) verdict = IntegrityVerdict::Excluded;
    if (contains(forced, static_cast<int>(id)) && verdict == IntegrityVerdict::Excluded)
      verdict = IntegrityVerdict::Suspect;
    if (verdict != j.verdict) j.since = epoch;
    j.verdict = verdict;
    if (verdict == IntegrityVerdict::Agrees) continue;
    j.why = Finding::DifferingCopy;
    j.onset = j.undone_from = station.odd_since;
    j.apart_m = station.apart_m;
    j.against = station.against;
  }
}

void Judge::publish() {
  for (Judgement& j : judgements_) j = {};
  const std::size_t ground = witnesses_.size() - max_receivers;
  for (std::size_t w = 0; w < ground; ++w) judgements_[w] = standing_[w].judgement;
  for (std::size_t id = ground; id < judgements_.size(); ++id) {
    const Judgement* kindest = nullptr;
    const Judgement* worst = nullptr;
    for (std::size_t w = ground; w < witnesses_.size(); ++w) {
      if (!contains(witnesses_[w].sources, static_cast<int>(id))) continue;
      const Judgement& j = standing_[w].judgement;
      if (kindest == nullptr || severity(j.verdict) < severity(kindest->verdict)) kindest = &j;
      if (worst == nullptr || severity(j.verdict) > severity(worst->verdict)) worst = &j;
    }
    if (worst != nullptr) {
      judgements_[id] = *worst;
      const bool all = kindest->verdict == IntegrityVerdict::Excluded;
      if (worst->verdict == IntegrityVerdict::Excluded && !all) judgements_[id].verdict = IntegrityVerdict::Suspect;
    }
    const Judgement& own = stations_[id].judgement;
    if (severity(own.verdict) > severity(judgements_[id].verdict)) judgements_[id] = own;
  }
}

}  // namespace downrange
