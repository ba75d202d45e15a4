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

ColumnMapping column(Field field, const std::string& unit) {
  ColumnMapping mapping;
  mapping.column = info_of(field).name;
  mapping.field = field;
  mapping.unit = unit;
  mapping.factor = find_unit(info_of(field).quantity, unit)->size;
  return mapping;
}

/// What a mapping declares: units of lengths, angles and times.
struct Units {
  std::string length = "m";
  std::string angle = "deg";
  std::string time = "s";
  std::string speed = "m/s";
};

FileMapping declared(FileKind kind, const Units& units, bool geodetic = false) {
  FileMapping mapping;
  mapping.kind = kind;
  mapping.columns.push_back(column(Field::Epoch, units.time));
  const auto add = [&](std::initializer_list<Field> fields, const std::string& unit) {
    for (const Field field : fields) mapping.columns.push_back(column(field, unit));
  };
  if (kind == FileKind::Radar) add({Field::Range}, units.length);
  if (kind == FileKind::Radar || kind == FileKind::Angles) {
    add({Field::Azimuth, Field::Elevation}, units.angle);
  } else {
    if (geodetic) add({Field::Latitude, Field::Longitude}, units.angle);
    geodetic ? add({Field::Height}, units.length) : add({Field::X, Field::Y, Field::Z}, units.length);
    add({Field::Vx, Field::Vy, Field::Vz}, units.speed);
  }
  return mapping;
}

Plausibility judge(const std::vector<PlausibleRow>& all, FileKind kind = FileKind::Radar, const Units& units = {}) {
  return judge_plausibility(declared(kind, units), t0, all);
}

bool has(const std::string& text, const std::string& part) { return text.find(part) != std::string::npos; }

std::string doubts(const Plausibility& found) {
  std::string all;
  for (const std::string& doubt : found.doubts) all += doubt + "\n";
  return all;
}

TEST(Plausibility, TheLineSaysTheSpans) {
  const Plausibility found = judge(radar());
  EXPECT_EQ(found.line,
            "T+10.0 s to T+11.9 s, 10 rows/s, azimuth 120.00 to 120.19 deg, elevation 10.00 to 10.38 deg, range 12.000 "
            "to 12.570 km, receding 300 m/s");
  EXPECT_EQ(found.impossible, "");
  EXPECT_EQ(doubts(found), "");
  EXPECT_EQ(judge({radar().front()}).line.substr(0, 20), "T+10.0 s to T+10.0 s") << "one row is a file too";
}

