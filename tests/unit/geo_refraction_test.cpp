/// Refraction: the figures, Snell's law by quadrature, laws, the table against the exact ray, a recorded pass.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <downrange/geo/polar.hpp>
#include <downrange/geo/refraction.hpp>
#include <fstream>
#include <nlohmann/json.hpp>
#include <numbers>
#include <optional>
#include <random>
#include <sstream>

#include "../support/vectors.hpp"

namespace downrange {
namespace {

constexpr double deg = std::numbers::pi / 180;
const Atmosphere standard{.refractivity = 320, .radius_m = 6.371e6, .scale_height_m = 7000};

TEST(Refraction, FiguresOfTheRange) {
  // est/THEORY.md section 8, 1 deg and N0 = 320: "about 0.03 deg and 6 m at 20 km, 0.39 deg and 56 m at 1000 km".
  const Refraction near = refraction_at_true(standard, 20e3, 1 * deg);
  EXPECT_NEAR(near.elevation_rad / deg, 0.03, 0.005);
  EXPECT_NEAR(near.range_m, 6, 0.5);
  const Refraction far = refraction_at_true(standard, 1000e3, 1 * deg);
  EXPECT_NEAR(far.elevation_rad / deg, 0.39, 0.005);
  EXPECT_NEAR(far.range_m, 56, 0.5);
}

/// Snell's law in spherical layers, n r cos(elevation) = C, as quadratures over q = n r sin(elevation), which has no
/// singularity at a level ray: d path = n dq / (n + r n'), d(central angle) = C dq / (n r^2 (n + r n')). Simpson's
/// rule.
struct Quadrature {
  double path_m = 0;
  double central_angle = 0;
};
Quadrature snell(const Atmosphere& a, double apparent_rad, double height_m) {
  const auto n_at = [&](double r) {
    return 1 + 1e-6 * a.refractivity * std::exp(-(r - a.radius_m) / a.scale_height_m);
  };
  const double C = n_at(a.radius_m) * a.radius_m * std::cos(apparent_rad);
  const auto rates = [&](double q) {
    const double nr = std::hypot(q, C);
    double r = nr;
    for (int i = 0; i < 60; ++i) r = nr / n_at(r);
    const double n = n_at(r);
    const double bent = n - r * (n - 1) / a.scale_height_m;  // n + r n'
    return Quadrature{n / bent, C / (n * r * r * bent)};
  };
  const double r1 = a.radius_m + height_m;
  const double from = n_at(a.radius_m) * a.radius_m * std::sin(apparent_rad);
  const double to = std::sqrt(std::pow(n_at(r1) * r1, 2) - C * C);
  constexpr int steps = 20'000;
  const double h = (to - from) / steps;
  Quadrature sum;
  for (int i = 0; i <= steps; ++i) {
    const double weight = i == 0 || i == steps ? 1 : i % 2 == 1 ? 4 : 2;
    const Quadrature rate = rates(from + i * h);
    sum.path_m += weight * rate.path_m * h / 3;
    sum.central_angle += weight * rate.central_angle * h / 3;
  }
  return sum;
}

TEST(Refraction, EqualsSnellsLawByQuadrature) {
  for (const double apparent : {-0.5 * deg, 0.0, 0.3 * deg, 1 * deg, 5 * deg, 30 * deg, 80 * deg}) {
    for (const double height : {500.0, 8e3, 60e3, 400e3, 1000e3}) {
      SCOPED_TRACE(testing::Message() << apparent / deg << " deg, " << height << " m");
      const Quadrature exact = snell(standard, apparent, height);
      const double r1 = standard.radius_m + height;
      const double x = r1 * std::sin(exact.central_angle);
      const double y = r1 * std::cos(exact.central_angle) - standard.radius_m;
      const Refraction refraction = refraction_at_measured(standard, exact.path_m, apparent);
      EXPECT_NEAR(refraction.range_m, exact.path_m - std::hypot(x, y), 1e-4);
      EXPECT_NEAR(refraction.elevation_rad, apparent - std::atan2(y, x), 1e-8);
    }
  }
}

/// Ranges are drawn logarithmically from 1 to 4000 km, elevations half of them near the horizon.
class Draws {
 public:
  double range() { return std::exp(std::log(1e3) + unit_(random_) * std::log(4000.0)); }
  double elevation() { return (unit_(random_) < 0.5 ? -1 + 6 * unit_(random_) : -1 + 91 * unit_(random_)) * deg; }

