/// Outliers are told from what noise and bias explain.
#include <gtest/gtest.h>

#include <limits>
#include <numbers>

#include "score/outliers.hpp"

namespace downrange::score {
namespace {

constexpr double deg = std::numbers::pi / 180;
constexpr Time start{1'772'352'000'000'000'000};

RangeConfig make_range() {
  RangeConfig range;
  RadarConfig radar;
  radar.id = "goheung";
  radar.site = Site({34.4450 * deg, 127.5200 * deg, 120});
  radar.sigma = {10, 0.01 * deg, 0.01 * deg};
  range.radars = {radar};
  AngleSensorConfig optics;
  optics.id = "optics";
  optics.site = radar.site;
  optics.sigma_azimuth_rad = optics.sigma_elevation_rad = 0.01 * deg;
  range.angle_sensors = {optics};
  return range;
}

std::optional<TrueState> truth(Time t) {
  if (t < start || t > start + seconds(100)) return std::nullopt;
  return TrueState{ecef_from_geodetic({33.5 * deg, 127.2 * deg, 80e3}), {}};
}

Plot plot(const Polar& error) {
  const Polar q = polar_from_enu(make_range().radars[0].site.enu_of(truth(start)->position));
  return {.measured = {q.range_m + error.range_m, q.azimuth_rad + error.azimuth_rad,
                       q.elevation_rad + error.elevation_rad}};
}

/// Ten plots a second for 10 s with an error of 1 sigma that alternates, on top of `bias`.
OutlierFinder finder_of_good_plots(const Polar& bias, const Name& sensor = "goheung") {
  OutlierFinder finder(make_range(), truth);
  for (std::uint64_t i = 1; i <= 100; ++i) {
    const double sign = i % 2 == 0 ? 1 : -1;
    finder.add(
        sensor, i, start + seconds(0.05 * static_cast<double>(i)),
        plot({bias.range_m + sign * 10, bias.azimuth_rad + sign * 0.01 * deg, bias.elevation_rad - sign * 0.01 * deg}));
  }
  return finder;
}

TEST(Outliers, ABiasIsNone) {
  EXPECT_TRUE(finder_of_good_plots({}).outliers().empty());
  EXPECT_TRUE(finder_of_good_plots({5000, 3 * deg, -2 * deg}).outliers().empty());
}

TEST(Outliers, AreToldInEachCoordinate) {
  const Polar bias{500, 0.3 * deg, 0.1 * deg};
  OutlierFinder finder = finder_of_good_plots(bias);
  const auto add = [&](std::uint64_t sequence, const Polar& off) {
    finder.add(
        "goheung", sequence, start + seconds(2.0),
        plot({bias.range_m + off.range_m, bias.azimuth_rad + off.azimuth_rad, bias.elevation_rad + off.elevation_rad}));
  };
  add(201, {120, 0, 0});
  add(202, {-120, 0, 0});
  add(203, {0, 0.3 * deg, 0});
  add(204, {0, 0, -0.12 * deg});
  add(205, {80, 0.05 * deg, 0.08 * deg});  // within 10 sigma of the median
  EXPECT_EQ(finder.outliers(),
            (std::set<MessageId>{{"goheung", 201}, {"goheung", 202}, {"goheung", 203}, {"goheung", 204}}));
}

TEST(Outliers, OfATrackerAreInItsAngles) {
  OutlierFinder finder = finder_of_good_plots({-80e3, 0, 0}, "optics");
  finder.add("optics", 201, start + seconds(2.0), plot({1e6, 0, 0}));  // a tracker has no range
  finder.add("optics", 202, start + seconds(2.0), plot({0, 0, 0.2 * deg}));
  EXPECT_EQ(finder.outliers(), (std::set<MessageId>{{"optics", 202}}));
}

TEST(Outliers, OfAPlotAreInThePartsThatItHas) {
  OutlierFinder finder = finder_of_good_plots({});
  Plot range_alone = plot({0, 5 * deg, 5 * deg});
  range_alone.angles_valid = false;
  finder.add("goheung", 201, start + seconds(2.0), range_alone);
  Plot angles_alone = plot({1e6, 0, 0});
  angles_alone.range_valid = false;
  finder.add("goheung", 202, start + seconds(2.0), angles_alone);
  EXPECT_TRUE(finder.outliers().empty());
  range_alone.measured.range_m += 200;
  finder.add("goheung", 203, start + seconds(2.0), range_alone);
  EXPECT_EQ(finder.outliers(), (std::set<MessageId>{{"goheung", 203}}));
}

TEST(Outliers, AreNotToldFromWhatSaysNothing) {
  OutlierFinder finder(make_range(), truth);
  finder.add("goheung", 1, start, plot({}));
  finder.add("goheung", 2, start + seconds(1.0), plot({1e5, 0, 0}));  // two: which one is it?
  finder.add("unknown", 3, start, plot({1e5, 0, 0}));
  finder.add("goheung", 4, start - seconds(1.0), plot({1e5, 0, 0}));  // no truth
  EXPECT_TRUE(finder.outliers().empty());

  OutlierFinder with_nan = finder_of_good_plots({});
  with_nan.add("goheung", 201, start, plot({std::numeric_limits<double>::quiet_NaN(), 0, 0}));
  EXPECT_TRUE(with_nan.outliers().empty());
}

}  // namespace
}  // namespace downrange::score
