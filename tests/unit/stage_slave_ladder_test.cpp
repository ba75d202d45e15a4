/// What an antenna follows: every rung of the ladder, down and up again without a step; when coasting ends; the plan.
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <downrange/stage/engine.hpp>
#include <map>

#include "stage/deviation.hpp"
#include "stage/slave/nominal_aim.hpp"
#include "stage/slaving_notes.hpp"
#include "stage_integrity_testing.hpp"
#include "stage_slave_testing.hpp"

namespace downrange {
namespace {

using namespace test;

/// small_range's vehicle, displaced.
std::function<PositionVelocity(double)> climb(const Eigen::Vector3d& off_m = Eigen::Vector3d::Zero()) {
  return [off_m](double t) {
    return PositionVelocity{{vehicle_at(t).m + off_m}, {(vehicle_at(t + 0.01).m - vehicle_at(t - 0.01).m) / 0.02}};
  };
}

NominalTrajectory plan_of_climb(double until_s = 200) {
  std::vector<NominalSample> samples;
  for (double t = 0; t <= until_s; t += 1) samples.push_back({t, climb()(t)});
  return NominalTrajectory(samples);
}

double apart(const SlavingCommand& a, const SlavingCommand& b) {
  const Eigen::Vector3d u = enu_from_polar({1, a.azimuth_rad, a.elevation_rad}).m;
  const Eigen::Vector3d v = enu_from_polar({1, b.azimuth_rad, b.elevation_rad}).m;
  return std::atan2(u.cross(v).norm(), u.dot(v));
}

TEST(Ladder, EveryRungDownAndUpWithoutAStep) {
  RangeConfig range = mount_range();
  range.targets[0].nominal = plan_of_climb();
  range.slave.nominal_sigma_m = 2000;
  // What the rungs say differs by degrees.
  Knows selected;
  selected.path = climb({3000, 0, 0});
  Knows lone;
  lone.path = climb({0, 3000, 0});
  Knows receiver;
  receiver.path = climb({0, 0, 3000});
  struct Window {
    double from;
    double to;
  };
  // Which is to be had when; nobody between 100 s and 120 s.
  const Window of_selected{20, 40}, of_selected_again{160, 200}, of_lone{30, 60}, of_lone_again{140, 200},
      of_receiver{50, 80}, of_receiver_again{120, 200};
  const auto within = [](double t, Window w) { return t >= w.from && t < w.to; };
  Slave slave(range);
  Collector out;
  std::vector<SlavingCommand> commands;
  Time last_selected = liftoff - seconds(1000);
  Time last_lone = last_selected;
  Time last_receiver = last_selected;
  for (Time tick = liftoff; tick < liftoff + seconds(190); tick = tick + range.tick) {
    const double t = (tick - liftoff).seconds();
    if (within(t, of_selected) || within(t, of_selected_again)) last_selected = tick;
    if (within(t, of_lone) || within(t, of_lone_again)) last_lone = tick;
    if (within(t, of_receiver) || within(t, of_receiver_again)) last_receiver = tick;
    selected.data_epoch = last_selected;
    lone.data_epoch = last_lone;
    receiver.data_epoch = last_receiver;
    const std::vector<LoneSource> alone{
        {.method = &lone, .newest = last_lone, .chain = "only-jeju"},
        {.method = &receiver, .newest = last_receiver, .chain = "only-GPS", .receiver = true}};
    const Followed followed{.method = &selected, .newest = last_selected, .lone = alone};
    out.results.clear();
    slave.tick(tick, std::span(&followed, 1), liftoff, out);
    const auto of_tick = out.of<SlavingCommand>();
    ASSERT_EQ(of_tick.size(), 1u) << t;
    commands.push_back(of_tick[0]);
  }
  // Down and up.
  std::vector<SlavingSource> order;
  for (const SlavingCommand& c : commands) {
    if (order.empty() || order.back() != c.source) order.push_back(c.source);
  }
  using enum SlavingSource;
  const std::vector<SlavingSource> expected{Nominal, Fused, Coasting,     SingleSensor, Gps,
                                            Nominal, Gps,   SingleSensor, Fused};
  EXPECT_EQ(order, expected);
  std::map<SlavingSource, Name> chains;
  for (const SlavingCommand& c : commands) chains[c.source] = c.chain;
  EXPECT_EQ(chains[SingleSensor], Name("only-jeju"));
  EXPECT_EQ(chains[Gps], Name("only-GPS"));
  // Beside the target's own motion, which is less than that from here on.
  const double target = 1.5 * deg * 0.025;
  for (std::size_t i = 760; i < commands.size(); ++i) {
    ASSERT_LE(apart(commands[i - 1], commands[i]), 1.02 * range.slave.blend_rate_rad_s * 0.025 + target)
        << (commands[i].tick - liftoff).seconds();
  }
  // Without the blend there would be steps.
  EXPECT_GT(apart(commands[760], commands[880]), 2 * deg);
}

TEST(Ladder, TheBestAloneStaysWhileItIsThere) {
  RangeConfig range = mount_range();
  Told nobody;
  Knows a;
  a.path = climb();
  Knows b;
  b.path = climb();
  Time tick = liftoff + seconds(60);
  Slave slave(range);
  Collector out;
  const auto chain_with = [&](double sigma_a, double sigma_b, bool both) {
    tick = tick + range.tick;
    a.data_epoch = b.data_epoch = tick;
    a.sigma_m = sigma_a;
    b.sigma_m = sigma_b;
    std::vector<LoneSource> alone{{.method = &b, .newest = tick, .chain = "only-b"}};
    if (both) alone.push_back({.method = &a, .newest = tick, .chain = "only-a"});
    const Followed followed{.method = &nobody, .newest = tick, .lone = alone};
    out.results.clear();
    slave.tick(tick, std::span(&followed, 1), liftoff, out);
    return out.of<SlavingCommand>().at(0).chain;
  };
  EXPECT_EQ(chain_with(10, 20, true), Name("only-a"));
  EXPECT_EQ(chain_with(30, 20, true), Name("only-a"));
  EXPECT_EQ(chain_with(30, 20, false), Name("only-b"));
  EXPECT_EQ(chain_with(10, 20, true), Name("only-b"));
}

/// How long commands coast, s, with a sigma that grows by that much a second.
double coasts_for(const RangeConfig& range, double sigma_m_s, std::optional<double> bound_m = {}) {
  Knows method;
  method.path = climb();
  const std::vector<Alternative> alternatives{{.from_selected_m = {bound_m.value_or(0), 0, 0}}};
  Slave slave(range);
  Collector out;
  const Time last = liftoff + seconds(60);
  Time newest = last;
  for (Time tick = last; tick < last + seconds(100); tick = tick + range.tick) {
    method.data_epoch = last;
    method.sigma_m = 1 + sigma_m_s * (tick - last).seconds();
    const bool told = bound_m && tick < last + seconds(4);
    const Followed followed{.method = &method,
                            .newest = last,
                            .alternatives = told ? std::span(alternatives) : std::span<const Alternative>{},
                            .bounded = told};
    out.results.clear();
    slave.tick(tick, std::span(&followed, 1), {}, out);
    if (!out.of<SlavingCommand>().empty()) newest = tick;
  }
  return (newest - last).seconds();
}

TEST(Ladder, CoastingEndsByTheProbabilityInTheBeam) {
  RangeConfig range = mount_range();
  EXPECT_NEAR(coasts_for(range, 10), 5, 1e-9);  // no beam is known: by time
  AntennaConfig& antenna = range.antennas[0];
  antenna.beamwidth_rad = 1 * deg;
  const double slant = antenna.site.enu_of(vehicle_at(75)).m.norm();
  // Round on the sky: 0.1 = 1 - exp(-r^2 / 2 s^2) where s is 2.18 times the beam's radius.
  const double sigma = 2.178 * 0.5 * deg * slant;
  EXPECT_NEAR(coasts_for(range, sigma / 15), 15, 1);
  EXPECT_NEAR(coasts_for(range, sigma / 2.5), 2.2, 0.4);  // and earlier, where it is lost earlier
  EXPECT_NEAR(coasts_for(range, 0), 60, 1e-9);            // never longer than a minute
  range.slave.beam_probability_min = 0.9;
  EXPECT_LT(coasts_for(range, sigma / 15), 7);
  // What one lie may have done counts where time alone would have ended it.
  range.slave.beam_probability_min = 0.1;
  EXPECT_NEAR(coasts_for(range, sigma / 15, 0.5 * deg * slant), 15, 1);
  EXPECT_NEAR(coasts_for(range, sigma / 15, 3 * deg * slant), 5, 1e-9);
}

TEST(Ladder, ProbabilityInTheBeamGoesWithTheCommand) {
  RangeConfig range = mount_range();
  Knows method;
  method.path = climb();
  method.sigma_m = 100;
  EXPECT_FALSE(fly(range, method, 60, 61).commands.back().probability_valid);
  range.antennas[0].beamwidth_rad = 1 * deg;
  const SlavingCommand c = fly(range, method, 60, 61).commands.back();
  ASSERT_TRUE(c.probability_valid);
  const double s = 0.5 * deg / (100 / c.range_m);
  EXPECT_NEAR(c.probability_in_beam, -std::expm1(-s * s / 2), 1e-3);
  // An antenna that is held at its end does not see the target.
  range.antennas[0].elevation_max_rad = 5 * deg;
  const SlavingCommand held = fly(range, method, 60, 61).commands.back();
  EXPECT_LT(held.probability_in_beam, 1e-6);
  EXPECT_GT(held.off_target_rad, 5 * deg);
}

/// Commands with nothing measured.
std::optional<SlavingCommand> planned_at(const RangeConfig& range, double t, std::optional<Time> when) {
  Told nobody;
  Slave slave(range);
  Collector out;
  const Followed followed{.method = &nobody, .newest = liftoff - seconds(1e6)};
  slave.tick(liftoff + seconds(t), std::span(&followed, 1), when, out);
  const auto commands = out.of<SlavingCommand>();
  return commands.empty() ? std::nullopt : std::optional(commands[0]);
}

TEST(Nominal, IsTheAimBeforeTheFirstPlotAndTheLastRung) {
  RangeConfig range = mount_range();
  EXPECT_FALSE(planned_at(range, -100, {}));
  range.targets[0].nominal = plan_of_climb();
  const AntennaConfig& antenna = range.antennas[0];
  const auto expect_at = [&](const std::optional<SlavingCommand>& c, double t) {
    ASSERT_TRUE(c);
    EXPECT_EQ(c->source, SlavingSource::Nominal);
    const Polar q = polar_from_enu(antenna.site.enu_of(vehicle_at(t)));
    EXPECT_NEAR(wrap_pi(c->azimuth_rad - q.azimuth_rad), 0, 1e-6);
    EXPECT_NEAR(c->elevation_rad, std::max(q.elevation_rad, 0.0), 1e-6);
    EXPECT_FALSE(c->bound_valid);
  };
  expect_at(planned_at(range, -100, {}), 0);         // before lift-off the vehicle is on its pad
  expect_at(planned_at(range, 300, {}), 0);          // and until it is known
  expect_at(planned_at(range, -100, liftoff), 0);    // announced ahead
  expect_at(planned_at(range, 60, liftoff), 60.05);  // T+, at the instant of application
  EXPECT_EQ(planned_at(range, -100, {})->azimuth_rate_rad_s, 0);
  EXPECT_NEAR(planned_at(range, 60, liftoff)->age_s, 60.05, 1e-9);
  EXPECT_FALSE(planned_at(range, 201, liftoff));  // the plan has ended
  // How far a vehicle may be from it.
  const SlavingCommand c = *planned_at(range, 60, liftoff);
  const double way = (vehicle_at(60.05).m - vehicle_at(0).m).norm();
  EXPECT_NEAR(c.sigma_elevation_rad * c.range_m, 100 + 0.01 * way, 2);
}

TEST(Nominal, IsNotFollowedByOneWhoLeftIt) {
  RangeConfig range = mount_range();
  range.targets[0].nominal = plan_of_climb();
  for (const double off_m : {100.0, 30'000.0}) {
    Knows method;
    method.path = climb({off_m, 0, 0});
    method.data_epoch = liftoff + seconds(60);
    Slave slave(range);
    Collector out;
    for (Time tick = method.data_epoch; tick < liftoff + seconds(70); tick = tick + range.tick) {
      const Followed followed{.method = &method, .newest = method.data_epoch};
      slave.tick(tick, std::span(&followed, 1), liftoff, out);
    }
    const SlavingCommand last = out.of<SlavingCommand>().back();
    EXPECT_EQ(last.source, off_m < 1000 ? SlavingSource::Nominal : SlavingSource::Coasting);
    EXPECT_NEAR((last.tick - liftoff).seconds(), off_m < 1000 ? 69.975 : 65, 1e-6);
  }
}

/// A coasting track falls freely, whatever the vehicle does: it does not leave the plan by that.
TEST(Nominal, IsNotLeftByCoasting) {
  RangeConfig range = mount_range();
  range.targets[0].nominal = plan_of_climb();
  Knows method;
  method.data_epoch = liftoff + seconds(60);
  method.path = [](double t) {
    PositionVelocity x = climb()(t);
    if (t > 60) x.position.m.x() += 5000 * (t - 60);
    return x;
  };
  Slave slave(range);
  Collector out;
  for (Time tick = method.data_epoch; tick < liftoff + seconds(70); tick = tick + range.tick) {
    const Followed followed{.method = &method, .newest = method.data_epoch};
    slave.tick(tick, std::span(&followed, 1), liftoff, out);
  }
  EXPECT_EQ(out.of<SlavingCommand>().back().source, SlavingSource::Nominal);
}

/// The second object's plan begins when the first one lets it go: its antenna waits there.
TEST(Nominal, OfSeveralObjects) {
  RangeConfig range = mount_range();
  range.targets.push_back({"stage-2", plan_of_climb()});
  std::vector<NominalSample> later;
  for (double t = 100; t <= 200; t += 1) later.push_back({t, climb({5000, 0, 0})(t)});
  range.targets[1].nominal = NominalTrajectory(later);
  range.targets[0].nominal = plan_of_climb();
  range.antennas.push_back(range.antennas[0]);
  range.antennas[1].id = "other";
  range.antennas[1].target = "stage-2";
  Told nobody;
  Slave slave(range);
  const std::vector<Followed> followed(2, Followed{.method = &nobody, .newest = liftoff - seconds(1e6)});
  const auto range_of_other = [&](double t) {
    Collector out;
    slave.tick(liftoff + seconds(t), followed, liftoff, out);
    const auto commands = out.of<SlavingCommand>();
    EXPECT_EQ(commands.size(), 2u);
    EXPECT_EQ(commands.at(1).target, Name("stage-2"));
    return commands.at(1).range_m;
  };
  const auto exact = [&](double t) { return range.antennas[0].site.enu_of(climb({5000, 0, 0})(t).position).m.norm(); };
  EXPECT_NEAR(range_of_other(50), exact(100), 1);
  EXPECT_NEAR(range_of_other(150), exact(150.05), 1);
}

/// A pass from 170 deg to 320 deg: the cable is laid by the plan before the vehicle moves.
TEST(Nominal, ChoosesTheTurnBeforeLiftoff) {
  RangeConfig range = mount_range();
  const Site& site = range.antennas[0].site;
  const auto path = [&](double t) {
    const auto at = [&](double s) {
      return site.ecef_of(enu_from_polar({20'000, (170 + 1.5 * std::max(s, 0.0)) * deg, 20 * deg}));
    };
    return PositionVelocity{
        at(t), {t < 0 ? Eigen::Vector3d::Zero() : Eigen::Vector3d((at(t + 0.01).m - at(t - 0.01).m) / 0.02)}};
  };
  std::vector<NominalSample> samples;
  for (double t = 0; t <= 100; t += 0.5) samples.push_back({t, path(t)});
  range.targets[0].nominal = NominalTrajectory(samples);
  EXPECT_NEAR(planned_at(range, -100, {})->azimuth_rad, -190 * deg, 1e-3);
  Knows method;
  method.path = path;
  const Flown flown = fly(range, method, -20, 100);
  EXPECT_EQ(flown.went_around, 0);
  EXPECT_NEAR(flown.commands.back().azimuth_rad, -40 * deg, 0.5 * deg);
  // Without a plan nobody can know.
  range.targets[0].nominal = {};
  EXPECT_EQ(fly(range, method, -20, 100).went_around, 1);
}

TEST(Deviation, AlongAcrossAndUp) {
  const NominalTrajectory plan = plan_of_climb();
  const PositionVelocity planned = *plan.at(60);
  const Rotation<Enu, Ecef> R = enu_from_ecef_at(geodetic_from_ecef(planned.position));
  const Eigen::Vector3d v = (R * planned.velocity).m_s;
  const double course = std::atan2(v.x(), v.y());
  const auto at_enu = [&](double ahead, double right, double up) -> Eigen::Vector3d {
    const Eigen::Vector3d enu(ahead * std::sin(course) + right * std::cos(course),
                              ahead * std::cos(course) - right * std::sin(course), up);
    return planned.position.m + R.inverse().R * enu;
  };
  Eigen::Matrix3d cov = Eigen::Vector3d(4, 9, 16).asDiagonal();  // on axes east, north, up
  cov = R.inverse().R * cov * R.R;
  const auto d = deviation_from(plan, 60, at_enu(300, -20, 5), cov);
  ASSERT_TRUE(d);
  EXPECT_NEAR(d->m[0], 300, 1e-6);
  EXPECT_NEAR(d->m[1], -20, 1e-6);
  EXPECT_NEAR(d->m[2], 5, 1e-6);
  EXPECT_NEAR(d->sigma_m[0], std::hypot(2 * std::sin(course), 3 * std::cos(course)), 1e-6);
  EXPECT_NEAR(d->sigma_m[1], std::hypot(2 * std::cos(course), 3 * std::sin(course)), 1e-6);
  EXPECT_NEAR(d->sigma_m[2], 4, 1e-6);
  EXPECT_FALSE(deviation_from(plan, -0.1, at_enu(0, 0, 0), cov));
  EXPECT_FALSE(deviation_from(plan, 200.1, at_enu(0, 0, 0), cov));
  EXPECT_FALSE(deviation_from({}, 60, at_enu(0, 0, 0), cov));
  // While it rises straight, along is where it will go.
  std::vector<NominalSample> rises{
      {0, {pad().ecef(), {}}}, {10, {pad().ecef_of({{0, 0, 100}}), {}}}, {100, {pad().ecef_of({{9e4, 0, 1e5}}), {}}}};
  const Eigen::Vector3d east = pad().ecef_of({{50, 0, 0}}).m;
  EXPECT_NEAR(deviation_from(NominalTrajectory(rises), 0, east, cov)->m[0], 50, 0.1);
}

/// The same through the whole engine: radars and receiver fall silent, the plan is left, all return.
std::vector<Event> flight_with_a_gap(const RangeConfig& range, double from, double to) {
  MissionEvent announced;
  announced.kind = MissionEventKind::Liftoff;
  announced.epoch = liftoff;
  announced.received = liftoff + seconds(0.2);
  announced.simulated = true;
  std::vector<Event> events{announced};
  for (const Event& e : small_flight(range, 90, 11)) {
    const double t = (received_of(e) - liftoff).seconds();
    if (t < from || t > to) events.push_back(e);
  }
  return events;
}

Collector run(const RangeConfig& range, const std::vector<Event>& events) {
  Collector out;
  Engine engine(range, {}, out);
  for (const Event& e : events) engine.handle(engine.admit(e));
  return out;
}

/// Neither a source that INTEGRITY excludes nor one that an operator inhibits is followed alone.
TEST(Ladder, ALiarIsNotFollowedAlone) {
  const RangeConfig range = judged_range();
  const auto alone = [](const Centre& centre) {
    std::vector<Name> names;
    for (const LoneSource& source : centre.followed().lone) names.push_back(source.chain);
    return names;
  };
  Centre centre(range, excluded(set_of(jeju), 22, 20));
  centre.handle(small_flight(range, 21, 4));
  EXPECT_EQ(alone(centre), (std::vector<Name>{"only-goheung", "only-jeju", "only-GPS"}));
  EXPECT_FALSE(centre.followed().lone[0].receiver);
  EXPECT_TRUE(centre.followed().lone[2].receiver);
  centre.advance_to(liftoff + seconds(23));
  EXPECT_EQ(alone(centre), (std::vector<Name>{"only-goheung", "only-GPS"}));
  centre.inhibited = gps;
  centre.advance_to(liftoff + seconds(24));
  EXPECT_EQ(alone(centre), (std::vector<Name>{"only-goheung"}));
}

TEST(Notes, EachChangeIsToldOnce) {
  SlavingNotes notes;
  SlavingCommand c;
  c.antenna = "dish";
  c.target = "kslv";
  const auto at = [&](double t, SlavingSource source, const Name& chain = {}) {
    c.tick = liftoff + seconds(t);
    c.source = source;
    c.chain = chain;
    return notes.change(c);
  };
  using enum SlavingSource;
  EXPECT_EQ(at(0, Nominal), "dish follows kslv by the nominal trajectory");
  EXPECT_EQ(at(1, Nominal), "");
  EXPECT_EQ(at(2, Fused), "dish follows kslv by the fused track");
  EXPECT_EQ(at(2.1, Fused, "without-jeju"), "");  // INTEGRITY says that
  EXPECT_EQ(at(2.2, Coasting), "");               // a slow radar
  EXPECT_EQ(at(2.9, Fused), "");
  EXPECT_EQ(at(3, Coasting), "");
  EXPECT_EQ(at(3.9, Coasting), "");
  EXPECT_EQ(at(4, Coasting), "dish follows kslv by the coasting track");
  EXPECT_EQ(at(5, SingleSensor, "only-jeju"), "dish follows kslv by one source alone (only-jeju)");
  EXPECT_EQ(at(6, SingleSensor, "only-goheung"), "dish follows kslv by one source alone (only-goheung)");
  EXPECT_EQ(at(7, Gps, "only-GPS"), "dish follows kslv by GPS alone (only-GPS)");
  EXPECT_TRUE(notes.ends(liftoff + seconds(7.9)).empty());
  ASSERT_EQ(notes.ends(liftoff + seconds(8)).size(), 1u);
  EXPECT_TRUE(notes.ends(liftoff + seconds(9)).empty());
  EXPECT_EQ(at(10, Gps, "only-GPS"), "dish follows kslv by GPS alone (only-GPS)");
  c.target = "stage-1";
  EXPECT_EQ(at(11, Gps, "only-GPS"), "dish follows stage-1 by GPS alone (only-GPS)");
}

TEST(Notes, AMountsErrorIsToldWhenItHasChanged) {
  SlavingNotes notes;
  SlavingCommand c;
  c.antenna = "dish";
  const auto with = [&](double azimuth_deg, double elevation_deg) {
    c.mount_azimuth_rad = azimuth_deg * deg;
    c.mount_elevation_rad = elevation_deg * deg;
    return notes.mount_error(c);
  };
  EXPECT_EQ(with(0, 0), "");
  EXPECT_EQ(with(0.5, -0.3),
            "dish: its mount reads +0.50 deg in azimuth and -0.30 deg in elevation when it is on its target; commands "
            "have that added");
  EXPECT_EQ(with(0.52, -0.28), "");
  EXPECT_NE(with(0.56, -0.28), "");
  EXPECT_EQ(with(0, 0), "dish: what its mount reads tells no pointing error any more");
}

TEST(Ladder, ThroughTheEngineAndTheSameInReplay) {
  RangeConfig range = small_range();
  range.targets[0].nominal = plan_of_climb();
  range.slave.nominal_sigma_m = 300;
  range.fuse.methods = {"joint"};
  range.antennas[0].beamwidth_rad = 0;
  const auto events = flight_with_a_gap(range, 40, 60);
  const Collector once = run(range, events);
  const Collector twice = run(range, events);
  ASSERT_EQ(once.results.size(), twice.results.size());
  std::vector<SlavingSource> order;
  std::vector<SlavingCommand> of_first;
  for (std::size_t i = 0; i < once.results.size(); ++i) {
    ASSERT_TRUE(once.results[i] == twice.results[i]) << i;
    const auto* c = std::get_if<SlavingCommand>(&once.results[i]);
    if (c == nullptr || c->antenna != range.antennas[0].id) continue;
    if (order.empty() || order.back() != c->source) order.push_back(c->source);
    of_first.push_back(*c);
  }
  using enum SlavingSource;
  ASSERT_GE(order.size(), 4u);
  EXPECT_EQ(order.front(), Nominal);
  const std::vector<SlavingSource> end(order.end() - 4, order.end());
  EXPECT_EQ(end, (std::vector{Fused, Coasting, Nominal, Fused}));
  for (std::size_t i = 1; i < of_first.size(); ++i) {
    const double t = (of_first[i].tick - liftoff).seconds();
    EXPECT_EQ((of_first[i].tick - of_first[i - 1].tick).ns, range.tick.ns) << t;  // no hole
    if (t < 35) continue;
    EXPECT_LT(apart(of_first[i - 1], of_first[i]), 1.02 * range.slave.blend_rate_rad_s * 0.025 + 1.5 * deg * 0.025)
        << t;
  }
  // The deviation from the plan, which the vehicle follows here.
  int deviations = 0;
  int inside = 0;
  for (const Trajectory& t : once.of<Trajectory>()) {
    if ((t.epoch - liftoff).seconds() < 25) continue;
    ASSERT_TRUE(t.deviation_valid);
    for (std::size_t k = 0; k < 3; ++k) {
      ++deviations;
      inside += std::abs(t.deviation_m[k]) < 4 * t.deviation_sigma_m[k] ? 1 : 0;
    }
  }
  EXPECT_GT(deviations, 100);
  EXPECT_GT(inside, 0.98 * deviations);
}

}  // namespace
}  // namespace downrange
