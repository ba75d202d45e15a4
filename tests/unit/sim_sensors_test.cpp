/// What the simulated sensors report: statistics, rates, visibility, delays, and independence of one from the other.
/// The GPS receiver and its stations: sim_gps_test.cpp.
#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <numbers>
#include <set>

#include "sim/random_stream.hpp"
#include "sim_sensors.hpp"

namespace downrange::sim {
namespace {

TEST(RandomStream, IsStandardNormalAndUniform) {
  RandomStream random(seed, "x");
  std::vector<double> normal, uniform;
  for (int i = 0; i < 100'000; ++i) {
    normal.push_back(random.normal());
    uniform.push_back(random.uniform());
  }
  expect_moments(normal, 0, 1);
  EXPECT_NEAR(moments(uniform).mean, 0.5, 4.5 * std::sqrt(1.0 / 12 / 100'000));
  double fourth = 0;
  for (const double v : normal) fourth += v * v * v * v / 100'000;
  EXPECT_NEAR(fourth, 3, 4.5 * std::sqrt(96.0 / 100'000));
}

TEST(RandomStream, DependsOnSeedAndNameOnly) {
  EXPECT_EQ(RandomStream(1, "a").normal(), RandomStream(1, "a").normal());
  EXPECT_NE(RandomStream(1, "a").normal(), RandomStream(1, "b").normal());
  EXPECT_NE(RandomStream(1, "a").normal(), RandomStream(2, "a").normal());
}

TEST(ColouredNoise, HasItsSigmaAndCorrelationTime) {
  RandomStream random(seed, "x");
  ColouredNoise noise(random, 3, 10, 1);
  std::vector<double> x;
  for (int i = 0; i < 200'000; ++i) x.push_back(noise.next());
  double lagged = 0;
  for (std::size_t i = 10; i < x.size(); ++i) lagged += x[i] * x[i - 10] / static_cast<double>(x.size());
  // About 200 000 / 20 independent values.
  EXPECT_NEAR(moments(x).sigma, 3, 4.5 * 3 / std::sqrt(2 * 10'000.0));
  EXPECT_NEAR(lagged, 9 * std::exp(-1), 0.6);
}

TEST(Radar, MeasuresTruthPlusBiasPlusNoise) {
  Scenario scenario = make_scenario();
  RadarScenario& radar = scenario.radars[0];
  radar.bias.offset = {35, 0.035 * deg, -0.025 * deg};
  const Simulation simulation(scenario, seed);
  const auto plots = plots_of(simulation, "one");
  ASSERT_EQ(plots.size(), 3800u);
  std::vector<double> range, azimuth, elevation;
  for (const RadarTspi& plot : plots) {
    const Polar q = true_polar(simulation, radar.site, plot.epoch);
    range.push_back(plot.measured.range_m - q.range_m);
    azimuth.push_back(wrap_pi(plot.measured.azimuth_rad - q.azimuth_rad));
    elevation.push_back(plot.measured.elevation_rad - q.elevation_rad);
  }
  expect_moments(range, 35, 25);
  expect_moments(azimuth, 0.035 * deg, 0.01 * deg);
  expect_moments(elevation, -0.025 * deg, 0.01 * deg);
  EXPECT_EQ(simulation.radars().at(0).bias.offset.range_m, 35);
}

TEST(Radar, PlotsAtItsRateAndPhaseWithRisingSequences) {
  const Scenario scenario = make_scenario();
  const Simulation simulation(scenario, seed);
  const auto plots = plots_of(simulation, "one");
  for (std::size_t i = 0; i < plots.size(); ++i) {
    EXPECT_EQ((plots[i].epoch - scenario.liftoff).ns, 100'013'000'000 + static_cast<std::int64_t>(i) * 100'000'000);
    EXPECT_EQ(plots[i].sequence, i + 1);
    EXPECT_TRUE(plots[i].simulated);
  }
}

TEST(Radar, BiasTermsActAsDocumented) {
  const Displacement<Enu> d{{3000, -4000, 2000}};
  const Polar q = polar_from_enu(d);
  RadarBias scale;
  scale.scale = {1e-4, 2e-3, 3e-3};
  const Polar scaled = biased(d, scale);
  EXPECT_NEAR(scaled.range_m, q.range_m * (1 + 1e-4), 1e-9);
  EXPECT_NEAR(scaled.azimuth_rad - q.azimuth_rad, 2e-3 * (q.azimuth_rad - std::numbers::pi), 1e-15);
  EXPECT_NEAR(scaled.elevation_rad - q.elevation_rad, 3e-3 * q.elevation_rad, 1e-15);

  RadarBias cartesian;  // south, east, zenith = -north, east, up
  cartesian.sez_offset_m = {10, 20, 30};
  cartesian.sez_scale = {1e-3, 2e-3, 3e-3};
  const Eigen::Vector3d moved = enu_from_polar(biased(d, cartesian)).m;
  EXPECT_NEAR(moved.x(), 3000 * 1.002 + 20, 1e-9);
  EXPECT_NEAR(moved.y(), -4000 * 1.001 - 10, 1e-9);
  EXPECT_NEAR(moved.z(), 2000 * 1.003 + 30, 1e-9);
}

TEST(Radar, RefractionComesBeforeThePolarTerms) {
  Scenario scenario = make_scenario();
  RadarScenario& radar = scenario.radars[0];
  radar.sigma = {};
  const Simulation straight(scenario, seed);
  radar.refractivity = 320;
  radar.bias.scale = {1e-2, 0, 0};
  const Simulation refracted(scenario, seed);
  const auto plots = plots_of(refracted, "one");
  ASSERT_EQ(plots.size(), plots_of(straight, "one").size());
  const Atmosphere atmosphere = atmosphere_over(radar.site.geodetic(), 320);
  for (std::size_t i = 0; i < plots.size(); i += 100) {
    const Polar q = true_polar(straight, radar.site, plots[i].epoch);
    const Refraction refraction = refraction_at_true(atmosphere, q.range_m, q.elevation_rad);
    EXPECT_GT(refraction.range_m, 1);
    EXPECT_NEAR(plots[i].measured.range_m, 1.01 * (q.range_m + refraction.range_m), 1e-6);
    EXPECT_NEAR(plots[i].measured.elevation_rad, q.elevation_rad + refraction.elevation_rad, 1e-12);
    EXPECT_NEAR(plots[i].measured.azimuth_rad, q.azimuth_rad, 1e-12);
  }
}

TEST(Angles, AreARadarsWithoutTheRange) {
  Scenario scenario = make_scenario();
  RadarScenario optical = make_radar("optical");
  optical.sigma = {0, 0.003 * deg, 0.002 * deg};
  optical.bias.offset = {0, 0.05 * deg, -0.04 * deg};
  scenario.angle_sensors = {optical};
  const Simulation simulation(scenario, seed);
  const auto angles = all_of<AngleTspi>(simulation);
  ASSERT_EQ(angles.size(), 3800u);
  std::vector<double> azimuth, elevation;
  for (std::size_t i = 0; i < angles.size(); ++i) {
    const AngleTspi& a = angles[i];
    EXPECT_EQ(a.sensor, Name("optical"));
    EXPECT_EQ(a.sequence, i + 1);
    EXPECT_TRUE(a.simulated);
    EXPECT_GE(a.received, a.epoch);
    const Polar q = true_polar(simulation, optical.site, a.epoch);
    azimuth.push_back(wrap_pi(a.azimuth_rad - q.azimuth_rad));
    elevation.push_back(a.elevation_rad - q.elevation_rad);
  }
  expect_moments(azimuth, 0.05 * deg, 0.003 * deg);
  expect_moments(elevation, -0.04 * deg, 0.002 * deg);
  // No other source's numbers change.
  EXPECT_EQ(plots_of(simulation, "one")[7].measured.range_m,
            plots_of(Simulation(make_scenario(), seed), "one")[7].measured.range_m);
}

TEST(Radar, FastClockStampsLate) {
  Scenario scenario = make_scenario();
  scenario.radars[0].sigma = {};
  scenario.radars[0].bias.time_tag_s = 0.02;
  scenario.radars[0].latency_s = 0.1;
  const Simulation simulation(scenario, seed);
  for (const RadarTspi& plot : plots_of(simulation, "one")) {
    const Polar q = true_polar(simulation, scenario.radars[0].site, plot.epoch - seconds(0.02));
    ASSERT_NEAR(plot.measured.range_m, q.range_m, 1e-6);
    ASSERT_EQ((plot.received - plot.epoch).ns, 80'000'000);  // latency runs from the true time
  }
}

/// A mount points wrong by angles on the sky: near the zenith its azimuth is off by much more.
TEST(Radar, WandersOnTheSky) {
  Scenario scenario = make_scenario();
  RadarScenario& radar = scenario.radars[0];
  radar.sigma = {};
  radar.coloured_on_sky = true;
  radar.coloured_angle_sigma_rad = 0.02 * deg;
  radar.coloured_angle_tau_s = 0.01;
  // Below the flight, 200 s on.
  const Simulation flight(scenario, seed);
  const Geodetic below = geodetic_from_ecef(flight.truth(scenario.liftoff + seconds(200.0))->position);
  radar.site = Site({below.latitude_rad, below.longitude_rad, 0});
  const Simulation simulation(scenario, seed);
  std::vector<double> across, along;
  for (const RadarTspi& plot : plots_of(simulation, "one")) {
    const Polar q = true_polar(simulation, radar.site, plot.epoch);
    if (q.elevation_rad > 89 * deg) continue;
    across.push_back(std::cos(q.elevation_rad) * wrap_pi(plot.measured.azimuth_rad - q.azimuth_rad));
    along.push_back(plot.measured.elevation_rad - q.elevation_rad);
  }
  expect_moments(across, 0, 0.02 * deg);
  expect_moments(along, 0, 0.02 * deg);
}

TEST(Radar, DrawsItsBiasPerSeed) {
  Scenario scenario = make_scenario();
  RadarScenario& radar = scenario.radars[0];
  radar.bias.offset.range_m = 10;
  radar.bias_sigma.offset = {30, 0.03 * deg, 0};
  radar.bias_sigma.scale = {0, 2e-4, 0};
  std::vector<double> range, azimuth, scale;
  for (std::uint64_t s = 0; s < 2000; ++s) {
    const RadarBias bias = draw_bias(radar, s);
    range.push_back(bias.offset.range_m);
    azimuth.push_back(bias.offset.azimuth_rad);
    scale.push_back(bias.scale[1]);
    ASSERT_EQ(bias.offset.elevation_rad, 0);
  }
  expect_moments(range, 10, 30);
  expect_moments(azimuth, 0, 0.03 * deg);
  expect_moments(scale, 0, 2e-4);
}

TEST(Radar, DropoutsOutagesAndLimitsRemovePlotsAndNothingElse) {
  const Scenario plain = make_scenario();
  Scenario broken = plain;
  RadarScenario& radar = broken.radars[0];
  radar.dropout_probability = 0.1;
  radar.outages = {{200, 210}};
  radar.range_max_m = 900e3;
  radar.elevation_min_rad = 5 * deg;
  const Simulation whole(plain, seed);
  const Simulation holes(broken, seed);
  std::map<std::int64_t, Polar> complete;
  for (const RadarTspi& plot : plots_of(whole, "one")) complete[plot.epoch.ns] = plot.measured;

  const auto plots = plots_of(holes, "one");
  std::size_t visible = 0;
  for (const auto& [epoch, measured] : complete) {
    const Polar q = true_polar(whole, radar.site, Time{epoch});
    const double t_s = (Time{epoch} - plain.liftoff).seconds();
    if (q.range_m <= 900e3 && q.elevation_rad >= 5 * deg && !(t_s >= 200 && t_s < 210)) ++visible;
  }
  ASSERT_LT(visible, complete.size());
  const double n = static_cast<double>(visible);
  EXPECT_NEAR(static_cast<double>(plots.size()), 0.9 * n, 4.5 * std::sqrt(0.09 * n)) << "seed " << seed;
  for (const RadarTspi& plot : plots) {
    const double t_s = (plot.epoch - plain.liftoff).seconds();
    EXPECT_FALSE(t_s >= 200 && t_s < 210);
    EXPECT_EQ(plot.measured.range_m, complete.at(plot.epoch.ns).range_m);
    EXPECT_EQ(plot.measured.azimuth_rad, complete.at(plot.epoch.ns).azimuth_rad);
  }
}

TEST(Radar, OutliersAreRareLargeAndListed) {
  const Scenario plain = make_scenario();
  Scenario scenario = plain;
  scenario.radars[0].outlier_probability = 0.05;
  scenario.radars[0].outlier_range_m = 1000;
  scenario.radars[0].outlier_angle_rad = 1 * deg;
  const Simulation simulation(scenario, seed);
  const Simulation clean(plain, seed);
  const auto plots = plots_of(simulation, "one");
  const auto clean_plots = plots_of(clean, "one");
  ASSERT_EQ(plots.size(), clean_plots.size());
  const auto& listed = simulation.radars()[0].outlier_sequences;
  EXPECT_NEAR(static_cast<double>(listed.size()), 190, 4.5 * std::sqrt(3800 * 0.05 * 0.95)) << "seed " << seed;
  const std::set<std::uint64_t> outliers(listed.begin(), listed.end());
  for (std::size_t i = 0; i < plots.size(); ++i) {
    const double off = std::abs(plots[i].measured.range_m - clean_plots[i].measured.range_m);
    if (outliers.contains(plots[i].sequence)) {
      EXPECT_GE(off, 500);
      EXPECT_LE(off, 1500);
    } else {
      EXPECT_EQ(off, 0);
    }
  }
}

TEST(Radar, FaultsChangeWhatItSaysWhileTheyLastAndNothingElse) {
  Scenario scenario = make_scenario();
  const Simulation well(scenario, seed);
  scenario.radars[0].faults = {{.when = {200, 210}, .range_factor = 2, .range_offset_m = -150'000},
                               {.when = {300, 310}, .azimuth_factor = -1, .elevation_offset_rad = 1 * deg}};
  const Simulation faulty(scenario, seed);
  const auto before = all_of<RadarTspi>(well);
  const auto after = all_of<RadarTspi>(faulty);
  ASSERT_EQ(before.size(), after.size());
  for (std::size_t i = 0; i < before.size(); ++i) {
    const double t = (before[i].epoch - scenario.liftoff).seconds();
    Polar expected = before[i].measured;
    if (t >= 200 && t < 210) expected.range_m = 2 * expected.range_m - 150'000;
    if (t >= 300 && t < 310) {
      expected.azimuth_rad = wrap_two_pi(-expected.azimuth_rad);
      expected.elevation_rad += 1 * deg;
    }
    EXPECT_NEAR(after[i].measured.range_m, expected.range_m, 1e-6) << t;
    EXPECT_NEAR(after[i].measured.azimuth_rad, expected.azimuth_rad, 1e-12) << t;
    EXPECT_NEAR(after[i].measured.elevation_rad, expected.elevation_rad, 1e-12) << t;
  }
}

TEST(Radar, AnotherSensorChangesNothing) {
  const Scenario alone = make_scenario();
  Scenario crowded = alone;
  crowded.radars.insert(crowded.radars.begin(), make_radar("zero"));
  crowded.stations.insert(crowded.stations.begin(), make_station("first", 0.3, 0.1));
  const Simulation a(alone, seed);
  const Simulation b(crowded, seed);
  const auto plots_a = plots_of(a, "one");
  const auto plots_b = plots_of(b, "one");
  ASSERT_EQ(plots_a.size(), plots_b.size());
  for (std::size_t i = 0; i < plots_a.size(); ++i) {
    EXPECT_EQ(plots_a[i].measured.range_m, plots_b[i].measured.range_m);
    EXPECT_EQ(plots_a[i].received, plots_b[i].received);
  }
  EXPECT_NE(plots_of(b, "zero")[0].measured.range_m, plots_b[0].measured.range_m);
}

TEST(Simulation, EventsComeInOrderOfArrivalWithTheMissionClock) {
  Scenario scenario = make_scenario();
  scenario.simulated = false;
  scenario.radars[0].latency_s = 0.06;
  scenario.radars[0].latency_jitter_s = 0.06;
  const Simulation simulation(scenario, seed);
  for (std::size_t i = 1; i < simulation.events().size(); ++i)
    ASSERT_LE(received_of(simulation.events()[i - 1]), received_of(simulation.events()[i]));
  const auto mission = all_of<MissionEvent>(simulation);
  ASSERT_EQ(mission.size(), 6u);
  EXPECT_EQ(mission[0].kind, MissionEventKind::PlannedLiftoff);
  EXPECT_EQ((mission[0].received - scenario.liftoff).seconds(), -10);
  EXPECT_EQ(mission[0].epoch, scenario.liftoff);
  EXPECT_EQ(mission[1].kind, MissionEventKind::Liftoff);
  std::vector<std::int64_t> staging_ms;
  for (std::size_t i = 2; i < mission.size(); ++i)
    staging_ms.push_back((mission[i].epoch - scenario.liftoff).ns / 1'000'000);
  EXPECT_EQ(staging_ms, (std::vector<std::int64_t>{229'000, 232'000, 395'000, 453'000}));
  EXPECT_FALSE(mission[0].simulated);
  EXPECT_FALSE(all_of<GpsFix>(simulation)[0].simulated);
}

TEST(Simulation, IsRepeatable) {
  const Simulation a(make_scenario(), seed);
  const Simulation b(make_scenario(), seed);
  const Simulation other(make_scenario(), seed + 1);
  ASSERT_EQ(a.events().size(), b.events().size());
  for (std::size_t i = 0; i < a.events().size(); ++i) ASSERT_EQ(received_of(a.events()[i]), received_of(b.events()[i]));
  EXPECT_EQ(plots_of(a, "one")[7].measured.range_m, plots_of(b, "one")[7].measured.range_m);
  EXPECT_NE(plots_of(a, "one")[7].measured.range_m, plots_of(other, "one")[7].measured.range_m);
}

}  // namespace
}  // namespace downrange::sim
