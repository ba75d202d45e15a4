/// A simulated mount (15 deg/s, 20 deg/s^2) behind the commands: stops, turns, the keyhole, limits.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

#include "../support/allocations.hpp"
#include "stage/slave/keyhole.hpp"
#include "stage/slave/pass.hpp"
#include "stage/slave/turn.hpp"
#include "stage_slave_testing.hpp"

namespace downrange {
namespace {

using namespace test;

constexpr double pi = std::numbers::pi;

/// A target at 20 km that stands at an azimuth and hovers about it.
Knows hovering(const Site& site, double azimuth_rad, double amplitude_rad, double elevation_rad, double period_s) {
  Knows method;
  method.path = [=, &site](double t) {
    const auto at = [&](double s) {
      const double azimuth = azimuth_rad + amplitude_rad * std::sin(2 * pi * s / period_s);
      return site.ecef_of(enu_from_polar({20'000, azimuth, elevation_rad}));
    };
    return PositionVelocity{at(t), {(at(t + 0.01).m - at(t - 0.01).m) / 0.02}};
  };
  return method;
}

/// The largest step between two commands, rad, on either axis.
double largest_step(const std::vector<SlavingCommand>& commands) {
  double most = 0;
  for (std::size_t i = 1; i < commands.size(); ++i) {
    most = std::max({most, std::abs(commands[i].azimuth_rad - commands[i - 1].azimuth_rad),
                     std::abs(commands[i].elevation_rad - commands[i - 1].elevation_rad)});
  }
  return most;
}

struct Stop {
  double min_deg;
  double max_deg;
  double at_deg;
};

TEST(Mount, HoversAtAStopWithoutATurn) {
  for (const Stop stop : {Stop{-270, 270, 270}, Stop{-270, 270, -270}, Stop{-180, 180, 180}, Stop{-200, 380, 380},
                          Stop{-179.8, 179.8, 180}}) {
    for (const double period_s : {0.7, 6.0, 40.0}) {
      RangeConfig range = mount_range();
      range.antennas[0].azimuth_min_rad = stop.min_deg * deg;
      range.antennas[0].azimuth_max_rad = stop.max_deg * deg;
      Knows method = hovering(range.antennas[0].site, stop.at_deg * deg, 0.5 * deg, 20 * deg, period_s);
      // It comes there from a side of which the travel has one turn only.
      const double side = stop.at_deg > 0 ? -1 : 1;
      const auto hovers = method.path;
      Knows comes = hovering(range.antennas[0].site, 0, 0, 20 * deg, 1);
      const Site& site = range.antennas[0].site;
      comes.path = [&, hovers, side](double t) {
        if (t >= 0) return hovers(t);
        const auto at = [&](double s) {
          return site.ecef_of(enu_from_polar({20'000, stop.at_deg * deg - side * 3 * deg * s, 20 * deg}));
        };
        return PositionVelocity{at(t), {(at(t + 0.01).m - at(t - 0.01).m) / 0.02}};
      };
      const Flown flown = fly(range, comes, -70, 60);
      ASSERT_GT(flown.commands.size(), 5000u);
      const auto hovered = std::vector(flown.commands.end() - 2400, flown.commands.end());
      const bool far_side = std::abs(hovered.front().azimuth_rad - stop.at_deg * deg) > pi;
      EXPECT_LT(largest_step(hovered), 1 * deg) << stop.at_deg << ' ' << period_s << (far_side ? " far" : "");
      for (const SlavingCommand& c : hovered) {
        ASSERT_GE(c.azimuth_rad, stop.min_deg * deg);
        ASSERT_LE(c.azimuth_rad, stop.max_deg * deg);
      }
    }
  }
}

TEST(Mount, ATargetThatGoesOnBeyondAStopIsFollowedAround) {
  RangeConfig range = mount_range();
  Knows method;
  const Site& site = range.antennas[0].site;
  method.path = [&](double t) {
    const auto at = [&](double s) { return site.ecef_of(enu_from_polar({20'000, 2 * deg * s, 20 * deg})); };
    return PositionVelocity{at(t), {(at(t + 0.01).m - at(t - 0.01).m) / 0.02}};
  };
  const Flown flown = fly(range, method, 0, 200);  // 400 degrees
  EXPECT_EQ(flown.went_around, 1);
  std::optional<Time> around;
  double farthest = 0;
  for (const SlavingCommand& c : flown.commands) {
    if (c.limits & LimitUnwrapped) {
      EXPECT_NEAR(c.azimuth_rad, -89 * deg, 0.2 * deg);
      around = c.tick;
    }
    if (!around) continue;
    // 360 deg at 15 deg/s, for a target that moves by 2 deg/s.
    const double since = (c.tick - *around).seconds();
    farthest = std::max(farthest, c.off_target_rad);
    if (since < 21) {
      ASSERT_TRUE(c.limits & LimitRate) << since;
    } else if (since > 23) {
      ASSERT_EQ(c.limits, LimitNone) << since;
    }
  }
  ASSERT_TRUE(around);
  EXPECT_GT(farthest, 130 * deg);  // where the antenna is on its way
}

/// Where some turn of the travel holds a whole pass, the pass is followed on that turn.
TEST(Mount, NoGoAroundInAPassThatTheTravelHolds) {
  std::mt19937_64 rng(7);
  std::uniform_real_distribution<double> unit(0, 1);
  int held = 0;
  int wide = 0;
  int over = 0;
  for (int run = 0; run < 60; ++run) {
    RangeConfig range = mount_range();
    AntennaConfig& antenna = range.antennas[0];
    const double travel = 370 + 170 * unit(rng);
    antenna.azimuth_min_rad = (-360 + (720 - travel) * unit(rng)) * deg;
    antenna.azimuth_max_rad = antenna.azimuth_min_rad + travel * deg;
    antenna.elevation_max_rad = run % 3 == 0 ? pi : pi / 2;
    Knows method;
    method.path =
        orbit_pass(antenna.site, (run % 4 == 0 ? 4 + 3 * unit(rng) : 10 + 60 * unit(rng)) * deg, 360 * deg * unit(rng));
    // What a person sees who looks at the whole pass: does it fit?
    double from = 0, to = 0, azimuth = 0, begin_s = 1e9, end_s = -1e9;
    for (double t = -390; t < 390; t += 1) {
      const Polar q = polar_from_enu(antenna.site.enu_of(method.path(t).position));
      if (q.elevation_rad < 0) continue;
      azimuth = begin_s > t ? q.azimuth_rad : azimuth + wrap_pi(q.azimuth_rad - azimuth);
      from = begin_s > t ? azimuth : std::min(from, azimuth);
      to = begin_s > t ? azimuth : std::max(to, azimuth);
      begin_s = std::min(begin_s, t);
      end_s = t;
    }
    const auto fits = [&](double half) {
      for (int k = -3; k <= 3; ++k) {
        if (from + half + 2 * pi * k >= antenna.azimuth_min_rad && to + half + 2 * pi * k <= antenna.azimuth_max_rad)
          return true;
      }
      return false;
    };
    const bool fits_upright = fits(0);
    const bool fits_over = antenna.elevation_max_rad > pi / 2 && fits(pi);
    const Flown flown = fly(range, method, begin_s, end_s, {}, 1e9);
    for (const SlavingCommand& c : flown.commands) {
      ASSERT_GE(c.azimuth_rad, antenna.azimuth_min_rad);
      ASSERT_LE(c.azimuth_rad, antenna.azimuth_max_rad);
      ASSERT_GE(c.elevation_rad, antenna.elevation_min_rad);
      ASSERT_LE(c.elevation_rad, antenna.elevation_max_rad);
      ASSERT_TRUE(std::isfinite(c.azimuth_rate_rad_s) && std::isfinite(c.elevation_acceleration_rad_s2));
    }
    const bool is_wide = travel >= 450 && to - from <= 90 * deg;
    wide += is_wide ? 1 : 0;
    EXPECT_TRUE(!is_wide || fits_upright);
    if (!fits_upright && !fits_over) continue;
    ++held;
    over += fits_upright ? 0 : 1;
    EXPECT_EQ(flown.went_around, 0) << run << " travel " << travel;
    EXPECT_LT(flown.azimuth_way_rad, to - from + 2 * deg) << run;
  }
  EXPECT_GT(held, 30);
  EXPECT_GT(over, 0);
  EXPECT_GT(wide, 0);
}

/// A track's first velocity is a guess: the turn is chosen when it is known, at once, and not again.
TEST(Mount, TheTurnIsChosenWhenTheVelocityIsKnown) {
  RangeConfig range = mount_range();
  AntennaConfig& antenna = range.antennas[0];
  const Fall pass = orbit_pass(antenna.site, 40 * deg, 0);  // from south to north by the east
  const double from = polar_from_enu(antenna.site.enu_of(pass(-200).position)).azimuth_rad;
  const double to = polar_from_enu(antenna.site.enu_of(pass(200).position)).azimuth_rad;
  ASSERT_LT(to, from - 90 * deg);
  // The turn nearest to the middle of the travel does not hold it.
  antenna.azimuth_min_rad = from - 100 * deg;
  antenna.azimuth_max_rad = from + 420 * deg;
  Knows method;
  method.path = pass;
  const Flown flown = fly(range, method, -200, 200, [&](double t, Followed&) {
    const bool known = t > -198.5;
    method.sigma_m_s = known ? 1 : 2000;
    method.path = [&pass, known](double s) {
      PositionVelocity x = pass(s);
      if (!known) x.velocity.m_s *= -1;
      return x;
    };
  });
  EXPECT_LE(flown.went_around, 1);
  for (const SlavingCommand& c : flown.commands) {
    if (c.limits & LimitUnwrapped) {
      EXPECT_LT((c.tick - liftoff).seconds(), -197);
    }
  }
  EXPECT_NEAR(flown.commands.back().azimuth_rad, to + 360 * deg, 1 * deg);
}

/// The smallest worst error that an azimuth axis of that rate can have on a path, by dynamic programming over a grid of
/// azimuths: what no antenna can do better. Its acceleration is not limited.
double best_possible(const AntennaConfig& antenna, const std::function<PositionVelocity(double)>& path,
                     double elevation_max_rad) {
  constexpr double dt = 0.1;
  constexpr double half_s = 25;
  constexpr double cell = 0.25 * deg;
  constexpr int reach = 6;  // 15 deg/s
  constexpr int cells = 1441;
  std::vector<double> cost(cells, 0);
  std::vector<double> next(cells);
  for (double t = half_s; t >= -half_s; t -= dt) {
    const Polar q = polar_from_enu(antenna.site.enu_of(path(t).position));
    for (int i = 0; i < cells; ++i) {
      double reachable = std::numeric_limits<double>::infinity();
      for (int k = -reach; k <= reach; ++k)
        reachable = std::min(reachable, cost[static_cast<std::size_t>((i + k + cells - 1) % (cells - 1))]);
      // The elevation axis is free: the best for this azimuth.
      const double off = i * cell - q.azimuth_rad;
      const double e =
          std::min(std::atan2(std::sin(q.elevation_rad), std::cos(q.elevation_rad) * std::cos(off)), elevation_max_rad);
      const Eigen::Vector3d a = enu_from_polar({1, off, e}).m;
      const Eigen::Vector3d b = enu_from_polar({1, 0, q.elevation_rad}).m;
      next[static_cast<std::size_t>(i)] = std::max(std::atan2(a.cross(b).norm(), a.dot(b)), reachable);
    }
    cost.swap(next);
  }
  return *std::min_element(cost.begin(), cost.end());
}

struct Zenith {
  double elevation_deg;
  double heading_deg;
  double elevation_max_deg;
};

TEST(Mount, PassesTheZenithAsWellAsItsAzimuthCan) {
  for (const Zenith& z : {Zenith{89.5, 30, 90}, Zenith{89.5, 200, 90}, Zenith{89.9, 110, 90}, Zenith{88, 300, 90},
                          Zenith{86, 80, 90}, Zenith{89.5, 30, 180}, Zenith{89.9, 250, 180}, Zenith{88, 300, 180}}) {
    RangeConfig range = mount_range();
    AntennaConfig& antenna = range.antennas[0];
    antenna.elevation_max_rad = z.elevation_max_deg * deg;
    Knows method;
    method.path = orbit_pass(antenna.site, z.elevation_deg * deg, z.heading_deg * deg);
    const double best = best_possible(antenna, method.path, antenna.elevation_max_rad);
    const Flown flown = fly(range, method, -200, 200);
    RangeConfig unplanned = range;
    unplanned.antennas[0].azimuth_acceleration_max_rad_s2 = 0;
    const Flown without = fly(unplanned, method, -200, 200);
    RecordProperty("best_" + std::to_string(z.elevation_deg), std::to_string(best / deg));
    std::printf("pass at %.1f deg, elevation to %.0f: best %.3f deg, planned %.3f, unplanned %.3f\n", z.elevation_deg,
                z.elevation_max_deg, best / deg, flown.worst_rad / deg, without.worst_rad / deg);
    EXPECT_LE(flown.worst_rad, 1.2 * best) << z.elevation_deg << ' ' << z.elevation_max_deg;
    double told = 0;
    bool flagged = false;
    for (std::size_t i = 1; i < flown.commands.size(); ++i) {
      const SlavingCommand& c = flown.commands[i];
      flagged = flagged || (c.limits & LimitKeyhole) != 0;
      if ((c.tick - liftoff).seconds() > -190) {
        told = std::max(told, c.off_target_rad);
        ASSERT_FALSE(c.limits & LimitRate) << (c.tick - liftoff).seconds();
      }
      ASSERT_LE(c.elevation_rad, antenna.elevation_max_rad);
      // Followable: also by its finite difference.
      const double rate = (c.azimuth_rad - flown.commands[i - 1].azimuth_rad) / 0.025;
      ASSERT_LE(std::abs(rate), 1.02 * antenna.azimuth_rate_max_rad_s) << (c.tick - liftoff).seconds();
    }
    EXPECT_TRUE(flagged);
    // The error that remains is told beforehand.
    EXPECT_NEAR(told, flown.worst_rad, 0.05 * flown.worst_rad + 0.02 * deg);
  }
}

/// Neither the instant at which the plan is made matters, nor that the track is noisy (0.01 deg, once in 0.1 s).
TEST(Mount, PassesTheZenithByANoisyTrackFromAnyInstantOn) {
  std::mt19937_64 rng(3);
  std::normal_distribution<double> normal;
  for (const double elevation_max : {90.0, 180.0}) {
    RangeConfig range = mount_range();
    AntennaConfig& antenna = range.antennas[0];
    antenna.elevation_max_rad = elevation_max * deg;
    const Fall exact = orbit_pass(antenna.site, 89.6 * deg, 77 * deg);
    const double best = best_possible(antenna, exact, antenna.elevation_max_rad);
    for (const double phase : {0.0, 0.225, 0.45, 0.675, 0.9}) {
      Eigen::Vector3d off = Eigen::Vector3d::Zero();
      Eigen::Vector3d drift = Eigen::Vector3d::Zero();
      Slave slave(range);
      Mount mount;
      double worst = 0;
      for (Time tick = liftoff - seconds(60 - phase); tick < liftoff + seconds(30); tick = tick + range.tick) {
        if (tick.ns % 100'000'000 == 0) {
          for (int k = 0; k < 3; ++k) {
            off[k] = 70 * normal(rng);
            drift[k] = 10 * normal(rng);
          }
        }
        Knows method;
        method.path = [&](double t) {
          PositionVelocity x = exact(t);
          x.position.m += off;
          x.velocity.m_s += drift;
          return x;
        };
        method.data_epoch = tick;
        const Followed followed{.method = &method, .newest = tick};
        Collector out;
        slave.tick(tick, std::span(&followed, 1), liftoff, out);
        mount.take(out.of<SlavingCommand>().at(0));
        for (int i = 1; i <= 5; ++i) {
          const Time t = tick + antenna.link_delay + antenna.lead + seconds(i * 0.005);
          mount.step(t, 0.005);
          const Polar q = polar_from_enu(antenna.site.enu_of(exact((t - liftoff).seconds()).position));
          if (tick > liftoff - seconds(55)) worst = std::max(worst, mount.off(q));
        }
      }
      EXPECT_LE(worst, 1.2 * best + 0.05 * deg) << elevation_max << ' ' << phase << ' ' << best / deg;
    }
  }
}

/// Under thrust free fall tells nothing of the seconds ahead: the plan does, and the vehicle is 300 m beside it.
TEST(Mount, PassesTheZenithUnderThrustByTheNominalTrajectory) {
  RangeConfig range = mount_range();
  const Site& site = range.antennas[0].site;
  const auto path = [&](double t) {
    const Eigen::Vector3d position(260, 500 * t + 25 * t * t, 30'000 + 300 * t);
    const Eigen::Vector3d velocity(0, 500 + 50 * t, 300);
    return PositionVelocity{site.ecef_of({position}), {site.R_enu_ecef().inverse().R * velocity}};
  };
  Knows method;
  method.path = path;
  const double best = best_possible(range.antennas[0], path, range.antennas[0].elevation_max_rad);
  const double by_fall = fly(range, method, -9, 15).worst_rad;
  std::vector<NominalSample> samples;
  for (double t = 0; t <= 40; t += 0.5) {
    PositionVelocity x = path(t - 20);
    x.position.m += site.R_enu_ecef().inverse().R * Eigen::Vector3d(200, -200, 100);
    samples.push_back({t, x});
  }
  range.targets[0].nominal = NominalTrajectory(samples);
  const double by_plan = fly(range, method, -9, 15, {}, 2, liftoff - seconds(20)).worst_rad;
  EXPECT_LE(by_plan, 1.2 * best) << best / deg;
  EXPECT_GT(by_fall, 1.2 * best) << best / deg;
}

/// A track that jumps under way (here by 4 km of 400) makes another plan, and no step of the azimuth.
TEST(Mount, AnotherPlanUnderWayMakesNoStep) {
  for (const double jumps_at : {-5.0, -3.0, 0.5, 3.0, 5.0}) {
    RangeConfig range = mount_range();
    const AntennaConfig& antenna = range.antennas[0];
    const Fall exact = orbit_pass(antenna.site, 89.5 * deg, 30 * deg);
    Knows method;
    const Flown flown = fly(range, method, -60, 60, [&](double now, Followed&) {
      method.path = [&exact, jumped = now >= jumps_at](double t) {
        PositionVelocity x = exact(t);
        if (jumped) x.position.m += 4000 * Eigen::Vector3d(0.36, 0.48, 0.8).cross(x.position.m.normalized());
        return x;
      };
    });
    for (std::size_t i = 1; i < flown.commands.size(); ++i) {
      const double rate = (flown.commands[i].azimuth_rad - flown.commands[i - 1].azimuth_rad) / 0.025;
      ASSERT_LE(std::abs(rate), 1.05 * antenna.azimuth_rate_max_rad_s)
          << jumps_at << ' ' << (flown.commands[i].tick - liftoff).seconds();
    }
  }
}

TEST(Mount, BesideTheZenithNothingIsPlanned) {
  RangeConfig range = mount_range();
  Knows method;
  method.path = orbit_pass(range.antennas[0].site, 70 * deg, 30 * deg);
  const Flown flown = fly(range, method, -200, 200);
  EXPECT_LT(flown.worst_rad, 0.02 * deg);
  for (const SlavingCommand& c : flown.commands) ASSERT_EQ(c.limits, LimitNone);
}

/// The command's own motion counts, not the target's: a step after a pause of the commands as well.
TEST(Mount, LagsAreToldOfTheCommand) {
  RangeConfig range = mount_range();
  Knows method = hovering(range.antennas[0].site, 0, 0, 20 * deg, 1);
  const Site& site = range.antennas[0].site;
  method.path = [&](double t) {
    const auto at = [&](double s) {
      return site.ecef_of(enu_from_polar({20'000, 0.5 * deg * s + (s > 10 ? 90 * deg : 0), 20 * deg}));
    };
    return PositionVelocity{at(t), {site.R_enu_ecef().inverse().R * Eigen::Vector3d(100, 0, 0)}};
  };
  const Flown flown = fly(range, method, 0, 30, [&](double t, Followed&) { method.known = t < 8 || t > 12; });
  for (const SlavingCommand& c : flown.commands) {
    const double t = (c.tick - liftoff).seconds();
    // 92 deg at 15 deg/s and 20 deg/s^2: 6.9 s.
    if (t < 8) {
      EXPECT_EQ(c.limits, LimitNone) << t;
    } else if (t < 18) {
      EXPECT_TRUE(c.limits & LimitRate) << t;
      EXPECT_GT(c.off_target_rad, 0.02 * deg);
    } else if (t > 19.5) {
      EXPECT_EQ(c.limits, LimitNone) << t;
      EXPECT_LT(c.off_target_rad, 0.02 * deg);
    }
  }
}

TEST(Mount, CommandsInterpolateToSecondOrder) {
  RangeConfig range = mount_range();
  Knows method;
  method.path = orbit_pass(range.antennas[0].site, 80 * deg, 30 * deg);
  const Flown flown = fly(range, method, -30, 30);
  double first = 0;
  double second = 0;
  for (std::size_t i = 12; i < flown.commands.size(); ++i) {
    const SlavingCommand& a = flown.commands[i - 12];
    const SlavingCommand& b = flown.commands[i];
    ASSERT_TRUE(a.acceleration_valid);
    const double dt = (b.apply_at - a.apply_at).seconds();
    const double linear = a.azimuth_rad + dt * a.azimuth_rate_rad_s;
    first = std::max(first, std::abs(b.azimuth_rad - linear));
    second = std::max(second, std::abs(b.azimuth_rad - linear - dt * dt / 2 * a.azimuth_acceleration_rad_s2));
    EXPECT_NEAR(b.elevation_rad,
                a.elevation_rad + dt * (a.elevation_rate_rad_s + dt / 2 * a.elevation_acceleration_rad_s2), 2e-6);
  }
  EXPECT_GT(first, 0.01 * deg);
  EXPECT_LT(second, first / 10);
}

TEST(Mount, PlanningAllocatesNothing) {
#ifndef DOWNRANGE_COUNTS_ALLOCATIONS
  GTEST_SKIP() << "a sanitizer has a malloc of its own";
#endif
  RangeConfig range = mount_range();
  range.antennas[0].beamwidth_rad = 1 * deg;
  range.antennas[0].refractivity = 320;
  Knows method;
  method.path = orbit_pass(range.antennas[0].site, 89.5 * deg, 30 * deg);
  struct : ResultSink {
    void emit(const Result&) override {}
  } sink;
  Slave slave(range);
  std::size_t allocated = 0;
  for (Time tick = liftoff - seconds(100); tick < liftoff + seconds(100); tick = tick + range.tick) {
    method.data_epoch = tick;
    const Followed followed{.method = &method, .newest = tick};
    allocated += allocations_of([&] { slave.tick(tick, std::span(&followed, 1), liftoff, sink); });
  }
  EXPECT_EQ(allocated, 0u);
}

TEST(Turn, TheOneThatHoldsThePassLongest) {
  AntennaConfig antenna;  // -270 to 270
  std::vector<PassPoint> pass;
  for (int i = 0; i <= 100; ++i) pass.push_back({.s = 2.0 * i, .azimuth_rad = (170 + 1.5 * i) * deg});
  // 170 to 320: of the two turns that hold its begin only the lower one holds its end.
  const auto turn = choose_turn(pass, antenna, 170 * deg);
  ASSERT_TRUE(turn);
  EXPECT_NEAR(turn->offset_rad, -2 * pi, 1e-12);
  EXPECT_FALSE(turn->over);
  // Where both do, the nearer one to where the antenna is.
  const auto begin = std::span(pass).first(20);
  EXPECT_NEAR(choose_turn(begin, antenna, 170 * deg)->offset_rad, 0, 1e-12);
  EXPECT_NEAR(choose_turn(begin, antenna, -190 * deg)->offset_rad, -2 * pi, 1e-12);
  // Over the zenith where no turn holds it upright.
  antenna.azimuth_min_rad = -20 * deg;
  antenna.azimuth_max_rad = 300 * deg;
  EXPECT_FALSE(choose_turn(pass, antenna, {})->over);
  antenna.elevation_max_rad = pi;
  EXPECT_TRUE(choose_turn(pass, antenna, {})->over);
  EXPECT_FALSE(choose_turn({}, antenna, {}));
}

TEST(Horizon, NoCommandBelowIt) {
  RangeConfig range = mount_range();
  range.antennas[0].horizon = {{350 * deg, 2 * deg}, {355 * deg, 12 * deg}};
  std::swap(range.antennas[0].horizon[0].azimuth_rad, range.antennas[0].horizon[1].azimuth_rad);
  range.antennas[0].horizon = {{5 * deg, 10 * deg}, {20 * deg, 0}, {340 * deg, 0}, {355 * deg, 10 * deg}};
  Knows method = hovering(range.antennas[0].site, 0, 30 * deg, 4 * deg, 60);
  const Flown flown = fly(range, method, 0, 60);
  bool was_held = false;
  for (std::size_t i = 1; i < flown.commands.size(); ++i) {
    const SlavingCommand& c = flown.commands[i];
    const double azimuth = std::abs(wrap_pi(c.azimuth_rad)) / deg;
    const double lowest = azimuth < 5 ? 10 : std::max(0.0, 10 * (20 - azimuth) / 15);
    ASSERT_GE(c.elevation_rad, lowest * deg - 1e-9);
    const bool held = lowest > 4.01;
    was_held = was_held || held;
    ASSERT_EQ((c.limits & LimitElevation) != 0, held || lowest > 3.99) << azimuth;
    if (held && azimuth > 6 && azimuth < 10) {
      // It moves along the horizon, and says so.
      const double rate = (c.elevation_rad - flown.commands[i - 1].elevation_rad) / 0.025;
      ASSERT_NEAR(c.elevation_rate_rad_s, rate, 0.05 * deg);
    }
  }
  EXPECT_TRUE(was_held);
}

TEST(Refraction, IsAddedToTheElevationWhereTheSiteNeedsIt) {
  RangeConfig range = mount_range();
  Knows method;
  method.path = orbit_pass(range.antennas[0].site, 40 * deg, 30 * deg);
  const Flown straight = fly(range, method, -350, -250);
  range.antennas[0].refractivity = 320;
  const Flown bent = fly(range, method, -350, -250);
  ASSERT_EQ(straight.commands.size(), bent.commands.size());
  const Atmosphere air = atmosphere_over(range.antennas[0].site.geodetic(), 320);
  for (std::size_t i = 0; i < bent.commands.size(); i += 400) {
    const SlavingCommand& s = straight.commands[i];
    if (s.elevation_rad < 1 * deg) continue;
    const double expected = refraction_at_true(air, s.range_m, s.elevation_rad).elevation_rad;
    EXPECT_GT(expected, 0.01 * deg);
    EXPECT_NEAR(bent.commands[i].elevation_rad - s.elevation_rad, expected, 1e-3 * deg);
    EXPECT_EQ(bent.commands[i].azimuth_rad, s.azimuth_rad);
    // The rate is that of the bent ray.
    const double rate = (bent.commands[i + 1].elevation_rad - bent.commands[i].elevation_rad) / 0.025;
    EXPECT_NEAR(bent.commands[i].elevation_rate_rad_s, rate, 1e-3 * deg);
  }
}

}  // namespace
}  // namespace downrange
