// A wrong unit shows: in the line of spans always, as an error where it cannot be, as a doubt where it hardly can.

#include <archive/import/plausibility.hpp>
#include <downrange/geo/site.hpp>
#include <functional>
#include <numbers>

#include "archive_testing.hpp"

namespace downrange::archive {
namespace {

constexpr double deg = std::numbers::pi / 180;

/// Twenty rows, ten a second, from ten seconds after lift-off.
std::vector<PlausibleRow> rows(const std::function<void(double, PlausibleRow&)>& fill) {
  std::vector<PlausibleRow> all(20);
  for (std::size_t i = 0; i < all.size(); ++i) {
    const double t = 10 + 0.1 * static_cast<double>(i);
    all[i].epoch = t0 + seconds(t);
    all[i].received = all[i].epoch + milliseconds(50);
    fill(t - 10, all[i]);
  }
  return all;
}

std::vector<PlausibleRow> radar(double range_unit = 1, double angle_unit = deg) {
  return rows([&](double t, PlausibleRow& row) {
    row.polar = {(12'000 + 300 * t) * range_unit, (120 + 0.1 * t) * angle_unit, (10 + 0.2 * t) * angle_unit};
    row.range_valid = row.angles_valid = true;
  });
}

Plausibility judge(const std::vector<PlausibleRow>& all, FileKind kind = FileKind::Radar) {
  return judge_plausibility(kind, t0, all);
}

std::string doubts(const Plausibility& found) {
  std::string all;
  for (const std::string& doubt : found.doubts) all += doubt + "\n";
  return all;
}

TEST(Plausibility, TheLineSaysTheSpans) {
  const Plausibility found = judge(radar());
  EXPECT_EQ(found.line,
            "T+10.0 s to T+11.9 s, 10 rows/s, azimuth 120.00 to 120.19 deg, elevation 10.00 to 10.38 deg, range 12.000 "
            "to 12.570 km, closing 300 m/s");
  EXPECT_EQ(found.impossible, "");
  EXPECT_EQ(doubts(found), "");
  EXPECT_EQ(judge({radar().front()}).line.substr(0, 20), "T+10.0 s to T+10.0 s") << "one row is a file too";
}

TEST(Plausibility, UnitsThatCannotBeAreImpossible) {
  EXPECT_NE(judge(radar(1, 1)).impossible.find("degrees taken as radians"), std::string::npos);
  EXPECT_NE(judge(radar(1, 1), FileKind::Angles).impossible.find("degrees taken as radians"), std::string::npos);
  EXPECT_NE(judge(radar(1000)).impossible.find("metres taken as kilometres"), std::string::npos);
  auto far = radar();
  for (PlausibleRow& row : far) row.epoch = row.epoch + Duration{std::int64_t{86'400'000'000'000} * 40};
  EXPECT_NE(judge(far).impossible.find("days from lift-off"), std::string::npos);
  auto since_1970 = radar();
  for (PlausibleRow& row : since_1970) row.epoch = row.epoch + Duration{t0.ns};
  EXPECT_NE(judge(since_1970).impossible.find("since = \"unix\""), std::string::npos);
}

TEST(Plausibility, AnOutlierOrAStillRadarIsNothing) {
  auto spoilt = radar();
  spoilt[5].polar = {1e9, 100, 5};
  EXPECT_EQ(judge(spoilt).impossible, "");
  auto noisy = radar();  // at a hundred a second noise looks like motion
  for (std::size_t i = 0; i < noisy.size(); ++i) {
    noisy[i].epoch = t0 + milliseconds(static_cast<std::int64_t>(10 * i));
    noisy[i].polar.range_m += i % 2 == 0 ? 200 : -200;
  }
  EXPECT_EQ(judge(noisy).impossible, "");
}

TEST(Plausibility, WhatHardlyCanBeIsADoubt) {
  EXPECT_NE(doubts(judge(radar(0.001))).find("kilometres taken as metres"), std::string::npos);
  EXPECT_NE(doubts(judge(radar(1, deg * deg))).find("radians taken as degrees"), std::string::npos);
  auto early = radar();
  for (PlausibleRow& row : early) row.epoch = row.epoch + milliseconds(18'000);
  EXPECT_NE(doubts(judge(early)).find("received 17.950 s before their epoch"), std::string::npos);
  auto of_day = radar();  // t0 is 20:45:00
  for (PlausibleRow& row : of_day) {
    row.epoch = row.epoch + Duration{74'700'000'000'000};
    row.received = row.received + Duration{74'700'000'000'000};
  }
  EXPECT_NE(doubts(judge(of_day)).find("since = \"midnight\""), std::string::npos);
}

TEST(Plausibility, PositionsAreOnTheEarthAndMove) {
  const auto fixes = [](double unit, double stated) {
    return rows([&](double t, PlausibleRow& row) {
      row.position.m = ecef_from_geodetic({0.5, 1, 1000 + 500 * t}).m * unit;
      row.speed_m_s = stated;
    });
  };
  const Plausibility found = judge(fixes(1, 500), FileKind::Gps);
  EXPECT_EQ(
      found.line,
      "T+10.0 s to T+11.9 s, 10 rows/s, latitude 28.648 to 28.648, longitude 57.296 to 57.296 deg, height 1.000 to "
      "1.950 km, moving 500 m/s, stated up to 500 m/s");
  EXPECT_EQ(found.impossible + doubts(found), "");
  EXPECT_NE(judge(fixes(0.001, 500), FileKind::Gps).impossible.find("from the Earth's centre"), std::string::npos);
  EXPECT_NE(doubts(judge(fixes(1, 0.5), FileKind::Truth)).find("another unit of its velocity"), std::string::npos);

  auto no_fix = fixes(1, 500);
  for (std::size_t i = 0; i < 15; ++i) no_fix[i].position.m = {6'378'137, 0, 0};
  EXPECT_EQ(judge(no_fix, FileKind::Gps).impossible, "");
  EXPECT_NE(judge(no_fix, FileKind::Gps).line.find("15 positions of zeros"), std::string::npos);
}

}  // namespace
}  // namespace downrange::archive
