/// The engine: ticks before events, same bits again, split like whole, doubles and order irrelevant, health counts.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>
#include <downrange/stage/engine.hpp>
#include <iterator>
#include <random>

#include "../support/small_range.hpp"

namespace downrange {
namespace {

using test::Collector;
using test::small_flight;
using test::small_range;

Collector run(const RangeConfig& range, const std::vector<Event>& events, StageSet stages = {}) {
  Collector out;
  Engine engine(range, stages, out);
  for (const Event& e : events) engine.handle(engine.admit(e));
  return out;
}

/// Everything of a trajectory that an antenna or an analyst sees.
auto key_of(const Trajectory& t) {
  return std::tie(t.target, t.method, t.epoch, t.received, t.state, t.covariance, t.sources, t.nis);
}
auto key_of(const SlavingCommand& c) {
  return std::tie(c.antenna, c.tick, c.apply_at, c.data_epoch, c.azimuth_rad, c.elevation_rad, c.range_m,
                  c.azimuth_rate_rad_s, c.sigma_azimuth_rad, c.source, c.limits);
}
auto key_of(const SensorBias& b) {
  return std::tie(b.sensor, b.method, b.epoch, b.received, b.value, b.covariance, b.samples);
}

template <class T>
void expect_same(const Collector& a, const Collector& b) {
  const auto x = a.of<T>();
  const auto y = b.of<T>();
  ASSERT_EQ(x.size(), y.size());
  ASSERT_FALSE(x.empty());
  for (std::size_t i = 0; i < x.size(); ++i) ASSERT_TRUE(key_of(x[i]) == key_of(y[i])) << "record " << i;
}

TEST(Engine, SameEventsSameBits) {
  const RangeConfig range = small_range();
  const auto events = small_flight(range, 30, 1);
  const Collector a = run(range, events);
  const Collector b = run(range, events);
  expect_same<Trajectory>(a, b);
  expect_same<SlavingCommand>(a, b);
  expect_same<SensorBias>(a, b);
}

TEST(Engine, SplitIntoIngestAndCentreGivesTheSameBits) {
  const RangeConfig range = small_range();
  const auto events = small_flight(range, 30, 2);
  const Collector whole = run(range, events);
  const Collector ingest = run(range, events, {.ingest = true, .align = false, .fuse = false, .slave = false});
  std::vector<Event> observations;
  for (const Observation& o : ingest.of<Observation>()) observations.emplace_back(o);
  EXPECT_EQ(observations.size(), events.size());
  EXPECT_TRUE(ingest.of<Trajectory>().empty());
  const Collector centre = run(range, observations, {.ingest = false, .align = true, .fuse = true, .slave = true});
  expect_same<Trajectory>(whole, centre);
  expect_same<SlavingCommand>(whole, centre);
  expect_same<SensorBias>(whole, centre);
}

TEST(Engine, TwoIngestNodesThatBothHaveTheSameFixGiveTheSameBits) {
  const RangeConfig range = small_range();
  const auto events = small_flight(range, 30, 12);
  const Collector whole = run(range, events);
  // Each node has one radar and one station; every fix comes by both stations.
  std::vector<Event> of_node[2];
  for (const Event& e : events) {
    const auto* plot = std::get_if<RadarTspi>(&e);
    const auto* fix = std::get_if<GpsFix>(&e);
    const bool first = plot != nullptr ? plot->sensor == range.radars[0].id : fix->station == range.telemetry[0].id;
    of_node[first ? 0 : 1].push_back(e);
  }
  std::vector<Event> observations;
  for (const auto& node : of_node) {
    const Collector out = run(range, node, {.ingest = true, .align = false, .fuse = false, .slave = false});
    for (const Observation& o : out.of<Observation>()) observations.emplace_back(o);
  }
  std::stable_sort(observations.begin(), observations.end(), [](const Event& a, const Event& b) {
    if (received_of(a) != received_of(b)) return received_of(a) < received_of(b);
    return step_order_less(a, b);
  });
  const Collector centre = run(range, observations, {.ingest = false, .align = true, .fuse = true, .slave = true});
  expect_same<Trajectory>(whole, centre);
  expect_same<SlavingCommand>(whole, centre);
  expect_same<SensorBias>(whole, centre);
}

TEST(Engine, TicksRunBeforeEventsAndOnTheUtcGrid) {
  const RangeConfig range = small_range();
  const auto events = small_flight(range, 10, 3);
  const Collector out = run(range, events);
  Time last_tick{};
  Time last_received{};
  for (const Result& r : out.results) {
    if (const auto* c = std::get_if<SlavingCommand>(&r)) {
      EXPECT_EQ(c->tick.ns % range.tick.ns, 0);
      EXPECT_GE(c->tick, last_received);  // a tick after the events before it
      last_tick = c->tick;
    }
    if (const auto* o = std::get_if<Observation>(&r)) {
      EXPECT_LE(last_tick, o->received);  // and before the events after it
      last_received = o->received;
    }
  }
  EXPECT_GT(last_tick.ns, 0);
}

TEST(Engine, AnEventStampedBeforeTheLastTickIsRaisedToIt) {
  const RangeConfig range = small_range();
  Collector out;
  Engine engine(range, {}, out);
  engine.advance_to(test::liftoff + seconds(10.0));
  const Time tick = engine.last_tick();
  EXPECT_EQ(tick, test::liftoff + seconds(10.0));
  const Event early = test::plot_at(range.radars[0], 9.9, 1, 0.01);
  EXPECT_EQ(received_of(engine.admit(early)), tick);
  const Event later = test::plot_at(range.radars[0], 10.1, 2, 0.01);
  EXPECT_EQ(received_of(engine.admit(later)), test::liftoff + seconds(10.11));
}

TEST(Engine, ASilenceSteppedThroughLiveEqualsOneJumpedOverInReplay) {
  const RangeConfig range = small_range();
  auto events = small_flight(range, 10, 10);
  const Time resumed = test::liftoff + seconds(3000.0);
  Event late = test::plot_at(range.radars[0], 3000, 1'000'000);
  Collector live;
  Collector replayed;
  {
    Engine engine(range, {}, live);
    for (const Event& e : events) engine.handle(engine.admit(e));
    for (Time t = test::liftoff + seconds(12.0); t < resumed; t = t + milliseconds(25)) engine.advance_to(t);
    engine.handle(engine.admit(late));
  }
  {
    Engine engine(range, {}, replayed);
    for (const Event& e : events) engine.handle(engine.admit(e));
    engine.handle(engine.admit(late));
  }
  EXPECT_EQ(live.results.size(), replayed.results.size());
  EXPECT_EQ(live.of<SourceHealth>().size(), replayed.of<SourceHealth>().size());
  expect_same<SlavingCommand>(live, replayed);
  expect_same<Trajectory>(live, replayed);
}

/// FUSE's keys judge its trajectories, SLAVE's its commands: neither those of the other.
TEST(Engine, ATrajectoryCoastsByTheKeysOfFuse) {
  RangeConfig range = small_range();
  range.fuse.publish_on_data = false;
  range.fuse.stale = milliseconds(2000);
  range.fuse.coast = milliseconds(4000);
  ASSERT_EQ(range.slave.coast, milliseconds(5000));
  Collector out;
  Engine engine(range, {}, out);
  for (const Event& e : small_flight(range, 10, 11)) engine.handle(engine.admit(e));
  engine.advance_to(test::liftoff + seconds(20.0));
  constexpr double slack_s = 0.2;  // of the newest measurement, which is one of the last in 10 s
  double last_good_s = 0;
  double last_s = 0;
  for (const Trajectory& t : out.of<Trajectory>()) {
    last_s = (t.received - test::liftoff).seconds();
    if (t.quality == TrackQuality::Good) last_good_s = last_s;
  }
  EXPECT_NEAR(last_good_s, 12, slack_s);
  EXPECT_NEAR(last_s, 14, slack_s);
  EXPECT_NEAR((out.of<SlavingCommand>().back().tick - test::liftoff).seconds(), 15, slack_s);
}

TEST(Engine, ATrajectoryOfLateDataIsCoasting) {
  const auto coasting = [](Duration stale) {
    RangeConfig range = small_range();
    range.fuse.stale = stale;
    std::vector<Event> late;
    for (std::uint64_t i = 1; i <= 50; ++i)
      late.emplace_back(test::plot_at(range.radars[0], 10 + 0.1 * static_cast<double>(i), i, 1.0));
    const auto trajectories = run(range, late).of<Trajectory>();
    EXPECT_FALSE(trajectories.empty());
    return std::ranges::count(trajectories, TrackQuality::Coasting, &Trajectory::quality) ==
           std::ranges::ssize(trajectories);
  };
  EXPECT_TRUE(coasting(milliseconds(500)));
  EXPECT_FALSE(coasting(milliseconds(2000)));
}

TEST(Engine, TicksOfAClockGapAreNotRun) {
  const RangeConfig range = small_range();
  auto events = small_flight(range, 10, 10);
  Collector out;
  Engine engine(range, {}, out);
  for (const Event& e : events) engine.handle(engine.admit(e));
  const ClockGap gap{.epoch = test::liftoff + seconds(3610.01), .received = engine.last_tick()};
  engine.handle(engine.admit(gap));
  EXPECT_EQ(engine.last_tick(), test::liftoff + seconds(3610.0));
  const Event sent_before = test::plot_at(range.radars[0], 10.5, 999'999);
  EXPECT_EQ(received_of(engine.admit(sent_before)), engine.last_tick());
  engine.advance_to(test::liftoff + seconds(3612.0));
  EXPECT_EQ(engine.last_tick(), test::liftoff + seconds(3612.0));
  for (const SourceHealth& h : out.of<SourceHealth>()) EXPECT_FALSE(h.time > gap.received && h.time < gap.epoch);
  EXPECT_GT(out.of<SourceHealth>().back().time, gap.epoch);
}

TEST(Engine, AClockGapThatIsNoneChangesNothing) {
  const RangeConfig range = small_range();
  Collector out;
  Engine engine(range, {}, out);
  engine.handle(ClockGap{.epoch = test::liftoff + seconds(10.0), .received = test::liftoff});  // before any tick
  engine.advance_to(test::liftoff + seconds(20.0));
  EXPECT_EQ(engine.last_tick(), test::liftoff + seconds(20.0));
  for (const Time epoch : {test::liftoff, test::liftoff + seconds(20.0), Time{-1}, Time{INT64_MAX}}) {
    engine.handle(ClockGap{.epoch = epoch, .received = engine.last_tick()});
    EXPECT_EQ(engine.last_tick(), test::liftoff + seconds(20.0));
  }
}

TEST(Engine, TimesThatAreNoneMoveNothing) {
  const RangeConfig range = small_range();
  Collector out;
  Engine engine(range, {}, out);
  for (const Event& e : small_flight(range, 5, 10)) engine.handle(engine.admit(e));
  const Time before = engine.last_tick();
  RadarTspi absurd = test::plot_at(range.radars[0], 6, 999);
  absurd.received = Time{std::numeric_limits<std::int64_t>::max()};
  engine.handle(engine.admit(absurd));
  engine.advance_to(Time{std::numeric_limits<std::int64_t>::max()});
  EXPECT_EQ(engine.last_tick(), before);
  EXPECT_EQ(out.of<Observation>().back().verdict, Reason::OutOfLimits);
  const Time years_later = test::liftoff + seconds(3e8);
  engine.advance_to(years_later);  // 1e10 ticks if each were run
  EXPECT_GT(engine.last_tick(), years_later - range.tick);
}

TEST(Engine, DoublesChangeNothing) {
  const RangeConfig range = small_range();
  const auto events = small_flight(range, 30, 4);
  std::vector<Event> doubled;
  for (const Event& e : events) {
    doubled.push_back(e);
    doubled.push_back(e);
  }
  const Collector once = run(range, events);
  const Collector twice = run(range, doubled);
  expect_same<Trajectory>(once, twice);
  expect_same<SlavingCommand>(once, twice);
}

TEST(Engine, ArrivalShuffledInsideTheHistoryEndsInTheInOrderEstimate) {
  const RangeConfig range = small_range();
  auto events = small_flight(range, 30, 5);
  // In order: everything received the instant it was true. Shuffled: up to 3 s late; then one last plot for both.
  std::mt19937_64 rng(6);
  auto in_order = events;
  for (Event& e : in_order)
    std::visit(
        [](auto& x) {
          if constexpr (requires { x.epoch; }) x.received = x.epoch;
        },
        e);
  auto shuffled = in_order;
  for (Event& e : shuffled) set_received(e, received_of(e) + milliseconds(static_cast<std::int64_t>(rng() % 3000)));
  const auto by_received = [](const Event& a, const Event& b) { return received_of(a) < received_of(b); };
  std::stable_sort(in_order.begin(), in_order.end(), by_received);
  std::stable_sort(shuffled.begin(), shuffled.end(), by_received);
  const Event last = test::plot_at(range.radars[0], 34, 100000);
  in_order.push_back(last);
  shuffled.push_back(last);
  const auto a = run(range, in_order).of<Trajectory>();
  const auto b = run(range, shuffled).of<Trajectory>();
  ASSERT_FALSE(a.empty());
  EXPECT_TRUE(key_of(a.back()) == key_of(b.back()));
}

/// A minute on the pad, then a flight: what stands still shows the same errors again and again.
TEST(Engine, NoNoiseIsLearntOnThePad) {
  RangeConfig range = small_range();
  range.fuse.methods = {"joint"};
  range.integrity.enabled = false;  // this vehicle leaves its pad at 500 m/s: a lie to whoever doubts
  std::vector<Event> events;
  std::mt19937_64 rng(11);
  std::normal_distribution<double> normal;
  std::uint64_t sequence = 1'000'000;
  const auto at = [](auto message, double t_s) {
    message.epoch = test::liftoff + seconds(t_s);
    message.received = message.epoch + milliseconds(40);
    return message;
  };
  for (int tenth = -600; tenth < 0; ++tenth) {
    const double t_s = 0.1 * tenth;
    RadarTspi plot = at(test::plot_at(range.radars[0], 0, ++sequence), t_s);
    plot.measured.range_m += range.radars[0].sigma.range_m * normal(rng);
    events.emplace_back(plot);
    if (tenth % 10 != 0) continue;
    GpsFix fix = at(test::fix_at(range.telemetry[0].id, 0, ++sequence), t_s);
    for (int k = 0; k < 3; ++k) fix.position.m[k] += 5 * normal(rng);
    fix.velocity.m_s.setZero();
    events.emplace_back(fix);
  }
  std::ranges::copy(small_flight(range, 60, 12), std::back_inserter(events));
  double on_pad = 0;
  double in_flight = 0;
  for (const SourceHealth& health : run(range, events).of<SourceHealth>()) {
    if (health.sensor != range.radars[0].id) continue;
    double& learnt = health.time < test::liftoff ? on_pad : in_flight;
    learnt = std::max(learnt, health.sigma_ratio[0]);
    if (health.time > test::liftoff - seconds(1) && health.time < test::liftoff) {
      EXPECT_GT(health.count[static_cast<std::size_t>(Reason::Accepted)], 500u);
    }
  }
  EXPECT_EQ(on_pad, 0);
  EXPECT_NEAR(in_flight, 1, 0.2);
}

TEST(Engine, HealthCountsEverySampleOnce) {
  const RangeConfig range = small_range();
  auto events = small_flight(range, 20, 7);
  RadarTspi stranger = test::plot_at(range.radars[0], 19, 1);
  stranger.sensor = "stranger";
  events.emplace_back(stranger);
  Collector out;
  Engine engine(range, {}, out);
  std::stable_sort(events.begin(), events.end(),
                   [](const Event& a, const Event& b) { return received_of(a) < received_of(b); });
  for (const Event& e : events) engine.handle(engine.admit(e));
  engine.advance_to(test::liftoff + seconds(30.0));
  std::uint64_t total = 0;
  std::uint64_t duplicates = 0;
  std::uint64_t unknown = 0;
  for (const SourceHealth& h : out.of<SourceHealth>()) {
    if (h.time != test::liftoff + seconds(30.0)) continue;
    for (const std::uint64_t n : h.count) total += n;
    duplicates += h.count[static_cast<std::size_t>(Reason::Duplicate)];
    unknown += h.count[static_cast<std::size_t>(Reason::UnknownSource)];
    EXPECT_EQ(h.rate_hz, 0);  // nothing came in the last second
  }
  EXPECT_EQ(total, events.size());
  EXPECT_EQ(duplicates, 20u);  // every fix comes by two stations
  EXPECT_EQ(unknown, 1u);
}

TEST(Engine, AnglesGoToTheMethodsThatUseThem) {
  RangeConfig range = small_range();
  range.angle_sensors = {test::small_tracker()};
  range.fuse.methods = {"joint", "song2015"};
  const std::vector<Event> without = small_flight(range, 20, 7);
  std::vector<Event> events = without;
  std::uint64_t sequence = 0;
  for (double t = 2.005; t < 20; t += 0.1) events.emplace_back(test::angles_at(range.angle_sensors[0], t, ++sequence));
  std::stable_sort(events.begin(), events.end(),
                   [](const Event& a, const Event& b) { return received_of(a) < received_of(b); });
  const Collector out = run(range, events);
  const Collector radars = run(range, without);

  // song2015 is as it was, to the bit; joint knows more.
  const auto of_method = [](const Collector& from, const char* method) {
    std::vector<Trajectory> all = from.of<Trajectory>();
    std::erase_if(all, [&](const Trajectory& t) { return t.method != method; });
    return all;
  };
  const auto song = of_method(out, "song2015");
  const auto song_before = of_method(radars, "song2015");
  ASSERT_EQ(song.size(), song_before.size());
  for (std::size_t i = 0; i < song.size(); ++i) {
    EXPECT_EQ(song[i].state, song_before[i].state);
    EXPECT_EQ(song[i].covariance, song_before[i].covariance);
  }
  const auto joint = of_method(out, "joint");
  const auto joint_before = of_method(radars, "joint");
  EXPECT_GT(joint.size(), joint_before.size() + 100);
  EXPECT_NE(joint.back().sources & 4U, 0u);                 // the tracker, behind two radars
  EXPECT_NE(joint.back().sources & ~std::uint64_t{7}, 0u);  // a station, behind the sensors
  const auto variance = [](const Trajectory& t) { return t.covariance[0] + t.covariance[9] + t.covariance[17]; };
  EXPECT_LT(variance(joint.back()), variance(joint_before.back()));

  int biases = 0;
  for (const SensorBias& bias : out.of<SensorBias>()) {
    if (bias.sensor != range.angle_sensors[0].id) continue;
    ++biases;
    EXPECT_EQ(bias.method, Name("joint"));
    EXPECT_EQ(bias.terms, 2);
    EXPECT_EQ(bias.term[0], BiasTerm::OffsetAzimuth);
    EXPECT_EQ(bias.term[1], BiasTerm::OffsetElevation);
  }
  EXPECT_GT(biases, 100);

  std::uint64_t accepted = 0;
  for (const SourceHealth& h : out.of<SourceHealth>()) {
    if (h.sensor != range.angle_sensors[0].id) continue;
    accepted = h.count[static_cast<std::size_t>(Reason::Accepted)];
    EXPECT_EQ(h.count[static_cast<std::size_t>(Reason::Gated)], 0u);
  }
  EXPECT_GT(accepted, 100u);

  // A method of radars alone does not count them as gated either.
  range.fuse.methods = {"song2015"};
  for (const SourceHealth& h : run(range, events).of<SourceHealth>()) {
    if (h.sensor != range.angle_sensors[0].id) continue;
    EXPECT_EQ(h.count[static_cast<std::size_t>(Reason::Gated)], 0u);
  }
}

TEST(Engine, AbsurdInputLeavesNoTrace) {
  const RangeConfig range = small_range();
  const auto events = small_flight(range, 20, 8);
  std::vector<Event> poisoned;
  std::mt19937_64 rng(9);
  for (const Event& e : events) {
    if (const auto* p = std::get_if<RadarTspi>(&e)) {
      RadarTspi bad = *p;
      bad.sequence += 1'000'000;
      bad.epoch = bad.epoch + milliseconds(7);
      const double absurd[] = {std::nan(""), INFINITY, -1e300, 1e300, 1e18};
      bad.measured.range_m = absurd[rng() % 5];
      bad.measured.azimuth_rad = absurd[rng() % 5];
      poisoned.emplace_back(bad);
    }
    poisoned.push_back(e);
  }
  const Collector clean = run(range, events);
  const Collector dirty = run(range, poisoned);
  expect_same<Trajectory>(clean, dirty);
  expect_same<SlavingCommand>(clean, dirty);
}

}  // namespace
}  // namespace downrange
