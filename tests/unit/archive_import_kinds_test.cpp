// Kinds of files: columns by place, cells with line breaks, several sources in one file, units in the header, headers
// put together, sentences of a receiver.

#include <numbers>

#include "archive_import_testing.hpp"

namespace downrange::archive {
namespace {

constexpr double deg = std::numbers::pi / 180;

std::string columns(const std::string& more = "") {
  return "time = {field = \"epoch\", unit = \"s\"}\nrecv = {field = \"received\", unit = \"s\"}\n"
         "rng = {field = \"range\", unit = \"m\"}\naz = {field = \"azimuth\", unit = \"deg\"}\n"
         "el = {field = \"elevation\", unit = \"deg\"}\n" +
         more;
}

std::string mapping(const std::string& keys = "", const std::string& columns_of = columns()) {
  const bool own = keys.find("sensor") != std::string::npos;
  return "mission = \"m\"\ntarget = \"t\"\nliftoff = 2018-02-06T20:45:00Z\n[[file]]\npath = \"r.csv\"\nkind = "
         "\"radar\"\n" +
         std::string(own ? "" : "sensor = \"ra\"\n") + keys + "\n[file.columns]\n" + columns_of;
}

class ImportKinds : public ArchiveImport {
 protected:
  FileReport imported(const std::string& csv, const std::string& map) {
    write_text(folder_ / "r.csv", csv);
    return import(map).files.at(0);
  }
  std::string refused(const std::string& csv, const std::string& map) {
    write_text(folder_ / "r.csv", csv);
    std::string text = refusal(map);
    const std::string folder = (folder_ / "").string();
    return text.starts_with(folder) ? text.substr(folder.size()) : text;
  }
  std::vector<double> ranges() {
    std::vector<double> all;
    for (const RadarTspi& radar : radars()) all.push_back(radar.measured.range_m);
    return all;
  }
};
using Ranges = std::vector<double>;

std::string placed() {
  return "time = {field = \"epoch\", unit = \"s\", at = [1, 6]}\nrecv = {field = \"received\", unit = \"s\", at = [7, "
         "12]}\n"
         "rng = {field = \"range\", unit = \"m\", scale = 0.1, at = [13, 18]}\n"
         "az = {field = \"azimuth\", unit = \"deg\", at = [19, 24]}\nel = {field = \"elevation\", unit = \"deg\", at = "
         "[25, 29]}\n";
}

TEST_F(ImportKinds, ColumnsByTheirPlaces) {
  const std::string rows = "010.00010.05120000120.0010.00\n010.50010.55121505120.0510.10\n";
  const FileReport file = imported(rows, mapping("header = false", placed()));
  EXPECT_EQ(ranges(), (Ranges{12'000, 12'150.5}));
  EXPECT_EQ(file.notes.at(0), "columns by their places");
  imported("  time  recv   rng    az   el\n" + rows, mapping("", placed()));
  EXPECT_EQ(radars().size(), 2u);
  imported("RADAR 7\nPASS 3\n" + rows, mapping("header = false\nskip_lines = 2", placed()));
  EXPECT_EQ(radars().size(), 2u);
  EXPECT_EQ(refused(rows, mapping("", placed())), "r.csv:1: numbers, no header; write header = false");
  EXPECT_NE(refused(rows, mapping("header = false")).find("at = [first, last]"), std::string::npos);
  EXPECT_NE(refused(rows, mapping()).find("at = [first, last]"), std::string::npos);
  EXPECT_NE(refused("time recv rng az el\n" + rows, mapping()).find("at = [first, last]"), std::string::npos);
  EXPECT_EQ(imported(rows + "010.6\n", mapping("header = false", placed())).not_finite.count, 1u) << "cut off";
}

TEST_F(ImportKinds, PlacesAreDeclaredWholeOrNotAtAll) {
  EXPECT_NE(refusal(mapping("", columns("x = {at = [1, 2]}\n"))).find("'az' has no at = [first, last]"),
            std::string::npos);
  const std::string wrong = "x = {at = [3, 2]}\n";
  EXPECT_NE(refusal(mapping("", placed() + wrong)).find("columns.x.at: must be [first, last]"), std::string::npos);
  EXPECT_NE(refusal(mapping("delimiter = \",\"", placed())).find("delimiter: has no meaning"), std::string::npos);
  const std::string rows = "010.00010.05120000120.0010.00A\n010.50010.55121505120.0510.10B\n";
  imported(rows,
           mapping("header = false\nwhere = {column = \"M\", equals = \"B\"}", placed() + "M = {at = [30, 30]}\n"));
  EXPECT_EQ(ranges(), Ranges{12'150.5});
}

TEST_F(ImportKinds, QuotedCellsWithLineBreaks) {
  const std::string note = columns("note = \"ignore\"\n");
  const FileReport last = imported(
      "time,recv,rng,az,el,note\n10,10,12000,120,10,\"lost\nlock, "
      "twice\"\n11,11,12030,120,10,\n12,12,12060,120,10,\"a\r\n\r\nb\"\n",
      mapping("", note));
  EXPECT_EQ(ranges(), (Ranges{12'000, 12'030, 12'060}));
  EXPECT_EQ(last.malformed.count, 0u);
  EXPECT_EQ(last.rows, 3u);
  imported("note,time,recv,rng,az,el\n\"lost\nlock\",10,10,12000,120,10\n\"\",11,11,12030,120,10\n", mapping("", note));
  EXPECT_EQ(ranges(), (Ranges{12'000, 12'030}));
  imported("time,recv,\"rng\n[m]\",az,el\n10,10,12000,120,10\n", mapping());
  EXPECT_EQ(ranges(), Ranges{12'000});
  EXPECT_EQ(imported("time,recv,rng,az,el,note\n10,10,12000,120,10,\"a\nb\"\n11,11,12x30,120,10,\n", mapping("", note))
                .malformed.first.at(0)
                .line,
            4u)
      << "lines are counted, not rows";
}

TEST_F(ImportKinds, LinesInQuotesAsAWhole) {
  imported("\"time,recv,rng,az,el\"\n\"10,10,12000,120,10\"\n\"11,11,\"\"12030\"\",120,10\"\n", mapping());
  EXPECT_EQ(ranges(), (Ranges{12'000, 12'030}));
}

TEST_F(ImportKinds, AStrayQuoteJoinsNoRows) {
  const FileReport file = imported(
      "time,recv,rng,az,el\n10,10,\"12000,120,10\n11,11,12030,120,10\n12,12,12060\",120,10\n13,13,12090,120,10\n",
      mapping());
  EXPECT_EQ(ranges(), (Ranges{12'030, 12'090}));
  EXPECT_EQ(file.malformed.count, 2u);
}

TEST_F(ImportKinds, AnglesAsDegreesMinutesAndSeconds) {
  imported("time,recv,rng,az,el\n10,10,12000,120:30:00,-0:30:00\n11,11,12000,120 30 00.0,10\u00B015'\n", mapping());
  EXPECT_NEAR(radars().at(0).measured.azimuth_rad, 120.5 * deg, 1e-12);
  EXPECT_NEAR(radars().at(0).measured.elevation_rad, -0.5 * deg, 1e-12);
  EXPECT_NEAR(radars().at(1).measured.azimuth_rad, 120.5 * deg, 1e-12);
  EXPECT_NEAR(radars().at(1).measured.elevation_rad, 10.25 * deg, 1e-12);
  std::string radians = columns();
  radians.replace(radians.find("deg"), 3, "rad");
  EXPECT_NE(
      refused("time,recv,rng,az,el\n10,10,12000,120:30:00,10\n", mapping("", radians)).find("write unit = \"deg\""),
      std::string::npos);
}

TEST_F(ImportKinds, ACellMaySayItsUnitWhereItIsTheDeclaredOne) {
  imported("time,recv,rng,az,el\n10 s,10 s,12000 m,120\u00B0,10deg\n",
           mapping("", replaced(columns(), "\"s\"", "\"s\"")));
  EXPECT_EQ(radars().size(), 1u);
  EXPECT_NE(
      refused("time,recv,rng,az,el\n10,10,12 km,120,10\n", mapping()).find("'12 km' says km, the mapping unit = \"m\""),
      std::string::npos);
}

TEST_F(ImportKinds, NamesFromAColumn) {
  const std::string csv =
      "RADAR,OBJ,time,recv,rng,az,el\n1,A,10,10,12000,120,10\n2,A,10,10,52000,220,10\n"
      "1,A,11,11,12030,120,10\n,A,11,11,1,1,1\n2,B,12,12,52060,220,10\n";
  write_text(folder_ / "r.csv", csv);
  const ImportReport report = import(mapping(
      "sensor = {column = \"RADAR\", names = {\"1\" = \"cape\", \"2\" = \"merritt\"}}\ntarget = {column = \"OBJ\"}"));
  ASSERT_EQ(report.files.size(), 3u);
  EXPECT_EQ(report.files[0].source.view(), "cape");
  EXPECT_EQ(report.files[0].imported, 2u);
  EXPECT_EQ(report.files[1].source.view(), "merritt");
  EXPECT_EQ(report.files[2].notes.back(), "rows of RADAR = 2, OBJ = B");
  EXPECT_EQ(report.files[0].notes.back(), "1 rows without a name");
  std::vector<std::string> seen;
  for (const RadarTspi& radar : radars()) seen.push_back(std::string(radar.sensor.view()) + '/' + radar.target.c_str());
  EXPECT_EQ(seen, (std::vector<std::string>{"cape/A", "merritt/A", "cape/A", "merritt/B"}));

  EXPECT_EQ(
      refused(
          csv,
          mapping(
              "sensor = {column = \"RADAR\", names = {\"1\" = \"cape\"}}\nwhere = {column = \"OBJ\", equals = \"A\"}")),
      "r.csv:3: column 'RADAR': '2' is not among its names; leave its rows out (where) or write names = {\"2\" = ...}");
  EXPECT_NE(refused(csv, mapping("sensor = {column = \"STATION\"}")).find("no column 'STATION'"), std::string::npos);
  std::string many = "RADAR,time,recv,rng,az,el\n";
  for (int i = 0; i < 70; ++i) many += std::to_string(i) + ",10,10,12000,120,10\n";
  EXPECT_NE(refused(many, mapping("sensor = {column = \"RADAR\"}")).find("more than 64 names"), std::string::npos);
  EXPECT_NE(refusal(mapping("sensor = {column = \"R\", name = {}}")).find("file[0].sensor.name: unknown key"),
            std::string::npos);
}

TEST_F(ImportKinds, UnitsThatTheHeaderSays) {
  imported("Time [s];Recv (sec);RNG [m];Az [\u00B0];El (deg)\n10;10;12000;120;10\n", mapping());
  EXPECT_EQ(ranges(), Ranges{12'000});
  EXPECT_TRUE(
      refused("time,recv,rng [km],az,el\n10,10,12,120,10\n", mapping())
          .starts_with("r.csv:1: column 'rng [km]' says km, the mapping says unit = \"m\": write unit = \"km\""));
  EXPECT_NE(refused("time,recv,rng,az (rad),el\n10,10,12000,1.2,0.1\n", mapping()).find("write unit = \"rad\""),
            std::string::npos);
  const FileReport file = imported("time,recv,rng,az,el\n[s],[s],[m],[deg],[deg]\n10,10,12000,120,10\n", mapping());
  EXPECT_EQ(file.passed_over.headers, 1u);
  EXPECT_EQ(file.malformed.count, 0u);
  EXPECT_EQ(imported("time,recv,rng,az,el\nUTC,-,m,deg,deg\n10,10,12000,120,10\n", mapping()).passed_over.headers, 1u);
  EXPECT_NE(refused("time,recv,rng,az,el\ns,s,km,deg,deg\n10,10,12,120,10\n", mapping())
                .find("r.csv:2: the line of units, at column 'rng', says km"),
            std::string::npos);
  imported("time,recv,rng [km],az,el\n10,10,12000,120,10\n", mapping("", replaced(columns(), "rng", "\"#3\"")));
  EXPECT_EQ(ranges(), Ranges{12'000}) << "by its number: whatever the header says";
}

TEST_F(ImportKinds, HeadersBetweenTheRows) {
  imported("time,recv,rng,az,el\n10,10,12000,120,10\nel,az,rng,recv,time\n10,120,12030,11,11\n", mapping());
  EXPECT_EQ(ranges(), (Ranges{12'000, 12'030})) << "files put together, columns in another order";
  EXPECT_NEAR(radars().at(1).measured.azimuth_rad, 120 * deg, 1e-12);
  EXPECT_EQ(refused("time,recv,rng,az,el\n10,10,12000,120,10\ntime,recv,rng,az,elev\n11,11,12030,120,10\n", mapping()),
            "r.csv:3: no column 'el'; the columns there are: time, recv, rng, az, elev");
}

TEST_F(ImportKinds, ColumnsThatNobodyNeedsMayShareAName) {
  imported("time,flag,recv,rng,flag,az,el\n10,x,10,12000,y,120,10\n", mapping("", columns("flag = \"ignore\"\n")));
  EXPECT_EQ(ranges(), Ranges{12'000});
  imported(",time,recv,rng,az,el\n,10,10,12000,120,10\n", mapping());
  EXPECT_EQ(ranges(), Ranges{12'000}) << "a column without a name and without a cell";
  EXPECT_NE(refused(",time,recv,rng,az,el\n0,10,10,12000,120,10\n", mapping()).find("\"#1\" = \"ignore\""),
            std::string::npos);
}

TEST_F(ImportKinds, ZeroBytesSpoilTheirRow) {
  using namespace std::string_literals;
  const FileReport file = imported(
      "time,recv,rng,az,el\n10,10,12000,120,10\n11,11,12\0\0,120,10\n12,12,12060,120,10\n"s + std::string(100, '\0'),
      mapping());
  EXPECT_EQ(ranges(), (Ranges{12'000, 12'060}));
  EXPECT_EQ(file.malformed.first.at(0).what, "holds zero bytes");
  EXPECT_EQ(file.notes.at(0), "100 zero bytes at the end left off");
}

TEST_F(ImportKinds, AVeryLongLineSpoilsItselfOnly) {
  const FileReport file = imported("time,recv,rng,az,el\n10,10,12000,120,10\n" + std::string(3'000'000, ',') + "\n" +
                                       std::string(3'000'000, '7') + "\n12,12,12060,120,10\n",
                                   mapping());
  EXPECT_EQ(ranges(), (Ranges{12'000, 12'060}));
  EXPECT_EQ(file.malformed.count, 2u);
}

TEST_F(ImportKinds, ADateInAColumnOfItsOwn) {
  std::string split = columns("day = {field = \"date\"}\n");
  imported(
      "day,time,recv,rng,az,el\n2018-02-06,23:59:59.5,23:59:59.6,12000,120,10\n2018-02-07,00:00:00.5,00:00:00.6,12030,"
      "120,10\n",
      mapping("accept_implausible = true", split));
  EXPECT_EQ((radars().at(1).epoch - radars().at(0).epoch).seconds(), 1.0);
  imported("day,time,recv,rng,az,el\n6.2.2018,20:45:10,20:45:10.1,12000,120,10\n",
           mapping("date_order = \"dmy\"", split));
  EXPECT_EQ(radars().at(0).epoch, t0 + milliseconds(10'000));
  EXPECT_NE(refused("day,time,recv,rng,az,el\n6.2.2018,20:45:10,20:45:10.1,12000,120,10\n", mapping("", split))
                .find("date_order"),
            std::string::npos);
}

TEST_F(ImportKinds, TimesThatNeedAnotherKeyAreToldWhich) {
  const auto doubt_of = [&](const std::string& time) {
    const FileReport file = imported("time,recv,rng,az,el\n" + time + "," + time + ",12000,120,10\n", mapping());
    return file.doubts.empty() ? std::string() : file.doubts.front();
  };
  EXPECT_NE(doubt_of("204510").find("unit = \"hhmmss\", since = \"midnight\""), std::string::npos);
  EXPECT_NE(doubt_of("247518").find("since = 2018-02-04T00:00:00Z, time_scale = \"GPS\""), std::string::npos)
      << "a Tuesday's evening, from Sunday on";
  EXPECT_NE(doubt_of("10000").find("unit = \"ms\""), std::string::npos);
  EXPECT_EQ(doubt_of("10"), "");
  imported("time,recv,rng,az,el\n20180206204510.0,20180206204510.1,12000,120,10\n", mapping());
  EXPECT_EQ(radars().at(0).epoch, t0 + milliseconds(10'000)) << "a date as one number is one";
}

TEST_F(ImportKinds, TimesAsOneNumber) {
  std::string packed = columns();
  for (const char* name : {"time", "recv"}) {
    const std::size_t at = packed.find("\"s\"", packed.find(name));
    packed.replace(at, 3, "\"hhmmss\", since = \"midnight\"");
  }
  imported("time,recv,rng,az,el\n204510.000,204510.050,12000,120,10\n", mapping("", packed));
  EXPECT_EQ(radars().at(0).epoch, t0 + milliseconds(10'000));
}

constexpr const char* nmea_mapping =
    "mission = \"m\"\ntarget = \"t\"\nliftoff = 2018-02-06T20:45:00Z\n[[file]]\npath = \"r.csv\"\nkind = \"gps\"\n"
    "format = \"nmea\"\nstation = \"tm\"\nlatency_s = 0.1\n";

std::string with_checksum(const std::string& body) {
  unsigned sum = 0;
  for (const char c : body) sum ^= static_cast<unsigned char>(c);
  char text[8];
  std::snprintf(text, sizeof text, "*%02X", sum);
  return '$' + body + text + "\r\n";
}

TEST_F(ImportKinds, SentencesOfAReceiver) {
  // The first is the well-known example of the standard's texts, with its published checksum; height 545.4 m + 46.9 m.
  std::string text = "$GPGGA,123519,4807.038,N,01131.000,E,1,08,0.9,545.4,M,46.9,M,,*47\r\n";
  std::string map = nmea_mapping;
  map.replace(map.find("20:45:00Z"), 9, "12:35:00Z");
  const FileReport known = imported(text, map);
  EXPECT_EQ(known.imported, 1u);
  for (const Event& event : events()) {
    const auto* gps = std::get_if<GpsFix>(&event);
    if (gps == nullptr) continue;
    const Geodetic at = geodetic_from_ecef(gps->position);
    EXPECT_NEAR(at.latitude_rad, (48 + 7.038 / 60) * deg, 1e-12);
    EXPECT_NEAR(at.longitude_rad, (11 + 31.0 / 60) * deg, 1e-12);
    EXPECT_NEAR(at.height_m, 592.3, 1e-6);
    EXPECT_EQ(gps->satellites, 8);
    EXPECT_FALSE(gps->velocity_valid);
  }
}

TEST_F(ImportKinds, DatesAndSigmasOfOtherSentences) {
  const std::string text = with_checksum("GNRMC,235959.00,A,3426.0000,S,12730.0000,W,0.0,0.0,060218,,,A") +
                           with_checksum("GNGGA,235959.00,3426.0000,S,12730.0000,W,4,12,0.9,100.0,M,-20.0,M,,") +
                           with_checksum("GNGST,235959.00,1,1,1,0,3,4,5") + "noise\r\n" + "2018-02-07 00:00:00 " +
                           with_checksum("GNGGA,000000.00,3426.0000,S,12730.0000,W,6,12,0.9,100.0,M,-20.0,M,,") +
                           "$GNGGA,000001.00,3426.0000,S,12730.0000,W,1,12,0.9,100.0,M,-20.0,M,,*00\r\n" +
                           with_checksum("GNGGA,000002.00,,,,,0,00,,,M,,M,,") +
                           with_checksum("GNGGA,000003.00,3426.0,S,12730.0,W,1,9,1,100,M,,M,,");
  std::string map = nmea_mapping;
  map.replace(map.find("20:45:00Z"), 9, "23:59:50Z");
  const FileReport file = imported(text, map);
  std::vector<GpsFix> fixes;
  for (const Event& event : events()) {
    if (const auto* gps = std::get_if<GpsFix>(&event)) fixes.push_back(*gps);
  }
  ASSERT_EQ(fixes.size(), 2u);
  EXPECT_EQ((fixes[1].epoch - fixes[0].epoch).seconds(), 1.0) << "over midnight";
  EXPECT_NEAR(fixes[0].sigma_horizontal_m, std::sqrt(12.5), 1e-4);
  EXPECT_EQ(fixes[0].sigma_vertical_m, 5);
  EXPECT_EQ(fixes[0].fix, FixType::Differential);
  EXPECT_EQ(fixes[1].fix, FixType::None) << "estimated is no fix";
  EXPECT_NEAR(geodetic_from_ecef(fixes[0].position).latitude_rad, -(34 + 26.0 / 60) * deg, 1e-12);
  EXPECT_EQ(file.malformed.count, 2u) << "a wrong checksum, a height above the sea alone";
  EXPECT_NE(file.malformed.first.at(0).what.find("checksum is not"), std::string::npos);
  EXPECT_EQ(file.malformed.first.at(0).line, 6u);
  EXPECT_EQ(file.not_finite.count, 1u) << "no position";
  EXPECT_EQ(file.notes.at(0), "NMEA sentences: 5 GGA, 1 GST, 1 RMC");
}

TEST_F(ImportKinds, SentencesWithoutAFixAreAnError) {
  EXPECT_EQ(refused(with_checksum("GPVTG,,,,,,,,,N"), nmea_mapping),
            "r.csv: no GGA and no GNS sentence; sentences: 1 VTG");
  std::string radar = nmea_mapping;
  radar.replace(radar.find("\"gps\""), 5, "\"truth\"");
  EXPECT_NE(refusal(radar).find("format: nmea is of kind gps only"), std::string::npos);
}

}  // namespace
}  // namespace downrange::archive
