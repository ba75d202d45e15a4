/// INTEGRITY with a judge that says what the test wants: exclusion and what is followed, undoing, return, bound.
#include <gtest/gtest.h>

#include <cmath>

#include "../support/allocations.hpp"
#include "stage/integrity/bound.hpp"
#include "stage_integrity_testing.hpp"

namespace downrange {
namespace {

using namespace test;

/// Jeju's ranges are 3 km off from 20 s on.
std::vector<Event> with_jeju_lying(const RangeConfig& range, double duration_s, double until = 1e9) {
  return with_lie<RadarTspi>(small_flight(range, duration_s, 4), 20, [&](RadarTspi& plot) {
    if (plot.sensor == range.radars[1].id && plot.epoch < liftoff + seconds(until)) plot.measured.range_m += 3000;
  });
}

/// Of which a run that has to catch up takes some ticks.
RangeConfig range_that_catches_up_slowly() {
  RangeConfig range = judged_range();
  range.integrity.rerun_per_tick = 20;
  return range;
}

TEST(Integrity, AllIsFollowedAgainAtOnceWhereItCatchesUpInOneTick) {
  const RangeConfig range = judged_range();
  Centre centre(range, excluded(set_of(jeju), 22, 20));
  double error_at_22_m = 1e9;
  centre.after_tick = [&](double t) {
    if (t == 22) error_at_22_m = centre.error_m(t);
  };
  centre.handle(with_jeju_lying(range, 30));
  for (const SlavingCommand& c : centre.out.of<SlavingCommand>())
    EXPECT_EQ(c.chain, Name()) << (c.tick - liftoff).seconds();
  EXPECT_LT(error_at_22_m, 60) << "without the lie";
}

TEST(Integrity, UntilAllHasCaughtUpTheChainThatNeverHeardTheLiarIsFollowed) {
  const RangeConfig range = range_that_catches_up_slowly();
  Centre centre(range, excluded(set_of(jeju), 22, 20));
  centre.handle(with_jeju_lying(range, 30));
  bool returned = false;
  for (const SlavingCommand& c : centre.out.of<SlavingCommand>()) {
    const double t = (c.tick - liftoff).seconds();
    if (t < 22) {
      EXPECT_EQ(c.chain, Name()) << t;
    } else if (t < 22.05) {
      EXPECT_EQ(c.chain, Name("without-jeju")) << t;
    }
    returned = returned || (t > 22 && c.chain.empty());
  }
  EXPECT_TRUE(returned);  // to all, which is run again without it
}

TEST(Integrity, AllIsRunAgainToTheBitOfTheMethodThatNeverHeardTheLiar) {
  const RangeConfig range = judged_range();
  const auto events = with_jeju_lying(range, 32);
  Centre excludes(range, excluded(set_of(jeju), 22, 20));
  excludes.handle(events);
  // The state kept before the onset is that of 15 s: kept with the tick of 20 s, a history before it.
  Centre never_heard(range);
  never_heard.handle(without_plots(events, "jeju", 15));
  ASSERT_EQ(excludes.followed().chain, Name());
  const auto a = excludes.estimate(32);
  const auto b = never_heard.estimate(32);
  ASSERT_TRUE(a && b);
  EXPECT_EQ(a->mean, b->mean);
  EXPECT_EQ(a->cov, b->cov);
  for (const SourceId radar : {goheung, jeju}) {
    EXPECT_EQ(excludes.methods().primary().bias(radar).value, never_heard.methods().primary().bias(radar).value);
    EXPECT_EQ(excludes.methods().primary().account(radar).accepted,
              never_heard.methods().primary().account(radar).accepted);
  }
}

TEST(Integrity, ASourceThatIsBelievedAgainIsUsedAgain) {
  const RangeConfig range = judged_range();
  Centre centre(range, excluded(set_of(jeju), 22, 20, 34));
  std::uint64_t accepted_at_34 = 0;
  centre.after_tick = [&](double t) {
    if (t == 34) accepted_at_34 = centre.methods().primary().account(jeju).accepted;
  };
  centre.handle(with_jeju_lying(range, 40, 24));
  EXPECT_GT(accepted_at_34, 0u);
  EXPECT_GT(centre.methods().primary().account(jeju).accepted, accepted_at_34 + 100);
  EXPECT_EQ(centre.followed().chain, Name());
  EXPECT_LT(centre.error_m(40), 20);
}

TEST(Integrity, TheOtherChainsFollowSuitSoThatASecondLiarIsUndoneAsWell) {
  const RangeConfig range = range_that_catches_up_slowly();
  Centre centre(range, [](double t, std::vector<Judgement>& verdicts) {
    excluded(set_of(jeju), 22, 20)(t, verdicts);
    excluded(gps, 28, 26)(t, verdicts);
  });
  auto events = with_jeju_lying(range, 36);
  events = with_lie<GpsFix>(std::move(events), 26, [](GpsFix& fix) { fix.position.m.x() += 5000; });
  Name at_once("none");
  centre.after_tick = [&](double t) {
    if (t == 28) at_once = centre.followed().chain;
  };
  centre.handle(events);
  // Without GPS there is what was run again without jeju: goheung alone by now. Then all is, without both.
  EXPECT_EQ(at_once, Name("without-GPS"));
  EXPECT_EQ(centre.followed().chain, Name());
  EXPECT_LT(centre.error_m(36), 60);
}

/// A source that came back to the truth by itself: run again without what it said before, heard from then on.
TEST(Integrity, WhatAReturnedSourceTaughtBeforeIsUndoneAndItIsHeardFromThen) {
  const RangeConfig range = judged_range();
  const Script back = [](double t, std::vector<Judgement>& verdicts) {
    for (SourceId id = 0; id < static_cast<SourceId>(verdicts.size()); ++id) {
      std::optional<Time>& from = verdicts[static_cast<std::size_t>(id)].true_from;
      from.reset();
      if (id == jeju && t == 26) from = liftoff + seconds(24);
    }
  };
  Centre centre(range, back);
  const std::vector<Event> events = with_jeju_lying(range, 30, 24);
  centre.handle(events);
  Centre never_heard(range);
  for (const Event& e : events) {
    const auto* plot = std::get_if<RadarTspi>(&e);
    if (plot == nullptr || plot->sensor != range.radars[1].id || plot->epoch >= liftoff + seconds(24))
      never_heard.handle(e);
  }
  EXPECT_EQ(centre.estimate(29)->mean, never_heard.estimate(29)->mean);
  EXPECT_EQ(centre.estimate(29)->cov, never_heard.estimate(29)->cov);
  Centre always_heard(range);
  always_heard.handle(events);
  EXPECT_NE(centre.estimate(29)->mean, always_heard.estimate(29)->mean);
}

TEST(Integrity, ALieOlderThanAllStatesLeavesTheChainWithoutTheLiarUntilItIsBelievedAgain) {
  const RangeConfig range = judged_range();
  Centre centre(range, excluded(set_of(jeju), 90, 2, 105));
  bool at_100 = false;
  centre.after_tick = [&](double t) {
    if (t == 100) at_100 = centre.followed().chain == Name("without-jeju");
  };
  centre.handle(small_flight(range, 107, 4));
  EXPECT_TRUE(at_100);
  EXPECT_EQ(centre.followed().chain, Name());
}

/// A source that was not heard before taught nothing: as another station of a receiver that was excluded for long.
TEST(Integrity, ASourceThatIsExcludedAsItIsFirstHeardCostsNothing) {
  const RangeConfig range = judged_range();
  Centre centre(range, excluded(set_of(jeju), 110.1, -1000));
  for (const Event& e : small_flight(range, 115, 4)) {
    const auto* plot = std::get_if<RadarTspi>(&e);
    if (plot == nullptr || plot->sensor != range.radars[1].id || plot->epoch >= liftoff + seconds(110))
      centre.handle(e);
  }
  ASSERT_GT((centre.out.of<SlavingCommand>().back().tick - liftoff).seconds(), 114);
  for (const SlavingCommand& c : centre.out.of<SlavingCommand>()) {
    const double t = (c.tick - liftoff).seconds();
    if (t > 110.5) {
      EXPECT_EQ(c.chain, Name()) << t;
    }
  }
}

TEST(Integrity, TheBoundCoversOneLie) {
  const RangeConfig range = judged_range();
  const auto true_flight = small_flight(range, 60, 7);
  const auto ramp = with_lie<GpsFix>(
      true_flight, 20, [](GpsFix& fix) { fix.position.m.y() += 20 * ((fix.epoch - liftoff).seconds() - 20); });
  const auto azimuth = with_lie<RadarTspi>(true_flight, 20, [](RadarTspi& plot) {
    if (plot.sensor == Name("goheung")) plot.measured.azimuth_rad += 0.5 * deg;
  });
  for (const auto& events : {true_flight, ramp, azimuth}) {
    Centre centre(range);  // nobody finds the liar
    int ticks = 0;
    int covered = 0;
    double worst_m = 0;
    centre.after_tick = [&](double t) {
      if (t < 15 || !centre.followed().bounded) return;
      const double bound = bound_m(centre.followed().alternatives);
      const double error = centre.error_m(t);
      worst_m = std::max(worst_m, error);
      ++ticks;
      covered += error <= bound ? 1 : 0;
    };
    centre.handle(events);
    EXPECT_GT(ticks, 1500);
    EXPECT_GE(covered, 0.999 * ticks) << worst_m;
    for (const SlavingCommand& c : centre.out.of<SlavingCommand>()) {
      const double t = (c.tick - liftoff).seconds();
      if (t < 15 || !c.bound_valid) continue;
      const AntennaConfig& antenna = range.antennas[c.antenna == range.antennas[0].id ? 0 : 1];
      const Polar q = polar_from_enu(antenna.site.enu_of(vehicle_at((c.apply_at - liftoff).seconds())));
      const double error = std::hypot(wrap_pi(c.azimuth_rad - q.azimuth_rad) * std::cos(q.elevation_rad),
                                      c.elevation_rad - q.elevation_rad);
      EXPECT_LE(error, c.bound_rad) << t;
    }
  }
}

TEST(Integrity, OneSourceAloneIsNotBounded) {
  const RangeConfig range = judged_range();
  Centre alone(range);
  auto events = small_flight(range, 20, 8);
  std::erase_if(events, [](const Event& e) { return !std::holds_alternative<GpsFix>(e); });
  alone.handle(events);
  ASSERT_TRUE(alone.estimate(20));
  EXPECT_FALSE(alone.followed().bounded);
  const auto integrity = alone.out.of<Integrity>();
  ASSERT_FALSE(integrity.empty());
  EXPECT_FALSE(integrity.back().bound_valid);
  Centre both(range);
  both.handle(small_flight(range, 20, 8));
  EXPECT_TRUE(both.followed().bounded);
  EXPECT_TRUE(both.out.of<Integrity>().back().bound_valid);
  EXPECT_GT(both.out.of<Trajectory>().back().bound_m, 0);
}

TEST(Integrity, WithASourceExcludedTheBoundIsOfTheOthers) {
  const RangeConfig range = judged_range();
  Centre centre(range, excluded(gps, 22, 20));
  centre.handle(small_flight(range, 30, 9));
  EXPECT_TRUE(centre.followed().bounded);  // two radars are left, each without the other
  EXPECT_EQ(centre.followed().alternatives.size(), 2u);
  Centre one_left(range, excluded(gps | set_of(jeju), 22, 20));
  one_left.handle(small_flight(range, 30, 9));
  EXPECT_FALSE(one_left.followed().bounded);
}

TEST(Integrity, AnAmbiguousSourceAddsItsOwnStory) {
  const RangeConfig range = judged_range();
  Centre centre(range, [](double t, std::vector<Judgement>& verdicts) {
    if (t >= 20) verdicts[goheung].verdict = verdicts[jeju].verdict = IntegrityVerdict::Ambiguous;
  });
  centre.handle(small_flight(range, 22, 9));
  EXPECT_EQ(centre.followed().chain, Name());  // where it was
  EXPECT_EQ(centre.followed().alternatives.size(), 5u);
}

/// Once one source is excluded and of the others nobody knows who is right: not even the chain that has caught up with
/// what they all say is followed before that is known.
TEST(Integrity, InATieTheTrackStaysWhereItWas) {
  const RangeConfig range = range_that_catches_up_slowly();
  constexpr double tie_to = 34;
  const Script jeju_lies = excluded(set_of(jeju), 22, 20);
  Centre centre(range, [&](double t, std::vector<Judgement>& verdicts) {
    jeju_lies(t, verdicts);
    const bool tie = t >= 22 && t < tie_to;
    verdicts[goheung].verdict = tie ? IntegrityVerdict::Ambiguous : IntegrityVerdict::Agrees;
    verdicts[goheung].why = tie ? Finding::CoarsePosition : Finding::None;
  });
  int ticks = 0;
  centre.after_tick = [&](double t) {
    if (t < 22 || t >= tie_to) return;
    EXPECT_EQ(centre.followed().chain, Name("without-jeju")) << t;
    ++ticks;
  };
  centre.handle(with_jeju_lying(range, 36));
  EXPECT_GT(ticks, 100);
  EXPECT_EQ(centre.followed().chain, Name()) << "all had caught up meanwhile";
}

/// Arrives in another order, the same within the history: the same chains, whatever was undone in between.
TEST(Integrity, TheOrderOfArrivalIsNothing) {
  const RangeConfig range = judged_range();
  const auto events = with_jeju_lying(range, 40, 26);
  auto shuffled = events;
  std::mt19937_64 rng(3);
  std::uniform_real_distribution<double> delay(0.02, 1.5);
  for (Event& e : shuffled) {
    const Time epoch = std::visit([](const auto& message) { return message.epoch; }, e);
    set_received(e, epoch + seconds(delay(rng)));
  }
  std::stable_sort(shuffled.begin(), shuffled.end(),
                   [](const Event& a, const Event& b) { return received_of(a) < received_of(b); });
  const Script script = excluded(set_of(jeju), 23, 20, 33);
  Centre a(range, script);
  a.handle(events);
  a.advance_to(liftoff + seconds(42.0));
  Centre b(range, script);
  b.handle(shuffled);
  b.advance_to(liftoff + seconds(42.0));
  const auto x = a.estimate(42);
  const auto y = b.estimate(42);
  ASSERT_TRUE(x && y);
  // Which station's copy of a fix comes first is all that the order may change, and the copies are alike.
  EXPECT_EQ(x->mean, y->mean);
  EXPECT_EQ(x->cov, y->cov);
}

TEST(Integrity, AnOperatorHoldsAChainInhibitsAndForces) {
  const RangeConfig range = judged_range();
  const auto events = with_jeju_lying(range, 26);
  Centre held(range);
  held.held = {"only-GPS"};
  held.handle(events);
  EXPECT_EQ(held.followed().chain, Name("only-GPS"));

  Centre inhibits(range);
  inhibits.inhibited = set_of(jeju);
  inhibits.handle(events);
  EXPECT_EQ(inhibits.methods().primary().account(jeju).accepted, 0u);
  EXPECT_GT(inhibits.methods().primary().account(goheung).accepted, 100u);

  Centre forces(range, excluded(set_of(jeju), 22, 20));
  forces.forced = set_of(jeju);
  forces.handle(events);
  EXPECT_EQ(forces.out.of<SlavingCommand>().back().chain, Name());
  const auto weighed = [](const Centre& centre) {
    const SourceAccount& account = centre.methods().primary().account(jeju);
    return account.accepted + account.gated;
  };
  Centre excludes(range, excluded(set_of(jeju), 22, 20));
  excludes.handle(events);
  EXPECT_GT(weighed(forces), weighed(excludes) + 60);
}

TEST(Integrity, SaysWhatItThinksWithEveryJudgedTick) {
  const RangeConfig range = range_that_catches_up_slowly();
  Centre centre(range, excluded(set_of(jeju), 22.3, 20));
  centre.handle(with_jeju_lying(range, 30));
  const auto records = centre.out.of<Integrity>();
  std::uint64_t events = 0;
  Name chain;
  int at_22_3 = 0;
  for (const Integrity& r : records) {
    const double t = (r.time - liftoff).seconds();
    EXPECT_EQ(r.time.ns % 100'000'000, 0);
    const bool excluded_now = std::abs(t - 22.3) < 0.01;
    EXPECT_EQ(r.events, events + (excluded_now || r.chain != chain ? 1 : 0)) << t;
    events = r.events;
    chain = r.chain;
    if (excluded_now) {
      ++at_22_3;
      EXPECT_EQ(r.chain, Name("without-jeju"));
      ASSERT_EQ(r.sources.size(), 4u);
      EXPECT_EQ(r.sources[1].sensor, Name("jeju"));
      EXPECT_EQ(r.sources[1].verdict, IntegrityVerdict::Excluded);
      EXPECT_EQ(r.sources[1].by, Name("integrity"));
    }
  }
  EXPECT_EQ(at_22_3, 1);
  EXPECT_GE(records.size(), 280u);
  EXPECT_EQ(events, 2u);  // excluded, and back to all
}

TEST(Integrity, PublishesItsChains) {
  RangeConfig range = judged_range();
  range.fuse.publish_chains = true;
  Centre centre(range);
  centre.handle(small_flight(range, 10, 1));
  std::map<Name, int> of_method;
  for (const Trajectory& t : centre.out.of<Trajectory>()) {
    ++of_method[t.method];
    EXPECT_EQ(t.primary, t.method == Name("joint"));
  }
  for (const Name& chain : {Name("joint/without-goheung"), Name("joint/without-jeju"), Name("joint/without-GPS"),
                            Name("joint/only-goheung"), Name("joint/only-jeju"), Name("joint/only-GPS")})
    EXPECT_GT(of_method[chain], 40) << chain.view();
  EXPECT_EQ(of_method.size(), 7u);
}

TEST(Integrity, SwitchedOffItIsTheMethodAlone) {
  RangeConfig range = judged_range();
  const auto events = small_flight(range, 10, 1);
  Centre on(range);
  on.handle(events);
  range.integrity.enabled = false;
  Centre off(range, excluded(set_of(jeju), 2, 1));
  off.handle(events);
  EXPECT_EQ(on.estimate(10)->mean, off.estimate(10)->mean);
  EXPECT_TRUE(off.out.of<Integrity>().empty());
  EXPECT_FALSE(off.out.of<SlavingCommand>().back().bound_valid);
}

struct Nobody final : ResultSink {
  void emit(const Result&) override {}
};

TEST(Integrity, AllocatesNothingInTheSteadyState) {
#ifndef DOWNRANGE_COUNTS_ALLOCATIONS
  GTEST_SKIP() << "a sanitizer has a malloc of its own";
#endif
  const RangeConfig range = judged_range();
  Ingest ingest(range);
  Methods methods(range, scripted(nobody_lies));
  Slave slave(range);
  Nobody sink;
  Time tick = liftoff;
  std::size_t allocated = 0;
  for (const Event& e : small_flight(range, 150, 2)) {
    const auto* plot = std::get_if<RadarTspi>(&e);
    const Observation o = plot != nullptr ? ingest.judge(*plot) : ingest.judge(std::get<GpsFix>(e));
    const std::size_t now = allocations_of([&] {
      for (; tick <= received_of(e); tick = tick + range.tick) {
        methods.judge(tick, {}, sink);
        slave.tick(tick, methods.followed(), {}, sink);
      }
      if (o.verdict == Reason::Accepted) methods.process(o, true);
    });
    if (tick > liftoff + seconds(140.0)) allocated += now;
  }
  EXPECT_EQ(allocated, 0u);
}

}  // namespace
}  // namespace downrange