 private:
  std::mt19937_64 random_{20'260'101};
  std::uniform_real_distribution<double> unit_{0, 1};
};

TEST(Refraction, RoundTrip) {
  const RefractionTable table(standard);
  Draws draw;
  for (int i = 0; i < 300; ++i) {
    const double range = draw.range();
    const double elevation = draw.elevation();
    const Refraction added = refraction_at_true(standard, range, elevation);
    const Refraction removed = refraction_at_measured(standard, range + added.range_m, elevation + added.elevation_rad);
    EXPECT_NEAR(removed.range_m, added.range_m, 1e-6);  // 1e-9 of the nearest range
    EXPECT_NEAR(removed.elevation_rad, added.elevation_rad, 1e-9);
    const Refraction looked_up = table.at_true(range, elevation).refraction;
    const Refraction taken_out = table.at_measured(range + looked_up.range_m, elevation + looked_up.elevation_rad);
    EXPECT_NEAR(taken_out.range_m, looked_up.range_m, 2e-6);
    EXPECT_NEAR(taken_out.elevation_rad, looked_up.elevation_rad, 1e-12);
  }
}

TEST(Refraction, NoAtmosphereNoRefraction) {
  Draws draw;
  const Atmosphere vacuum{};
  const RefractionTable table(vacuum);
  const RefractionTable none;
  for (int i = 0; i < 20; ++i) {
    const double range = draw.range();
    const double elevation = draw.elevation();
    for (const Refraction& r :
         {refraction_at_true(vacuum, range, elevation), refraction_at_measured(vacuum, range, elevation),
          table.at_true(range, elevation).refraction, none.at_measured(range, elevation)}) {
      EXPECT_EQ(r.range_m, 0);
      EXPECT_EQ(r.elevation_rad, 0);
    }
  }
}

TEST(Refraction, GrowsTowardsTheHorizonAndWithTheAtmosphere) {
  for (const double range : {2e3, 50e3, 300e3, 3000e3}) {
    Refraction lower = refraction_at_true(standard, range, -1 * deg);
    for (double elevation = -0.5; elevation <= 90; elevation += 0.5) {
      const Refraction here = refraction_at_true(standard, range, elevation * deg);
      EXPECT_LT(here.elevation_rad, lower.elevation_rad) << range << ' ' << elevation;
      EXPECT_LT(here.range_m, lower.range_m) << range << ' ' << elevation;
      EXPECT_GE(here.elevation_rad, 0);
      EXPECT_GT(here.range_m, 0);
      lower = here;
    }
  }
  double bending = 0;
  for (double n0 = 50; n0 <= 500; n0 += 50) {
    const Atmosphere atmosphere{.refractivity = n0};
    const double more = refraction_at_true(atmosphere, 500e3, 1 * deg).elevation_rad;
    EXPECT_GT(more, bending);
    bending = more;
  }
}

TEST(Refraction, LimitsAtTheZenithAndNearTheSite) {
  // Straight up the path is longer by the integral of n - 1: N0 1e-6 H, and nothing bends.
  const Refraction up = refraction_at_true(standard, 1000e3, 90 * deg);
  EXPECT_NEAR(up.range_m, 320e-6 * 7000, 1e-4);
  EXPECT_NEAR(up.elevation_rad, 0, 1e-15);
  const RefractionTable table(standard);
  EXPECT_NEAR(table.at_true(1000e3, 90 * deg).refraction.range_m, 320e-6 * 7000, 1e-3);
  EXPECT_NEAR(table.at_true(1000e3, 90 * deg).refraction.elevation_rad, 0, 1e-15);
  // Nearby the layers are plane and n is that of the surface: n0 - 1 of the range, half the bend of a circle.
  const Refraction near = refraction_at_true(standard, 100, 0);
  EXPECT_NEAR(near.range_m, 320e-6 * 100, 1e-6);
  EXPECT_NEAR(near.elevation_rad, 320e-6 / 7000 * 100 / 2, 1e-8);
  EXPECT_EQ(table.at_true(0, 0.3).refraction.range_m, 0);
}

TEST(Refraction, SphereOfTheSite) {
  // Gaussian radius sqrt(M N): b at the equator (a sqrt(1 - e^2)), a^2 / b at a pole.
  EXPECT_NEAR(atmosphere_over({0, 1, 0}, 300).radius_m, 6356752.314, 0.001);
  EXPECT_NEAR(atmosphere_over({90 * deg, 1, 100}, 300).radius_m, 6399593.626 + 100, 0.001);
}

TEST(RefractionTable, AgreesWithTheRay) {
  Draws draw;
  for (const double n0 : {40.0, 320.0, 450.0}) {
    const Atmosphere atmosphere{.refractivity = n0};
    const RefractionTable table(atmosphere);
    double worst_range = 0;
    double worst_elevation = 0;
    for (int i = 0; i < 2000; ++i) {
      const double range = draw.range();
      const double elevation = draw.elevation();
      const Refraction exact = refraction_at_true(atmosphere, range, elevation);
      const Refraction looked_up = table.at_true(range, elevation).refraction;
      worst_range = std::max(worst_range, std::abs(looked_up.range_m - exact.range_m));
      worst_elevation = std::max(worst_elevation, std::abs(looked_up.elevation_rad - exact.elevation_rad));
    }
    EXPECT_LT(worst_range, 0.1) << n0;
    EXPECT_LT(worst_elevation, 0.2e-3 * deg) << n0;
    if (n0 <= 320) {
      EXPECT_LT(worst_range, 0.02) << n0;
      EXPECT_LT(worst_elevation, 0.05e-3 * deg) << n0;
    }
  }
}

TEST(RefractionTable, DerivativesAgainstDifferences) {
  const RefractionTable table(standard);
  Draws draw;
  for (int i = 0; i < 500; ++i) {
    const double range = draw.range();
    const double elevation = std::min(draw.elevation(), 89.9 * deg);
    const RefractionTable::Value at = table.at_true(range, elevation);
    const auto differences = [](const Refraction& plus, const Refraction& minus, double h) {
      return Refraction{(plus.range_m - minus.range_m) / (2 * h), (plus.elevation_rad - minus.elevation_rad) / (2 * h)};
    };
    const double h = 1e-5 * range;
    const Refraction by_range =
        differences(table.at_true(range + h, elevation).refraction, table.at_true(range - h, elevation).refraction, h);
    // 1e-5 of the largest derivatives met, 3e-4 m/m and 0.4 rad/rad; a step may cross a node where the third
    // derivative jumps.
    EXPECT_NEAR(at.d_range.range_m, by_range.range_m, 1e-8);
    EXPECT_NEAR(at.d_range.elevation_rad * range, by_range.elevation_rad * range, 1e-7);
    constexpr double e = 1e-6;
    const Refraction by_elevation =
        differences(table.at_true(range, elevation + e).refraction, table.at_true(range, elevation - e).refraction, e);
    EXPECT_NEAR(at.d_elevation.range_m, by_elevation.range_m, 1e-1);
    EXPECT_NEAR(at.d_elevation.elevation_rad, by_elevation.elevation_rad, 1e-5);
  }
}

TEST(RefractionTable, WildStatesOfAFilterStayFinite) {
  const RefractionTable table(standard);
  for (const double range : {-1e6, 0.0, 1e-3, 6e6, 1e9}) {
    for (const double elevation : {-90 * deg, -2 * deg, 0.0, 90 * deg}) {
      const RefractionTable::Value at = table.at_true(range, elevation);
      const Refraction exact = refraction_at_true(standard, std::min(range, 1e7), elevation);
      for (const Refraction& r :
           {exact, at.refraction, at.d_range, at.d_elevation, table.at_measured(range, elevation)}) {
        EXPECT_TRUE(std::isfinite(r.range_m) && std::isfinite(r.elevation_rad)) << range << ' ' << elevation;
        EXPECT_LT(std::abs(r.elevation_rad), 2) << range << ' ' << elevation;
      }
    }
  }
}

/// Rows of numbers under a line of names.
std::vector<std::vector<double>> rows_of(const std::filesystem::path& file) {
  std::ifstream in(file);
  std::vector<std::vector<double>> rows;
  std::string line;
  std::getline(in, line);
  while (std::getline(in, line)) {
    std::replace(line.begin(), line.end(), ',', ' ');
    std::istringstream fields(line);
    rows.emplace_back();
    for (double value = 0; fields >> value;) rows.back().push_back(value);
  }
  return rows;
}

TEST(Refraction, RecordedPassOfAFarRadar) {
  const auto folder = test::shared_folder() / "data" / "falcon_heavy_demo";
  if (!std::filesystem::exists(folder)) GTEST_SKIP() << "no recorded flight here: " << folder;
  const auto sensors = nlohmann::json::parse(std::ifstream(folder / "sensors.json"));
  const nlohmann::json& radar = sensors.at("radars").at(2);
  ASSERT_EQ(radar.at("name"), "downrange");
  const Site site({radar.at("lat_deg").get<double>() * deg, radar.at("lon_deg").get<double>() * deg,
                   radar.at("h_ell_m").get<double>()});
  const RefractionTable table(atmosphere_over(site.geodetic(), radar.at("refraction_n0").get<double>()));

  const auto truth = rows_of(folder / "truth.csv");
  const auto position_at = [&](double t) -> std::optional<Position<Ecef>> {
    const auto after = std::ranges::upper_bound(truth, t, {}, [](const auto& row) { return row[0]; });
    if (after == truth.begin() || after == truth.end()) return std::nullopt;
    const auto before = std::prev(after);
    const double part = (t - (*before)[0]) / ((*after)[0] - (*before)[0]);
    const auto point = [](const auto& row) { return Eigen::Vector3d(row[1], row[2], row[3]); };
    return Position<Ecef>{(1 - part) * point(*before) + part * point(*after)};
  };

  double range_sum = 0;
  double elevation_sum = 0;
  double lowest = 90 * deg;
  int plots = 0;
  for (const auto& row : rows_of(folder / "radar_downrange.csv")) {
    const auto position = position_at(row[0]);
    if (!position || row[5] != 0) continue;
    const Polar seen = polar_from_enu(site.enu_of(*position));
    const Refraction refraction = table.at_true(seen.range_m, seen.elevation_rad).refraction;
    range_sum += row[2] - seen.range_m - radar.at("bias_range_m").get<double>() - refraction.range_m;
    elevation_sum +=
        row[4] * deg - seen.elevation_rad - radar.at("bias_el_deg").get<double>() * deg - refraction.elevation_rad;
    lowest = std::min(lowest, seen.elevation_rad);
    ++plots;
  }
  ASSERT_GT(plots, 1000);
  EXPECT_LT(lowest, 2 * deg);  // where refraction is large
  EXPECT_NEAR(range_sum / plots, 0, 1);
  EXPECT_NEAR(elevation_sum / plots, 0, 2e-3 * deg);
  std::cout << plots << " plots, mean residual " << range_sum / plots << " m, " << elevation_sum / plots / deg * 1e3
            << " mdeg\n";
}

}  // namespace
}  // namespace downrange
