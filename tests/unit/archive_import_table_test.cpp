// Tables as people have them: what is certain is imported, what is not names the file, what there is and the key that
// helps.

#include <numbers>

#include "archive_import_testing.hpp"

namespace downrange::archive {
namespace {

constexpr double deg = std::numbers::pi / 180;

/// Three plots, ten to eleven seconds after lift-off.
constexpr const char* plots =
    "time,recv,rng,az,el\n"
    "10.0,10.05,12000.0,120.00,10.00\n"
    "10.5,10.55,12150.5,120.05,10.10\n"
    "11.0,11.05,12301.0,120.10,10.20\n";

std::string with(std::string text, const std::string& from, const std::string& to) {
  for (std::size_t at = 0; (at = text.find(from, at)) != std::string::npos; at += to.size()) {
    text.replace(at, from.size(), to);
  }
  return text;
}

class ImportTable : public ArchiveImport {
 protected:
  std::string mapping(const std::string& keys = "", const std::string& columns = columns_) {
    return "mission = \"m\"\ntarget = \"t\"\nliftoff = 2018-02-06T20:45:00Z\n[[file]]\npath = \"r.csv\"\n"
           "kind = \"radar\"\nsensor = \"ra\"\n" +
           keys + "\n[file.columns]\n" + columns;
  }
  /// Imports and expects the three plots of `plots`.
  FileReport expect_plots(const std::string& csv, const std::string& map) {
    write_text(folder_ / "r.csv", csv);
    const FileReport file = import(map).files.at(0);
    const auto all = radars();
    EXPECT_EQ(all.size(), 3u) << csv;
    for (std::size_t i = 0; i < all.size(); ++i) {
      const auto k = static_cast<std::int64_t>(i);
      EXPECT_EQ(all[i].epoch, t0 + milliseconds(10'000 + 500 * k)) << csv;
      EXPECT_EQ(all[i].received, t0 + milliseconds(10'050 + 500 * k)) << csv;
      EXPECT_DOUBLE_EQ(all[i].measured.range_m, 12'000 + 150.5 * static_cast<double>(i)) << csv;
      EXPECT_NEAR(all[i].measured.azimuth_rad, (120 + 0.05 * static_cast<double>(i)) * deg, 1e-12) << csv;
    }
    return file;
  }
  std::string refused(const std::string& csv, const std::string& map) {
    write_text(folder_ / "r.csv", csv);
    std::string text = refusal(map);
    const std::string folder = (folder_ / "").string();
    return text.starts_with(folder) ? text.substr(folder.size()) : text;
  }
  static std::string times(const std::string& declaration) { return with(columns_, "unit = \"s\"", declaration); }

  static inline const std::string columns_ =
      "time = {field = \"epoch\", unit = \"s\"}\nrecv = {field = \"received\", unit = \"s\"}\n"
      "rng = {field = \"range\", unit = \"m\"}\naz = {field = \"azimuth\", unit = \"deg\"}\n"
      "el = {field = \"elevation\", unit = \"deg\"}\n";
};

TEST_F(ImportTable, EveryDelimiterUnderWhichTheColumnsAreThere) {
  EXPECT_TRUE(expect_plots(plots, mapping()).notes.empty());
  EXPECT_EQ(expect_plots(with(plots, ",", ";"), mapping()).notes, std::vector<std::string>{"delimiter \";\""});
  expect_plots(with(plots, ",", "\t"), mapping());
  expect_plots(with(plots, ",", "|"), mapping());
  expect_plots(with(plots, ",", "   "), mapping());
  expect_plots(with(plots, ",", "  "), mapping("delimiter = \"blanks\""));
  expect_plots(with(plots, ",", "\t"), mapping("delimiter = \"tab\""));
  EXPECT_EQ(refused(with(plots, ",", ";"), mapping("delimiter = \",\"")),
            "r.csv:1: under the delimiter \",\" the columns are: time;recv;rng;az;el; write delimiter = \";\"");
}

TEST_F(ImportTable, ADelimiterAtTheEndOfALineMakesNoColumn) {
  expect_plots(with(plots, "\n", ",\n"), mapping());
  expect_plots(with(plots, "\n", ",,,\n"), mapping());
  expect_plots(with(with(plots, "\n", ",\n"), "el,", "el"), mapping());
  expect_plots(with(plots, "el\n", "el,\n"), mapping());
  EXPECT_EQ(import(mapping()).files.at(0).malformed.count, 0u);
  write_text(folder_ / "r.csv", with(plots, "10.00\n", "10.00,7\n"));
  EXPECT_EQ(import(mapping()).files.at(0).malformed.first.at(0).what, "6 fields instead of 5");
}

TEST_F(ImportTable, DecimalCommasAndThousands) {
  const std::string semicolons = with(plots, ",", ";");
  EXPECT_EQ(expect_plots(with(semicolons, ".", ","), mapping()).notes.back(), "decimal comma");
  expect_plots(with(with(with(semicolons, ".", ","), "12000", "12.000"), "12301", "+12 301"), mapping());
  expect_plots(with(with(plots, "12000.0", "\"12,000.0\""), "12150.5", "\"12,150.5\""), mapping());
  const std::string whole = "time;recv;rng;az;el\n10;10;12,000;120;10\n11;11;12,150;120;10\n";
  EXPECT_EQ(refused(whole, mapping()),
            "r.csv: '12,000' (line 2) can have a decimal comma or thousands: write decimal = \",\" or decimal = \".\"");
  write_text(folder_ / "r.csv", whole);
  import(mapping("decimal = \".\""));
  EXPECT_EQ(radars().at(0).measured.range_m, 12'000);
  import(mapping("decimal = \",\""));
  EXPECT_EQ(radars().at(0).measured.range_m, 12);
  EXPECT_NE(
      refused("time;recv;rng;az;el\n10,5;10.6;12000;120;10\n", mapping()).find("'10,5' (line 2) has a decimal comma"),
      std::string::npos);
  EXPECT_NE(refused(with(with(plots, ".", ","), "rng,az", "rng,az"), mapping()).find("cannot be told apart"),
            std::string::npos);
}

TEST_F(ImportTable, CommentsTitlesAndHeadersAgainAreNoRows) {
  const std::string rows = plots;
  expect_plots("# radar A\n% exported\n" + rows, mapping());
  EXPECT_EQ(expect_plots(with(rows, "10.5,", "# operator: lost lock\n10.5,"), mapping()).passed_over.comments, 1u);
  expect_plots(with(rows, "10.5,", "! lost lock\n10.5,"), mapping("comment = [\"!\", \"#\"]"));
  EXPECT_EQ(expect_plots(with(rows, "10.5,", "! lost lock\n10.5,"), mapping()).malformed.count, 1u);
  EXPECT_EQ(expect_plots("Radar A\nPass 3, noon\n\n" + rows, mapping()).notes.at(0), "header on line 4");
  expect_plots("# " + rows, mapping());
  EXPECT_EQ(expect_plots(with(rows, "10.5,", "time,recv,rng,az,el\n10.5,"), mapping()).passed_over.headers, 1u);
}

TEST_F(ImportTable, ColumnsByNumber) {
  const std::string rows = std::string(plots).substr(std::string(plots).find('\n') + 1);
  std::string numbered = columns_;
  for (const char* name : {"time =", "recv =", "rng =", "az =", "el ="}) {
    static int number = 0;
    numbered.replace(numbered.find(name), std::string(name).size(), std::to_string(number++ % 5 + 1) + " =");
  }
  expect_plots(rows, mapping("header = false", numbered));
  expect_plots(with(rows, ",", "  "), mapping("header = false", numbered));
  expect_plots(with(rows, "\n", ",7\n"), mapping("header = false\nother_columns = \"ignore\"", numbered));
  EXPECT_NE(refused(with(rows, "\n", ",7\n"), mapping("header = false", numbered)).find("6 under \",\""),
            std::string::npos);
  EXPECT_EQ(refused(rows, mapping()),
            "r.csv:1: no header line, numbers at once: 10.0, 10.05, 12000.0, 120.00, 10.00; write header = false and "
            "name the columns by number: 1 = {...}");
  expect_plots(plots, mapping("", with(columns_, "rng =", "\"#3\" =")));
}

TEST_F(ImportTable, OneOfTwoEqualNames) {
  const std::string twice = with(with(with(plots, "el\n", "el,rng\n"), "0\n", "0,7\n"), "rng,7", "rng");
  EXPECT_EQ(refused(twice, mapping()),
            "r.csv:1: column 'rng' is there 2 times (columns 3 and 6): say which, as \"rng#1\" or \"rng#2\"");
  expect_plots(twice, mapping("", with(columns_, "rng =", "\"rng#1\" =") + "\"rng#2\" = \"ignore\"\n"));
  EXPECT_NE(refused(twice, mapping("", with(columns_, "rng =", "\"rng#1\" ="))).find("write: \"#6\" = \"ignore\""),
            std::string::npos);
}

TEST_F(ImportTable, RowsOfOneTrackOnly) {
  std::string csv = with(with(plots, "el\n", "el,TRK\n"), "0\n", "0,1\n");
  csv += "10.2,10.25,99999,1,1,02\n";
  EXPECT_EQ(expect_plots(csv, mapping("where = {column = \"TRK\", equals = 1}")).passed_over.filtered, 1u);
  expect_plots(csv, mapping("where = {column = \"TRK\", differs = [\"2\", \"3\"]}"));
  EXPECT_EQ(refused(csv, mapping("where = {column = \"TRK\", equals = \"7\"}")),
            "r.csv: no row passes where; values of rows that do not: 02, 1");
  EXPECT_NE(refused(csv, mapping("where = {column = \"TRAK\", equals = 1}")).find("no column 'TRAK'"),
            std::string::npos);
  EXPECT_NE(refusal(mapping("where = {column = \"TRK\"}")).find("file[0].where.equals: needed"), std::string::npos);
}

TEST_F(ImportTable, AFileThatGivesNoRowIsAnError) {
  EXPECT_EQ(refused("", mapping()), "r.csv: no header line: the file is empty");
  EXPECT_EQ(refused("# a\n\n", mapping()), "r.csv: no header line: the file is empty but for comments");
  EXPECT_EQ(refused("time,recv,rng,az,el\n", mapping()), "r.csv: no row behind the header (time, recv, rng, az, el)");
  EXPECT_EQ(refused("time,recv,rng,az,el\n1,2,x,4,5\n,,,,\n", mapping()),
            "r.csv: none of its 2 rows can be imported: 1 row, the first on line 2: rng: 'x' is not a number; 1 row, "
            "the first on line 3: recv: empty (columns: time, recv, rng, az, el)");
  EXPECT_EQ(refused("Time,Recv,Rng\n1,2,3\n", mapping()),
            "r.csv:1: no column 'az'; the columns there are: Time, Recv, Rng");
  EXPECT_NE(refused("time,recv,rng\x1b[31m\n1,2,3\n", mapping()).find("rng\\x1b[31m"), std::string::npos);
  EXPECT_FALSE(std::filesystem::exists(folder_ / "out.mcap"));
}

TEST_F(ImportTable, DatesAndTimesOfDay) {
  const auto clocks = [&](const std::string& before, const std::string& after = "") {
    std::string csv = plots;
    for (const char* t : {"10.0,", "10.05,", "10.5,", "10.55,", "11.0,", "11.05,"}) {
      csv = with(csv, std::string("\n") + t, "\n" + before + t);
    }
    for (const char* t : {"10.05", "10.55", "11.05"})
      csv = with(csv, std::string(",") + t, after + "," + before + t + after);
    return csv;
  };
  expect_plots(clocks("2018-02-06T20:45:", "Z"), mapping());
  expect_plots(clocks("2018-02-06 20:45:"), mapping("", times("unit = \"text\"")));
  expect_plots(clocks("2018-037T20:45:"), mapping());
  expect_plots(clocks("037:20:45:"), mapping());
  expect_plots(clocks("T+00:00:"), mapping());
  expect_plots(clocks("20:45:"), mapping("", times("unit = \"s\", since = \"midnight\"")));
  expect_plots(clocks("20:45:"), mapping("date = 2018-02-06", times("unit = \"text\", since = \"midnight\"")));
  expect_plots(clocks("00:00:"), mapping("", times("unit = \"s\", since = \"liftoff\"")));
  EXPECT_NE(refused(clocks("20:45:"), mapping()).find("write since = \"midnight\""), std::string::npos);
  EXPECT_NE(refused(clocks("02/06/2018 20:45:"), mapping()).find("dates are year-month-day"), std::string::npos);
  expect_plots(clocks("2018-02-06T20:45:", "Z"), mapping("", times("unit = \"text\"")));
  EXPECT_NE(refused(plots, mapping("", times("unit = \"text\""))).find("'10.05' is no date and no time of day"),
            std::string::npos);
}

TEST_F(ImportTable, OtherTimeScales) {
  const auto csv_of = [&](double base) {
    std::string csv = "time,recv,rng,az,el\n";
    for (int i = 0; i < 3; ++i) {
      char line[120];
      std::snprintf(line, sizeof line, "%.3f,%.3f,%.1f,%.2f,%.2f\n", base + 10 + 0.5 * i, base + 10.05 + 0.5 * i,
                    12'000 + 150.5 * i, 120 + 0.05 * i, 10 + 0.1 * i);
      csv += line;
    }
    return csv;
  };
  constexpr double unix_s = 1'517'949'900;
  constexpr double gps_s = unix_s - 315'964'800 + 18;
  expect_plots(csv_of(unix_s), mapping("", times("unit = \"s\", since = \"unix\"")));
  expect_plots(csv_of(gps_s), mapping("time_scale = \"GPS\"", times("unit = \"s\", since = \"gps\"")));
  expect_plots(csv_of(unix_s + 37), mapping("time_scale = \"TAI\"", times("unit = \"s\", since = \"unix\"")));
  // Seconds of the GPS week that began on Sunday 2018-02-04.
  expect_plots(csv_of(2 * 86'400 + 20.75 * 3600 + 18),
               mapping("time_scale = \"GPS\"", times("unit = \"s\", since = 2018-02-04T00:00:00Z")));
  expect_plots(csv_of(gps_s - 1),
               "leap_seconds = 17\n" + mapping("time_scale = \"GPS\"", times("unit = \"s\", since = \"gps\"")));
  EXPECT_NE(refused(csv_of(0), mapping("time_scale = \"GPS\"")).find("time_scale has no meaning"), std::string::npos);
  EXPECT_NE(refused(csv_of(unix_s * 1000), mapping("", times("unit = \"s\", since = \"unix\"")))
                .find("it would be one with unit = \"ms\", since = \"unix\""),
            std::string::npos);
}

TEST_F(ImportTable, TimesThatStartAnewAreContinuedOnRequest) {
  const std::string csv =
      "time,recv,rng,az,el\n86399,86399.5,12000,120,10\n86399.9,0.4,12150,120,10\n0.9,1.4,12300,120,10\n";
  const std::string columns = with(times("unit = \"s\", offset = -86340"), "time", "time");
  EXPECT_EQ(refused(csv, mapping("", columns)).substr(0, 40), "r.csv: line 3 is 86399.100 s before the ");
  EXPECT_NE(refused(csv, mapping("sort = true", columns)).find("wrap_s = 86400"), std::string::npos);
  const auto epochs = [&] {
    std::vector<std::int64_t> all;  // ms
    for (const RadarTspi& radar : radars()) all.push_back((radar.epoch - t0).ns / 1'000'000);
    return all;
  };
  import(mapping("wrap_s = 86400", columns));
  EXPECT_EQ(epochs(), (std::vector<std::int64_t>{59'000, 59'900, 60'900}));
  EXPECT_EQ(radars().at(1).received, t0 + milliseconds(60'400)) << "each column by itself";
  import(mapping("wrap_s = 0\nsort = false", columns));
  EXPECT_EQ(radars().size(), 3u);

  // A time of day is continued by what it is: lift-off 50 s before midnight.
  const std::string night = with(mapping("", times("unit = \"s\", since = \"midnight\"")), "20:45:00Z", "23:59:10Z");
  import(night);
  const Time liftoff = t0 + Duration{(3 * 3600 + 14 * 60 + 10) * 1'000'000'000LL};
  EXPECT_EQ(radars().at(0).epoch, liftoff + milliseconds(49'000));
  EXPECT_EQ(radars().at(2).epoch, liftoff + milliseconds(50'900));
}

TEST_F(ImportTable, RowsOutOfOrderAreSortedOnRequest) {
  const std::string csv =
      "time,recv,rng,az,el\n11.0,11.05,12301.0,120.10,10.20\n10.5,10.55,12150.5,120.05,10.10\n10.0,10.05,12000,120,"
      "10\n";
  EXPECT_EQ(refused(csv, mapping()),
            "r.csv: the rows are newest first (2 of 2 steps back in time, the first at line 3); write sort = true to "
            "sort the "
            "rows, or sort = false to take them as they stand");
  expect_plots(csv, mapping("sort = true"));
  EXPECT_EQ(radars().at(0).sequence, 1u) << "numbered as sorted";
  const std::string late = with(columns_, "{field = \"received\", unit = \"s\"}", "\"ignore\"");
  const std::string blocks = std::string(plots) + "200,0,13000,120,10\n10.2,0,12060,120,10\n";
  EXPECT_NE(refused(blocks, mapping("latency_s = 0.05", late)).find("line 6 is 189.800 s before the row before"),
            std::string::npos);
  import(mapping("latency_s = 0.05\nsort = true", late));
  EXPECT_EQ(radars().at(1).received, t0 + milliseconds(10'250));
}

TEST_F(ImportTable, ModesSignalsAndRatesWhereARowHasThem) {
  write_text(folder_ / "r.csv",
             "time,recv,rng,az,el,mode,snr,rr\n"
             "10.0,10.05,12000,120,10,AUTO,12.5,300\n"
             "10.5,10.55,12150,120,10,1,,-\n"
             "11.0,11.05,12300,120,10,?,-999,nan\n"
             "11.5,11.55,12450,120,10,7,1,1\n");
  const std::string columns = columns_ +
                              "mode = {field = \"mode\", values = {AUTO = \"track\", \"1.0\" = \"acquire\"}}\n"
                              "snr = {field = \"snr\", unit = \"dB\"}\nrr = {field = \"range_rate\", unit = \"m/s\"}\n";
  const FileReport file = import(mapping("missing = -999", columns)).files.at(0);
  EXPECT_EQ(file.not_finite.first.at(0).what, "mode: '?' is no value");
  EXPECT_EQ(file.malformed.first.at(0).what, "mode: '7' is no value of it; write values = {\"7\" = ...}");
  EXPECT_EQ(file.left_empty, 2u);
  const auto all = radars();
  ASSERT_EQ(all.size(), 2u);
  EXPECT_EQ(all[0].mode, TrackMode::Track);
  EXPECT_EQ(all[0].snr_db, 12.5);
  EXPECT_EQ(all[0].range_rate_m_s, 300);
  EXPECT_TRUE(all[0].range_rate_valid);
  EXPECT_EQ(all[1].mode, TrackMode::Acquire);
  EXPECT_FALSE(all[1].range_rate_valid);
  EXPECT_EQ(import(mapping("missing = \"-999\"", with(columns, "{AUTO = \"track\", \"1.0\" = \"acquire\"}",
                                                      "{\"*\" = \"coast\", AUTO = \"track\"}")))
                .files.at(0)
                .imported,
            3u);
  EXPECT_EQ(radars().at(1).mode, TrackMode::Coast);
  EXPECT_NE(
      refusal(mapping("", with(columns, "\"track\"", "\"follow\""))).find("allowed: search, acquire, track, coast"),
      std::string::npos);
}

TEST_F(ImportTable, FixTypesAndSatellites) {
  write_text(folder_ / "r.csv",
             "t,lat,lon,h,q,n,vx,vy,vz\n"
             "1,30,-80,100,1,9,1,2,3\n"
             "2,30,-80,100,0,0,1,,3\n"
             "3,30,-80,100,1,9.5,1,2,3\n"
             "4,30,-80,100,1,300,1,2,3\n");
  const std::string text =
      "mission = \"m\"\ntarget = \"t\"\nliftoff = 2018-02-06T20:45:00Z\n[[file]]\npath = \"r.csv\"\nkind = \"gps\"\n"
      "station = \"tm\"\nlatency_s = 0.2\n[file.columns]\nt = {field = \"epoch\", unit = \"s\"}\n"
      "lat = {field = \"latitude\", unit = \"deg\"}\nlon = {field = \"longitude\", unit = \"deg\"}\n"
      "h = {field = \"height\", unit = \"m\"}\nq = {field = \"fix\", values = {\"0\" = \"none\", \"1\" = \"3d\"}}\n"
      "n = {field = \"satellites\"}\nvx = {field = \"vx\", unit = \"m/s\"}\nvy = {field = \"vy\", unit = \"m/s\"}\n"
      "vz = {field = \"vz\", unit = \"m/s\"}\n";
  const FileReport file = import(text).files.at(0);
  EXPECT_EQ(file.malformed.count, 2u);
  EXPECT_EQ(file.malformed.first.at(0).what, "n: '9.5' is no count of satellites");
  const auto all = events();
  ASSERT_EQ(all.size(), 3u);
  const auto& good = std::get<GpsFix>(all[1]);
  EXPECT_EQ(good.fix, FixType::ThreeDimensional);
  EXPECT_EQ(good.satellites, 9);
  EXPECT_TRUE(good.velocity_valid);
  const auto& none = std::get<GpsFix>(all[2]);
  EXPECT_EQ(none.fix, FixType::None);
  EXPECT_TRUE(none.satellites == 0 && none.satellites_valid);
  EXPECT_FALSE(none.velocity_valid) << "two of three components are no velocity";
}

}  // namespace
}  // namespace downrange::archive