TEST(Plausibility, TheLineSaysWhichWayTheRangeGoes) {
  auto all = radar();
  for (PlausibleRow& row : all) row.polar.range_m = 24'000 - row.polar.range_m;
  EXPECT_PRED2(has, judge(all).line, ", closing 300 m/s");
  for (std::size_t i = 0; i < all.size(); ++i) all[i].polar.range_m = 12'000 - 30.0 * std::abs(9.5 - double(i));
  for (std::size_t i = 0; i < all.size(); ++i) all[i].epoch = t0 + milliseconds(10'000 + 1000 * std::int64_t(i));
  EXPECT_PRED2(has, judge(all).line, ", closing and receding 30 m/s");
}

TEST(Plausibility, UnitsThatCannotBeAreImpossible) {
  const Units radians{"m", "rad"};
  EXPECT_PRED2(has, judge(radar(1, 1), FileKind::Radar, radians).impossible,
               "degrees taken as radians (unit = \"deg\")");
  EXPECT_PRED2(has, judge(radar(1, 1), FileKind::Angles, radians).impossible, "degrees taken as radians");
  EXPECT_PRED2(has, judge(radar(1, 1)).impossible, "another unit? unit = \"");
  EXPECT_PRED2(has, judge(radar(1000), FileKind::Radar, {"km"}).impossible,
               "range changes by 300 km/s, allowed up to 22 km/s: metres taken as kilometres (unit = \"m\")?");
  EXPECT_PRED2(has, judge(radar(1000), FileKind::Radar, {"m", "deg", "ms"}).impossible,
               "seconds taken as milliseconds (unit = \"s\")?");
  auto huge = radar();
  for (PlausibleRow& row : huge) row.polar.range_m = 1e308;
  EXPECT_EQ(judge(huge).impossible, "its ranges are 1e+305 to 1e+305 km, allowed up to 100000 km: another unit?");
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
  EXPECT_PRED2(has, doubts(judge(radar(0.001))), "kilometres taken as metres (unit = \"km\")?");
  EXPECT_FALSE(has(doubts(judge(radar(0.001), FileKind::Radar, {"km"})), "unit = \"km\"")) << "which is set";
  EXPECT_FALSE(has(doubts(judge(radar(1, deg * deg), FileKind::Radar, {"m", "rad"})), "rad")) << "likewise";
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

TEST(Plausibility, AnglesBeyondTheZenithHaveSeveralReasons) {
  auto exchanged = radar();
  for (PlausibleRow& row : exchanged) std::swap(row.polar.azimuth_rad, row.polar.elevation_rad);
  EXPECT_PRED2(has, judge(exchanged).impossible, "azimuth and elevation exchanged?");
  auto over = radar();
  for (PlausibleRow& row : over) row.polar.elevation_rad += 90 * deg;
  EXPECT_PRED2(has, judge(over).impossible, "driven over the zenith");
}

/// From the pad on: degrees, metres, and what is made of both.
std::vector<PlausibleRow> geodetic(double angle_unit, double height_unit, double latitude_deg = 34.4) {
  return rows([&](double t, PlausibleRow& row) {
    row.position =
        ecef_from_geodetic({(latitude_deg + 0.001 * t) * angle_unit, 127.5 * angle_unit, (100 + 50 * t) * height_unit});
  });
}

TEST(Plausibility, PlacesInRadiansAndHeightsInKilometresAreDoubted) {
  const auto doubts_of = [](const std::vector<PlausibleRow>& all, const Units& units = {}) {
    return doubts(judge_plausibility(declared(FileKind::Gps, units, true), t0, all));
  };
  EXPECT_EQ(doubts_of(geodetic(deg, 1)), "");
  EXPECT_PRED2(has, doubts_of(geodetic(deg * deg, 1)), "radians taken as degrees (unit = \"rad\")?");
  EXPECT_EQ(doubts_of(geodetic(deg * deg, 1), {"m", "rad"}), "") << "set already";
  EXPECT_PRED2(has, doubts_of(geodetic(deg, 0.001)), "kilometres taken as metres (unit = \"km\")?");
  EXPECT_EQ(doubts_of(geodetic(deg, 0.001), {"km"}), "");
  auto pad = geodetic(deg, 1);
  for (PlausibleRow& row : pad) row.position = pad.front().position;
  EXPECT_EQ(doubts_of(pad), "") << "a receiver on its pad";
}

TEST(Plausibility, NumbersThatStandForNoValueAreNamed) {
  auto all = radar();
  for (std::size_t i = 0; i < all.size(); ++i) {
    all[i].epoch = t0 + milliseconds(10'000 + 500 * std::int64_t(i));
    all[i].received = all[i].epoch;
    all[i].line = i + 2;
    if (i % 3 == 1) all[i].polar.range_m = -9999;
  }
  const std::string found =
      "range: found -9999 in 7 of 20 rows, the first on line 3, which is no range of a site: does it stand for no "
      "value? Write missing = \"-9999\", or to leave the rows out where = {column = \"range\", differs = \"-9999\"}";
  EXPECT_EQ(judge(all).impossible, found);
  for (std::size_t i = 0; i < 20; ++i) all[i].polar.range_m = 12'000 + 150.0 * double(i);
  all[1].polar.range_m = -9999;
  EXPECT_EQ(judge(all).impossible + doubts(judge(all)), "") << "outliers";
  for (const std::size_t i : {1U, 9U, 14U}) all[i].polar.range_m = 99'999;
  EXPECT_EQ(judge(all).impossible, "");
  EXPECT_PRED2(has, doubts(judge(all)), "range: found 99999 in 3 of 20 rows");
  for (std::size_t i = 0; i < 20; ++i) all[i].polar.range_m = 99'000 + 100 * double(i) - (i == 10 ? 1 : 0);
  for (const std::size_t i : {11U, 12U}) all[i].polar.range_m = 99'999;
  EXPECT_EQ(doubts(judge(all)), "") << "a range that is passed through";
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
  EXPECT_PRED2(has, judge(fixes(0.001, 500), FileKind::Gps).impossible,
               "from the Earth's centre, allowed 6300 to 1e+06 km");
  EXPECT_PRED2(has, judge(fixes(0.001, 500), FileKind::Gps).impossible, "unit = \"km\"");
  EXPECT_PRED2(has, judge(fixes(1000, 500), FileKind::Gps, {"km"}).impossible, "unit = \"m\" would fit");
  EXPECT_FALSE(has(judge(fixes(1000, 500), FileKind::Gps, {"km"}).impossible, "\"km\"")) << "which is set";
  EXPECT_NE(doubts(judge(fixes(1, 0.5), FileKind::Truth)).find("another unit of its velocity"), std::string::npos);

  auto no_fix = fixes(1, 500);
  for (std::size_t i = 0; i < 15; ++i) no_fix[i].position.m = {6'378'137, 0, 0};
  EXPECT_EQ(judge(no_fix, FileKind::Gps).impossible, "");
  EXPECT_NE(judge(no_fix, FileKind::Gps).line.find("15 positions of zeros"), std::string::npos);
}

}  // namespace
}  // namespace downrange::archive
