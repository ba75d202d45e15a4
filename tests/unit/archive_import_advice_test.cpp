// What an importer's messages advise: the value found, what is allowed, and a key that helps and is not set already.

#include <functional>

#include "archive_import_testing.hpp"

namespace downrange::archive {
namespace {

class ImportAdvice : public ArchiveImport {
 protected:
  /// "REFUSED ..." or the doubts of the first file, one a line.
  std::string advice(const std::string& csv, const std::string& map) {
    write_text(folder_ / "r.csv", csv);
    const std::string refused = refusal(map);
    if (!refused.empty()) return "REFUSED " + refused;
    report_ = import(map).files.at(0);
    std::string all;
    for (const std::string& doubt : report_.doubts) all += doubt + '\n';
    return all;
  }
  FileReport report_;
};

bool has(const std::string& text, const std::string& part) { return text.find(part) != std::string::npos; }

constexpr const char* head =
    "mission = \"m\"\ntarget = \"t\"\nliftoff = 2018-02-06T20:45:00Z\n[[file]]\npath = \"r.csv\"\n";

std::string gps_mapping(const std::string& unit = "deg", const std::string& height_unit = "m") {
  return std::string(head) + "kind = \"gps\"\nstation = \"tm\"\nlatency_s = 0.1\n[file.columns]\n" +
         "time = {field = \"epoch\", unit = \"s\"}\nlat = {field = \"latitude\", unit = \"" + unit +
         "\"}\nlon = {field = \"longitude\", unit = \"" + unit + "\"}\nh = {field = \"height\", unit = \"" +
         height_unit + "\"}\n";
}

std::string gps_row(const std::string& latitude, const std::string& longitude) {
  return "time,lat,lon,h\n10," + latitude + ',' + longitude + ",100\n";
}

TEST_F(ImportAdvice, ALatitudeBeyondAPoleSaysWhatItCanBe) {
  EXPECT_PRED2(
      has, advice(gps_row("34.43", "127.535"), gps_mapping("rad")),
      "lat: found 34.43 rad, allowed -1.5708 to 1.5708 rad (from pole to pole): degrees taken as radians (unit "
      "= \"deg\")?");
  EXPECT_PRED2(has, advice(gps_row("127.535", "34.43"), gps_mapping()),
               "found 127.535 deg, allowed -90 to 90 deg (from pole to pole): latitude and longitude exchanged? Then "
               "'lon' is field = \"latitude\" and 'lat' field = \"longitude\"");
  EXPECT_PRED2(has, advice(gps_row("3425.8", "12732.1"), gps_mapping()),
               "(ddmm.mmmm)? With a colon between them, 34:25.8");
  EXPECT_PRED2(has, advice(gps_row("344300000", "1275350000"), gps_mapping()),
               "found 3.443e+08 deg, allowed -90 to 90 deg (from pole to pole): integers? scale = 1e-7 in both columns "
               "would make it 34.43 deg");
  EXPECT_PRED2(has, advice(gps_row("123948.5", "459126.5"), gps_mapping()), "unit = \"arcsec\" would fit");
  EXPECT_PRED2(has, advice(gps_row("-9999", "-9999"), gps_mapping()), "missing = \"-9999\" leaves it out");
}

TEST_F(ImportAdvice, ScaledIntegersAreReadWithTheScaleThatIsAdvised) {
  std::string scaled = gps_mapping();
  for (const char* name : {"latitude\"", "longitude\""}) {
    scaled.insert(scaled.find(name) + std::string(name).size(), ", scale = 1e-7");
  }
  EXPECT_EQ(advice(gps_row("344300000", "1275350000"), scaled), "");
}

std::string radar_mapping(const std::string& keys = "", const std::string& time = "unit = \"s\"") {
  return std::string(head) + "kind = \"radar\"\nsensor = \"ra\"\nlatency_s = 0.1\n" + keys +
         "\n[file.columns]\ntime = {field = \"epoch\", " + time +
         "}\nrng = {field = \"range\", unit = \"m\"}\naz = {field = \"azimuth\", unit = \"deg\"}\n" +
         "el = {field = \"elevation\", unit = \"deg\"}\n";
}

/// Twenty plots, two a second, from ten seconds after lift-off.
std::string radar_csv(const std::function<std::string(double)>& time) {
  std::string csv = "time,rng,az,el\n";
  for (int i = 0; i < 20; ++i) {
    csv += time(10 + 0.5 * i) + ',' + std::to_string(12'000 + 150 * i) + ",120," + std::to_string(10 + i) + '\n';
  }
  return csv;
}

std::string number(double value, const char* pattern = "%.9f") {
  char text[64];
  std::snprintf(text, sizeof text, pattern, value);
  return text;
}

TEST_F(ImportAdvice, TimesOfAnotherUnitOrReference) {
  const auto of = [&](double factor, double base, const std::string& time = "unit = \"s\"") {
    return advice(radar_csv([&](double t) { return number(base + t * factor); }), radar_mapping("", time));
  };
  EXPECT_PRED2(has, of(1000, 0), "near it with unit = \"ms\"\n");
  EXPECT_PRED2(has, of(1, 74'700), "near it with since = \"midnight\"\n");
  EXPECT_PRED2(has, of(1, 0, "unit = \"s\", since = \"unix\""), "near it with since = \"liftoff\"")
      << "which is not set";
  EXPECT_PRED2(has, of(1000, 0, "unit = \"us\", since = \"midnight\""),
               "near lift-off with unit = \"ms\", since = \"liftoff\"");
  EXPECT_PRED2(has, of(1 / 86'400.0, 43'137 + 74'700 / 86'400.0),
               "unit = \"d\", since = 1899-12-30T00:00:00Z (days as spreadsheets count them)");
  EXPECT_EQ(advice(radar_csv([](double t) { return number(43'137 + (74'700 + t) / 86'400, "%.12f"); }),
                   radar_mapping("", "unit = \"d\", since = 1899-12-30T00:00:00Z")),
            "");
}

TEST_F(ImportAdvice, TimesAsTextNeedNoUnit) {
  const auto local = radar_csv([](double t) { return "2018-02-07T05:45:" + number(t, "%06.3f"); });
  EXPECT_EQ(
      advice(local, radar_mapping()),
      "no row within an hour of lift-off: is liftoff right? They would be near it as local time of UTC+09:00: write "
      "+09:00 behind each time, or offset = -32400 (seconds) in the columns of time\n");
  EXPECT_EQ(advice(local, radar_mapping("", "unit = \"s\", offset = -32400")), "");
  EXPECT_EQ(advice(radar_csv([](double t) { return "2018-02-07T05:45:" + number(t, "%06.3fZ"); }), radar_mapping()),
            "no row within an hour of lift-off: is liftoff right?\n");
  EXPECT_PRED2(
      has, advice(radar_csv([](double t) { return "2018-02-06 08:45:" + number(t, "%06.3f AM"); }), radar_mapping()),
      "AM and PM exchanged: write them as hours of 0 to 23, or offset = 43200 (seconds)");
  EXPECT_PRED2(has,
               advice(radar_csv([](double t) { return "20:45:" + number(t, "%06.3f"); }),
                      radar_mapping("", "unit = \"s\", since = \"liftoff\"")),
               "with since = \"midnight\"");
}

TEST_F(ImportAdvice, TextOfTimesIsNamedAsWhatItIs) {
  const auto note = [&](const std::string& time, const std::string& declared = "unit = \"text\"") {
    advice(radar_csv([&](double t) { return time + number(t, "%06.3f"); }), radar_mapping("", declared));
    return report_.notes.at(0);
  };
  EXPECT_EQ(note("2018-02-06T20:45:"), "dates such as 2018-02-06T20:45:10.000");
  EXPECT_EQ(note("037:20:45:"), "days of the year such as 037:20:45:10.000");
  EXPECT_EQ(note("20:45:", "unit = \"text\", since = \"midnight\""), "hours:minutes:seconds such as 20:45:10.000");
  EXPECT_EQ(note("T+00:00:"), "times from lift-off such as T+00:00:10.000");
}

TEST_F(ImportAdvice, DatesHaveATimeScaleWhateverTheUnit) {
  const auto csv = radar_csv([](double t) { return "2018-02-06T20:45:" + number(t + 18, "%06.3f"); });
  for (const char* unit : {"unit = \"s\"", "unit = \"text\""}) {
    EXPECT_EQ(advice(csv, radar_mapping("time_scale = \"GPS\"", unit)), "");
    EXPECT_EQ(radars().at(0).epoch, t0 + milliseconds(10'000));
  }
  const auto zoned = radar_csv([](double t) { return "2018-02-06T20:45:" + number(t, "%06.3fZ"); });
  EXPECT_PRED2(has, advice(zoned, radar_mapping("time_scale = \"GPS\"")),
               "time: found '2018-02-06T20:45:10.000Z', which says its offset from UTC (a Z is one), expected none "
               "with time_scale "
               "= \"GPS\": leave time_scale out");
  const auto numbers = radar_csv([](double t) { return number(t); });
  EXPECT_PRED2(
      has, advice(numbers, radar_mapping("time_scale = \"GPS\"")),
      "r.csv:2: time: found '10.000000000', which without since is a number from lift-off, where time_scale has no "
      "meaning; allowed: dates, numbers with since = ");
  EXPECT_PRED2(has, advice(numbers, radar_mapping("time_scale = \"GPS\"", "unit = \"s\", since = \"liftoff\"")),
               "time_scale: found since = \"liftoff\"");
}

TEST_F(ImportAdvice, AMissingNumberIsMissingHoweverItIsWritten) {
  const std::string csv = "time,rng,az,el\n10,12000,120,10\n11,-9999.0,120,10\n12,-9.999e3,120,10\n13,12900,120,10\n";
  EXPECT_EQ(advice(csv, radar_mapping("missing = \"-9999\"")), "");
  EXPECT_EQ(report_.left_empty, 2u);
}

TEST_F(ImportAdvice, WrongChecksumsAreCountedAndNamed) {
  const std::string map = std::string(head) + "kind = \"gps\"\nformat = \"nmea\"\nstation = \"tm\"\nlatency_s = 0.1\n";
  const std::string right = "$GPGGA,204519,4807.038,N,01131.000,E,1,08,0.9,545.4,M,46.9,M,,*41\r\n";
  const std::string wrong = "$GPGGA,204520,4807.038,N,01131.000,E,1,08,0.9,545.4,M,46.9,M,,*00\r\n";
  EXPECT_PRED2(
      has, advice("noise\r\n" + wrong + wrong, map),
      "r.csv: no GGA and no GNS sentence with a right checksum; 2 sentences with a wrong checksum, the first on "
      "line 2: found *00, expected *4B; sentences: 2 GGA");
  EXPECT_EQ(advice(right + wrong, map), "");
  EXPECT_EQ(report_.notes.at(1), "1 sentence with a wrong checksum, on line 2: found *00, expected *4B");
}

}  // namespace
}  // namespace downrange::archive
