#include "judge.hpp"

#include <algorithm>
#include <cmath>
#include <downrange/est/model/plot_model.hpp>

#include "exclusions.hpp"
#include "own_past.hpp"

namespace downrange {
namespace {

using integrity::only;
using integrity::Pair;
using integrity::Sample;
using integrity::Witness;
using integrity::WitnessKind;

constexpr int in_a_row = 3;
/// Above this many sensors on the ground each is held against the receivers and the next three sensors only.
constexpr int all_pairs_up_to = 12;
constexpr int neighbours = 3;
constexpr double velocity_span_s = 5;
/// A receiver's velocity may be this late for its position.
constexpr double velocity_lag_s = 0.3;
constexpr double calm = 0.2;
/// Times the threshold, of the first sample that can be judged.
constexpr double far_off_pad = 4;

bool paired(const std::vector<Witness>& all, int a, int b, int ground) {
  if (!all[static_cast<std::size_t>(a)].tells_position() && !all[static_cast<std::size_t>(b)].tells_position())
    return false;
  return ground <= all_pairs_up_to || a >= ground || b >= ground || std::abs(a - b) <= neighbours;
}

}  // namespace

void Judge::AloneTest::judge(Time at, double ratio, double apart) {
  beyond = ratio >= 1 ? beyond + 1 : 0;
  within = ratio >= 1 ? 0 : within + 1;
  if (beyond >= in_a_row) guilty = true;
  if (within >= in_a_row) guilty = false;
  if (ratio < calm || !judged) calm_at = at;
  judged = true;
  value = ratio;
  if (ratio >= 1) apart_m = apart;
}

Judge::Judge(const RangeConfig& config, const SourceTable& sources, int target)
    : settings_(config.integrity),
      receiver_(config.gps),
      nominal_(config.targets[static_cast<std::size_t>(target)].nominal),
      witnesses_(integrity::witnesses_of(config, max_receivers)) {
  if (config.pad) pad_test_.emplace(config.pad->site);
  for (const Source& source : sources) names_.push_back(source.name);
  standing_.resize(witnesses_.size());
  stations_.resize(names_.size());
  judgements_.resize(names_.size());
  settled_.resize(max_receivers);
  repeated_.resize(max_receivers);
  copies_.assign(max_receivers, integrity::Copies({.position_m = settings_.copy_position_m,
                                                   .velocity_m_s = settings_.copy_velocity_m_s}));
  const int count = static_cast<int>(witnesses_.size());
  const int ground = count - max_receivers;
  // The one that tells a position comes first, a receiver before a radar.
  for (int b = 0; b < count; ++b) {
    for (int a = 0; a < b; ++a) {
      if (!paired(witnesses_, a, b, ground)) continue;
      const bool swap = witnesses_[static_cast<std::size_t>(b)].is_receiver();
      pairs_.emplace_back(swap ? b : a, swap ? a : b);
    }
  }
  edges_.reserve(pairs_.size());
  characters_.resize(witnesses_.size());
  learnt_.reserve(witnesses_.size());
}

void Judge::note(SourceId source, const Observation& o) {
  if (const auto* fix = std::get_if<Fix>(&o.measured)) {
    if (o.verdict == Reason::Accepted || o.verdict == Reason::Duplicate) note_fix(source, o, *fix);
    return;
  }
  Witness& witness = witnesses_[static_cast<std::size_t>(source)];
  const Plot plot = plot_of(o.measured);
  if (o.verdict != Reason::Accepted || !plot.angles_valid || plot.range_valid != witness.tells_position()) return;
  integrity::RawMeasurement raw;
  raw.epoch = o.epoch;
  raw.z = {plot.range_valid ? plot.measured.range_m : 0, plot.measured.azimuth_rad, plot.measured.elevation_rad};
  witness.series.note(raw);
}

int Judge::receiver_place(const Name& receiver) {
  const std::size_t first = witnesses_.size() - max_receivers;
  for (int place = 0; place < max_receivers; ++place) {
    Witness& w = witnesses_[first + static_cast<std::size_t>(place)];
    if (w.heard && w.receiver == receiver) return place;
    if (w.heard) continue;
    w.heard = true;
    w.receiver = receiver;
    for (Witness& sensor : witnesses_) sensor.receiver_is_heard();
    return place;
  }
  return -1;
}

void Judge::note_fix(SourceId source, const Observation& o, const Fix& fix) {
  const int place = receiver_place(o.receiver);
  if (place < 0) return;
  Witness& w = witnesses_[witnesses_.size() - max_receivers + static_cast<std::size_t>(place)];
  w.sources |= set_of(source);
  const integrity::Copies& copies = copies_[static_cast<std::size_t>(place)];
  const auto& message = copies_[static_cast<std::size_t>(place)].note(source, o.epoch, fix);
  // Where it must be: by the other sources, or by its own last fix that nobody disputed.
  std::optional<Position<Ecef>> expected;
  const auto elsewhere = track_without_receivers_.at(o.epoch);
  Settled& settled = settled_[static_cast<std::size_t>(place)];
  const double dt = (o.epoch - settled.epoch).seconds();
  if (elsewhere) {
    expected = Position<Ecef>{elsewhere->head<3>()};
  } else if (const auto motion = track_.at(o.epoch); motion && settled.fix.velocity_valid && dt > 0 && dt < 5) {
    const Vec<3> v = settled.fix.velocity.m_s + dt / 2 * motion->tail<3>();
    expected = Position<Ecef>{settled.fix.position.m + dt * v};
  }
  const integrity::Copies::Odd odd = copies.odd(message, expected);
  for (std::size_t i = 0; i < message.count && odd.disputed == 0; ++i) {
    if (contains(odd.agreeing, message.copy[i].station) && o.epoch >= settled.epoch)
      settled = {.epoch = o.epoch, .fix = message.copy[i].fix};
  }
  for (std::size_t i = 0; i < message.count; ++i) {
    const int id = message.copy[i].station;
    Station& station = stations_[static_cast<std::size_t>(id)];
    const bool is_odd = contains(odd.stations, id);
    const bool is_disputed = contains(odd.disputed, id);
    if (!is_odd && !is_disputed) {
      if (message.count > 1 && station.counted != message.epoch) {
        station.odd = station.disputed = 0;
        station.counted = message.epoch;
      }
      continue;
    }
    if (station.odd == 0 && station.disputed == 0) station.odd_since = o.epoch;
    station.right_since = o.epoch;
    station.apart_m = odd.apart_m;
    station.against = (odd.agreeing | odd.disputed) & ~set_of(id);
    if (station.counted != message.epoch || (is_odd && station.odd == 0)) {
      station.odd = is_odd ? station.odd + 1 : 0;
      station.disputed = is_disputed ? station.disputed + 1 : 0;
    }
    station.counted = message.epoch;
  }
  if (w.series.knows(o.epoch) || stations_[static_cast<std::size_t>(source)].odd > 0) return;
  if (is_repeated(static_cast<std::size_t>(place), o)) return;
  integrity::RawMeasurement raw;
  raw.epoch = o.epoch;
  raw.z = fix.position.m;
  raw.velocity_m_s = fix.velocity.m_s;
  raw.velocity_valid = fix.velocity_valid;
  raw.sigma_horizontal_m = std::max(fix.sigma_horizontal_m, receiver_.sigma_horizontal_m);
  raw.sigma_vertical_m = std::max(fix.sigma_vertical_m, receiver_.sigma_vertical_m);
  raw.sigma_velocity_m_s = std::max(fix.sigma_velocity_m_s, receiver_.sigma_velocity_m_s);
  w.series.note(raw);
}

bool Judge::is_repeated(std::size_t place, const Observation& o) {
  Repeated& r = repeated_[place];
  if (o.epoch > r.newest) {  // else it is a copy, or late
    r.newest = o.epoch;
    const Measurement m{.epoch = o.epoch, .measured = o.measured, .in_flight = in_flight_};
    std::optional<Time>& repeats_since = standing_[witnesses_.size() - max_receivers + place].repeats_since;
    repeats_since.reset();
    if (is_frozen(r.last, m, {})) {
      r.from = repeats_since = r.last.since;
      r.until = o.epoch;
    }
  }
  return r.covers(o.epoch);
}

std::span<const Judgement> Judge::judge(const JudgedTick& tick, std::span<const ChainState> chains,
                                        std::span<const BiasEstimate> biases) {
  const Time epoch = tick.epoch;
  in_flight_ = tick.in_flight;
  integrity::WitnessSet innocent = 0;
  for (std::size_t w = 0; w < witnesses_.size(); ++w) {
    const Witness& witness = witnesses_[w];
    standing_[w].judgement.true_from.reset();
    standing_[w].active = witness.series.heard() && (witness.sources & ~tick.inhibited) != 0;
    if ((witness.sources & tick.forced) != 0) innocent |= only(static_cast<int>(w));
  }
  follow_reference(epoch, chains);
  for (std::size_t w = 0; w < std::min(biases.size(), witnesses_.size() - max_receivers); ++w)
    witnesses_[w].note_bias(epoch, biases[w]);
  form_samples(epoch, tick.in_flight);
  if (epoch.ns % integrity::grid_step.ns == 0) judge_biases(epoch, biases);
  decide(tick, innocent);
  judge_stations(epoch, tick.forced);
  publish();
  return judgements_;
}

void Judge::follow_reference(Time epoch, std::span<const ChainState> chains) {
  SourceSet doubted = 0;
  SourceSet receivers = 0;
  for (std::size_t w = 0; w < witnesses_.size(); ++w) {
    if (excluded(static_cast<int>(w))) doubted |= witnesses_[w].sources;
    if (witnesses_[w].is_receiver()) receivers |= witnesses_[w].sources;
  }
  const ChainState* best = nullptr;
  const ChainState* without_receivers = nullptr;
  const auto better = [](const ChainState& chain, const ChainState* than) {
    return than == nullptr || count(chain.sources) > count(than->sources);
  };
  const auto clean = [&](const ChainState& chain) { return (chain.sources & doubted) == 0; };
  for (const ChainState& chain : chains) {
    if (!chain.estimate || !chain.estimate->mean.allFinite()) continue;
    if (best == nullptr || (clean(chain) && !clean(*best)) || (clean(chain) == clean(*best) && better(chain, best)))
      best = &chain;
    if ((chain.sources & receivers) == 0 && better(chain, without_receivers)) without_receivers = &chain;
  }
  const auto motion_of = [](const TrackEstimate& e) {
    Vec<9> motion = e.mean;
    if (e.size < 9) motion.tail<3>().setZero();
    return motion;
  };
  if (best != nullptr) track_.note(epoch, motion_of(*best->estimate));
  if (without_receivers != nullptr) track_without_receivers_.note(epoch, motion_of(*without_receivers->estimate));
}

void Judge::form_samples(Time epoch, bool in_flight) {
  const integrity::BiasVector none = integrity::BiasVector::Zero();
  for (std::size_t w = 0; w < witnesses_.size(); ++w) {
    Witness& witness = witnesses_[w];
    const auto predict = [&](const Vec<9>& motion) -> Vec<3> {
      if (witness.is_receiver()) return motion.head<3>();
      return predict_plot(witness.model, motion, none).q;
    };
    const auto residual = [&](const Vec<3>& z, const Vec<3>& predicted) -> Vec<3> {
      if (witness.is_receiver()) return z - predicted;
      Vec<3> r = plot_residual({z[0], z[1], z[2]}, predicted);
      if (witness.kind == WitnessKind::Angles) r[0] = 0;
      return r;
    };
    while (const std::optional<Sample> sample = witness.series.form(epoch, track_, predict, residual))
      judge_sample(static_cast<int>(w), *sample, in_flight);
  }
}

void Judge::judge_sample(int index, Sample sample, bool in_flight) {
  Witness& witness = witnesses_[static_cast<std::size_t>(index)];
  Standing& standing = standing_[static_cast<std::size_t>(index)];
  const auto& samples = witness.series.samples();
  integrity::OwnPast jump;
  if (!samples.empty()) jump = own_jump(witness, samples.newest(), sample, threshold_);
  sample.own_break = jump.ratio;
  sample.own_break_m = jump.apart_m;
  witness.series.keep(sample);
  if (sample.own_break >= 1 && standing.held_for != Finding::None) {
    standing.held_for = Finding::None;
    standing.pad = {};
    standing.bias = {};
  }
  if (witness.is_receiver()) {
    // One jump is a step; jumps without end, or a drift without one, are a velocity that is not that of the positions.
    integrity::OwnPast own{sample.own_break, sample.own_break_m};
    if (own.ratio < 1) {
      const double recent = own_break_about(index, sample.epoch - seconds(velocity_span_s), sample.epoch);
      own = recent >= 1 ? integrity::OwnPast{} : own_velocity(witness, velocity_span_s, velocity_lag_s, threshold_);
    }
    standing.velocity.judge(sample.epoch, own.ratio, own.apart_m);
    if (jump.ratio >= 1 && !is_compared(index)) standing.back.jumped(sample.epoch, jump.step_m);
    standing.leap.note(sample.epoch, jump, !undecided_third(sample.epoch, only(index)));
    if (standing.leap.since() && is_compared(index) && agrees_again(index)) standing.leap.forget();
  }
  if (pad_test_ && !in_flight) {
    const integrity::TestResult off = (*pad_test_)(witness, threshold_);
    // Nothing speaks yet for one whose first word is far from the pad: what it would teach is not waited for.
    if (!standing.pad.judged && off.ratio >= far_off_pad) standing.pad.guilty = true;
    standing.pad.judge(sample.epoch, off.ratio, off.apart_m);
  } else if (standing.pad.guilty) {
    standing.held_for = Finding::OffPad;
    standing.held_onset = standing.pad.calm_at;
  }
  compare(index, sample.epoch, in_flight);
}

void Judge::compare(int index, Time at, bool in_flight) {
  const auto accused = [&](int w) {
    return standing_[static_cast<std::size_t>(w)].judgement.verdict != IntegrityVerdict::Agrees;
  };
  const auto elsewhere = [&](int w) {
    return accused(w) && standing_[static_cast<std::size_t>(w)].judgement.why != Finding::Clock;
  };
  for (Pair& pair : pairs_) {
    if (!pair.has(index) || (pair.compared() && *pair.compared() >= at)) continue;
    const Witness& first = witnesses_[static_cast<std::size_t>(pair.first())];
    const Witness& second = witnesses_[static_cast<std::size_t>(pair.second())];
    const Sample* a = first.series.at(at);
    const Sample* b = second.series.at(at);
    if (a == nullptr || b == nullptr) continue;
    pair.compare(first, *a, second, *b, accused(pair.first()) || accused(pair.second()),
                 elsewhere(pair.first()) || elsewhere(pair.second()), in_flight, threshold_);
    if (first.is_receiver() && second.kind == WitnessKind::Radar) ask_radar(second, *b, pair.first(), *a);
  }
}

void Judge::ask_radar(const Witness& radar, const Sample& seen, int receiver, const Sample& told) {
  Standing& standing = standing_[static_cast<std::size_t>(receiver)];
  if (!standing.back.jump()) return;
  const Witness& witness = witnesses_[static_cast<std::size_t>(receiver)];
  Sample without_jump = told;
  without_jump.z -= standing.back.step_m();
  const std::optional<Time> before = standing.back.since();
  standing.back.judge(told.epoch, integrity::coarse_test(radar, seen, witness, told, threshold_).ratio,
                      integrity::coarse_test(radar, seen, witness, without_jump, threshold_).ratio);
  if (standing.back.since() == before) return;
  // What was learnt from it until then is undone, here as in the chains.
  standing.leap.forget();
  standing.judgement.true_from = standing.back.since();
  for (Witness& w : witnesses_) w.known.clear();
  for (Pair& p : pairs_) {
    if (p.has(receiver)) p.forget(before_all, *standing.back.since());
  }
}

void Judge::judge_biases(Time epoch, std::span<const BiasEstimate> biases) {
  learnt_.clear();
  const std::size_t ground = witnesses_.size() - max_receivers;
  for (std::size_t w = 0; w < std::min(biases.size(), ground); ++w) {
    Standing& s = standing_[w];
    const Witness& witness = witnesses_[w];
    const BiasEstimate& bias = biases[w];
    const bool judged = s.active && !excluded(static_cast<int>(w)) && bias.reference == BiasReference::Gps &&
                        witness.kind == WitnessKind::Radar && !witness.series.samples().empty();
    if (!judged) continue;
    integrity::BiasVector excess = integrity::BiasVector::Zero();
    for (int i = 0; i < bias.terms; ++i) {
      const auto term = static_cast<Eigen::Index>(bias.term[static_cast<std::size_t>(i)]);
      excess[term] = bias.value[i] - witness.model.bias.prior_mean[term];
    }
    integrity::LearntBias learnt = bias_test_(witness.model.bias, bias);
    learnt.witness = static_cast<int>(w);
    learnt.displacement = integrity::displacement(witness, witness.series.samples().newest(), excess);
    s.bias.judge(epoch, learnt.plausibility.ratio, learnt.displacement.norm());
    learnt.implausible = s.bias.guilty;
    learnt_.push_back(learnt);
  }
  integrity::BiasBlame blame = integrity::blame(learnt_);
  const integrity::CommonClock clock = integrity::common_clock(learnt_);
  common_clock_.judge(epoch, clock.ratio, clock.apart_m);
  if (common_clock_.guilty) blame = {.receivers = true};
  disputed_ = blame.disputed;
  for (std::size_t w = 0; w < witnesses_.size(); ++w) {
    Standing& s = standing_[w];
    if (!s.active || excluded(static_cast<int>(w)) || s.held_for != Finding::None) continue;
    const bool receiver = witnesses_[w].is_receiver();
    if (receiver && blame.disputed != 0) disputed_ |= only(static_cast<int>(w));
    if (receiver && common_clock_.guilty) s.bias = common_clock_;
    if (receiver && (blame.receivers || blame.disputed != 0)) {
      for (const integrity::LearntBias& r : learnt_) {
        if (r.implausible) s.bias = standing_[static_cast<std::size_t>(r.witness)].bias;
      }
    }
    if (receiver ? !blame.receivers : (blame.radars & only(static_cast<int>(w))) == 0) continue;
    s.held_for = receiver ? Finding::CommonBias : Finding::ImplausibleBias;
    s.held_onset = s.bias.calm_at;
  }
}

const Judgement* Judge::of_receiver(const Name& receiver) const {
  for (std::size_t w = witnesses_.size() - max_receivers; w < witnesses_.size(); ++w) {
    if (witnesses_[w].heard && witnesses_[w].receiver == receiver) return &standing_[w].judgement;
  }
  return nullptr;
}

Judge::PairView Judge::pair(std::size_t i) const {
  const Pair& p = pairs_[i];
  return {.first = witnesses_[static_cast<std::size_t>(p.first())].sources,
          .second = witnesses_[static_cast<std::size_t>(p.second())].sources,
          .value = p.value(),
          .apart_m = p.apart_m(),
          .fails = p.fails()};
}

}  // namespace downrange
