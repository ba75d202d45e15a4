// The CSV importer: what a mapping says is what arrives, and nothing that is wrong goes by in silence.

#include <algorithm>
#include <cstdlib>
#include <downrange/geo/site.hpp>
#include <numbers>
#include <source_dir.hpp>

#include "archive_import_testing.hpp"

namespace downrange::archive {
namespace {

constexpr const char* radar_mapping = R"(mission = "m1"
target = "rocket"
liftoff = 2018-02-06T20:45:00Z
[[file]]
path = "radar.csv"
kind = "radar"
sensor = "cape"
[file.columns]
time_s = {field = "epoch", unit = "s"}
recv_s = {field = "received", unit = "s"}
range_km = {field = "range", unit = "km", offset = 5}
az_deg = {field = "azimuth", unit = "deg"}
el_deg = {field = "elevation", unit = "deg", scale = -1}
outlier = "ignore"
)";

TEST_F(ArchiveImport, ColumnsBecomeFieldsInTheirUnits) {
  write_text(folder_ / "radar.csv",
             "\xEF\xBB\xBFtime_s,recv_s,range_km,az_deg,el_deg,outlier\r\n"
             "9.9733,9.9747,19.801436,351.091910,-0.339832,0\r\n"
             "\r\n"
             " 10.0733 , 10.1498,\"19.8\",-10,-90,text\r\n");
  const ImportReport report = import(radar_mapping);
  ASSERT_EQ(report.files.size(), 1u);
  EXPECT_EQ(report.files[0].rows, 2u);
  EXPECT_EQ(report.files[0].imported, 2u);
  EXPECT_EQ(report.files[0].malformed.count, 0u);
  EXPECT_EQ(report.events, 3u);
  EXPECT_EQ(report.liftoff, t0);
  EXPECT_EQ(report.last_received, t0 + Duration{10'149'800'000});

  const auto all = radars();
  ASSERT_EQ(all.size(), 2u);
  EXPECT_EQ(all[0].sensor, Name("cape"));
  EXPECT_EQ(all[0].target, Name("rocket"));
  EXPECT_EQ(all[0].sequence, 1u);
  EXPECT_EQ(all[0].epoch, t0 + Duration{9'973'300'000});
  EXPECT_EQ(all[0].received, t0 + Duration{9'974'700'000});
  EXPECT_DOUBLE_EQ(all[0].measured.range_m, 19'801.436 + 5);
  EXPECT_DOUBLE_EQ(all[0].measured.azimuth_rad, 351.091910 * std::numbers::pi / 180);
  EXPECT_DOUBLE_EQ(all[0].measured.elevation_rad, 0.339832 * std::numbers::pi / 180);
  EXPECT_FALSE(all[0].simulated);
  EXPECT_FALSE(all[0].range_rate_valid);
  EXPECT_DOUBLE_EQ(all[1].measured.azimuth_rad, 350 * std::numbers::pi / 180) << "azimuth is in [0, 2 pi)";
  EXPECT_EQ(read_attachment(folder_ / "out.mcap", "import.toml"), radar_mapping);

  const auto first = std::get<MissionEvent>(events()[0]);
  EXPECT_EQ(first.kind, MissionEventKind::Liftoff);
  EXPECT_EQ(first.epoch, t0);
  EXPECT_EQ(first.mission, Name("m1"));
}

TEST_F(ArchiveImport, BadRowsAreLeftOutCountedAndNamed) {
  write_text(folder_ / "radar.csv",
             "time_s,recv_s,range_km,az_deg,el_deg,outlier\n"
             "1,1.1,19,351,0,0\n"
             "2,2.1,19,351\n"
             "3,3.1,abc,351,0,0\n"
             "4,4.1,nan,351,0,0\n"
             "5,5.1,,351,0,0\n"
             "6,6.1,19,-inf,0,0\n"
             "7,7.1,19x,351,0,0\n"
             "1e300,8.1,19,351,0,0\n"
             "9,9.1,1e999,351,0,0\n"
             "10,10.1,20,351,0,0\n"
             "11,11.1,,351,,0\n");
  const FileReport file = import(radar_mapping).files.at(0);
  EXPECT_EQ(file.rows, 11u);
  EXPECT_EQ(file.imported, 6u) << "four of them without range or without angles";
  EXPECT_EQ(file.malformed.count, 4u);
  ASSERT_EQ(file.malformed.first.size(), 4u);
  EXPECT_EQ(file.malformed.first[0].line, 3u);
  EXPECT_EQ(file.malformed.first[0].what, "4 fields instead of 6");
  EXPECT_EQ(file.malformed.first[1].line, 4u);
  EXPECT_EQ(file.malformed.first[1].what, "range_km: 'abc' is not a number");
  EXPECT_EQ(file.malformed.first[3].what, "time_s: '1e300' is no time of a flight");
  EXPECT_EQ(file.not_finite.count, 1u);
  EXPECT_EQ(file.not_finite.first[0].line, 12u);
  EXPECT_EQ(file.not_finite.first[0].what, "neither a range nor both angles");
  EXPECT_EQ(radars().back().sequence, 10u) << "the sequence is the row's number, bad rows included";
}

TEST_F(ArchiveImport, APlotMayLackItsRangeOrItsAngles) {
  write_text(folder_ / "radar.csv",
             "time_s,recv_s,range_km,az_deg,el_deg,outlier\n"
             "1,1.1,19,351,2,0\n"
             "2,2.1,,351,2,0\n"
             "3,3.1,20,,2,0\n"
             "4,4.1,21,nan,nan,0\n");
  const FileReport file = import(radar_mapping).files.at(0);
  EXPECT_EQ(file.imported, 4u);
  EXPECT_EQ(file.not_finite.count, 0u);
  const auto told = [&](const char* note) { return std::ranges::count(file.notes, std::string(note)); };
  EXPECT_EQ(told("1 plots without range"), 1);
  EXPECT_EQ(told("2 plots without angles"), 1);
  EXPECT_NE(file.plausibility.find("range 19.005 to 21.005 km"), std::string::npos) << file.plausibility;
  const std::vector<RadarTspi> all = radars();
  ASSERT_EQ(all.size(), 4u);
  EXPECT_TRUE(all[0].range_valid && all[0].azimuth_valid && all[0].elevation_valid);
  EXPECT_FALSE(all[1].range_valid);
  EXPECT_TRUE(all[1].azimuth_valid && all[1].elevation_valid);
  for (const std::size_t without_angles : {2U, 3U}) {
    EXPECT_TRUE(all[without_angles].range_valid);
    EXPECT_FALSE(all[without_angles].azimuth_valid || all[without_angles].elevation_valid);
    EXPECT_EQ(all[without_angles].measured.elevation_rad, 0);
  }
}

TEST_F(ArchiveImport, ARadarThatMeasuresRangeOnlyHasNoAngles) {
  const std::string without_azimuth = replaced(radar_mapping, "{field = \"azimuth\", unit = \"deg\"}", "\"ignore\"");
  EXPECT_NE(refusal(without_azimuth).find("only some of azimuth, elevation"), std::string::npos);
  const std::string mapping =
      replaced(without_azimuth, "{field = \"elevation\", unit = \"deg\", scale = -1}", "\"ignore\"");
  write_text(folder_ / "radar.csv", "time_s,recv_s,range_km,az_deg,el_deg,outlier\n1,1.1,19,351,2,0\n");
  EXPECT_EQ(import(mapping).files.at(0).imported, 1u);
  EXPECT_TRUE(radars().at(0).range_valid);
  EXPECT_FALSE(radars().at(0).azimuth_valid);
}

TEST_F(ArchiveImport, OddTimesAreReportedAndPassedOn) {
  write_text(folder_ / "radar.csv",
             "time_s,recv_s,range_km,az_deg,el_deg,outlier\n"
             "1,1.1,19,351,0,0\n"
             "0.5,1.2,20,351,0,0\n"  // epoch backwards
             "0.5,1.3,21,351,0,0\n"  // epoch again
             "2,2.1,21,351,0,0\n"    // same plot, later
             "3,2.0,22,351,0,0\n");  // received backwards
  const FileReport file = import(radar_mapping).files.at(0);
  EXPECT_EQ(file.imported, 5u);
  EXPECT_EQ(file.epoch_backwards.count, 1u);
  EXPECT_EQ(file.epoch_backwards.first.at(0).line, 3u);
  EXPECT_EQ(file.epoch_repeated.count, 1u);
  EXPECT_EQ(file.epoch_repeated.first.at(0).line, 4u);
  EXPECT_EQ(file.value_repeated.count, 1u);
  EXPECT_EQ(file.value_repeated.first.at(0).line, 5u);
  EXPECT_EQ(file.received_backwards.count, 1u);
  EXPECT_EQ(file.received_backwards.first.at(0).line, 6u);

  std::vector<std::uint64_t> order;
  for (const RadarTspi& radar : radars()) order.push_back(radar.sequence);
  EXPECT_EQ(order, (std::vector<std::uint64_t>{1, 2, 3, 5, 4})) << "in the order they were received";
}

constexpr const char* three_files = R"(mission = "m1"
target = "rocket"
liftoff = 1517949900000000000
[[file]]
path = "gps.csv"
kind = "gps"
station = "tm1"
receiver = "rx"
latency_s = 0.25
delimiter = ";"
[file.columns]
"t ms" = {field = "epoch", unit = "ms", since = "unix"}
lat = {field = "latitude", unit = "deg"}
lon = {field = "longitude", unit = "deg"}
alt = {field = "height", unit = "ft"}
n = {field = "satellites"}
[[file]]
path = "radar.csv"
kind = "radar"
sensor = "b"
[file.columns]
t = {field = "epoch", unit = "s"}
rx = {field = "received", unit = "s"}
r = {field = "range", unit = "m"}
a = {field = "azimuth", unit = "rad"}
e = {field = "elevation", unit = "rad"}
rr = {field = "range_rate", unit = "m/s"}
[[file]]
path = "truth.csv"
kind = "truth"
target = "other"
[file.columns]
t = {field = "epoch", unit = "s"}
x = {field = "x", unit = "m"}
y = {field = "y", unit = "m"}
z = {field = "z", unit = "m"}
)";

TEST_F(ArchiveImport, FilesAreMergedInTheOrderReceived) {
  write_text(folder_ / "gps.csv",
             "t ms;lat;lon;alt;n\n"
             "1517949900750.5;30;-80;1000;9\n"
             "1517949900100;30;-80;2000;9\n"    // the receiver's clock steps back
             "1517949902000;91;-80;2000;9\n");  // no such place
  write_text(folder_ / "radar.csv", "t,rx,r,a,e,rr\n0.9,1.0005,1000,1,0.5,-3\n1.1,1.2,1000,1,0.5,-3\n");
  write_text(folder_ / "truth.csv", "t,x,y,z\n0,6378138,2,3\n1.1,6378139,5,6\n");
  const ImportReport report = import(three_files);
  EXPECT_EQ(report.files.at(0).malformed.count, 1u);
  EXPECT_EQ(report.files.at(0).epoch_backwards.count, 1u);
  EXPECT_EQ(report.truths, 2u);

  Reader reader(folder_ / "out.mcap");
  const auto entries = read_all(reader);
  ASSERT_EQ(entries.size(), 7u);
  EXPECT_EQ(std::get<Truth>(entries[0].record).target, Name("other"));
  EXPECT_TRUE(std::holds_alternative<MissionEvent>(entries[1].record));
  // Radar and GPS received at the same instant: in the order of the range clock, radar first.
  const auto& gps = std::get<GpsFix>(entries[3].record);
  EXPECT_EQ(gps.epoch, t0 + Duration{750'500'000}) << "exact to the nanosecond, though counted from 1970";
  EXPECT_EQ(gps.received, t0 + Duration{1'000'500'000});
  EXPECT_EQ(gps.position.m, ecef_from_geodetic({30 * std::numbers::pi / 180, -80 * std::numbers::pi / 180, 304.8}).m);
  EXPECT_EQ(gps.satellites, 9);
  EXPECT_TRUE(gps.satellites_valid);
  EXPECT_EQ(gps.receiver, Name("rx"));
  EXPECT_FALSE(gps.velocity_valid);
  const auto& gps_back = std::get<GpsFix>(entries[4].record);
  EXPECT_EQ(gps_back.epoch, t0 + Duration{100'000'000});
  EXPECT_EQ(gps_back.received, gps.received) << "a declared latency never makes time of reception run backwards";
  const auto& radar = std::get<RadarTspi>(entries[2].record);
  EXPECT_EQ(radar.received, t0 + Duration{1'000'500'000});
  EXPECT_TRUE(radar.range_rate_valid);
  EXPECT_EQ(radar.range_rate_m_s, -3);
  EXPECT_TRUE(std::holds_alternative<Truth>(entries[5].record));
}

TEST_F(ArchiveImport, AWrongMappingNamesFileLineKeyAndWhatIsAllowed) {
  write_text(folder_ / "radar.csv", "time_s,recv_s,range_km,az_deg,el_deg,outlier\n1,1.1,19,351,0,0\n");
  const std::string file = (folder_ / "import.toml").string();
  const std::string good = radar_mapping;
  const auto expect = [&](const std::string& from, const std::string& to, const std::string& message) {
    const std::string text = refusal(replaced(good, from, to));
    EXPECT_EQ(text.substr(0, file.size() + message.size()), file + message) << text;
  };
  expect("mission = \"m1\"", "mission = 3", ":1: mission: must be a text in quotes");
  expect("target = \"rocket\"", "", ":4: file[0].target: missing here and at the top");
  expect("liftoff = 2018-02-06T20:45:00Z", "liftoff = \"noon\"", ":3: liftoff: must be a date and time with offset");
  expect("20:45:00Z", "20:45:00", ":3: liftoff: must be a date and time with offset");
  expect("liftoff", "lift_off", ":1: liftoff: missing");
  expect("kind = \"radar\"", "kind = \"sonar\"", ":6: file[0].kind: 'sonar'; allowed: radar, angles, gps, truth");
  expect("sensor = \"cape\"", "sensor = \"\"", ":7: file[0].sensor: must be a name of 1 to 31 characters");
  expect("sensor = \"cape\"", "sensor = \"cape\"\ncolour = 1", ":8: file[0].colour: unknown key; allowed: ");
  expect("field = \"epoch\", unit = \"s\"", "field = \"epoch\"",
         ":9: file[0].columns.time_s.unit: missing; allowed: s, ms, us, ns");
  expect("unit = \"deg\"}", "unit = \"degree\"}",
         ":12: file[0].columns.az_deg.unit: 'degree' is no unit of azimuth; allowed: deg, mdeg, arcmin");
  expect("field = \"azimuth\"", "field = \"x\"",
         ":12: file[0].columns.az_deg.field: 'x' is no field of such a file; allowed: epoch, received, range");
  expect("scale = -1", "scale = 0", ":13: file[0].columns.el_deg.scale: must not be 0");
  expect("scale = -1", "scale = inf", ":13: file[0].columns.el_deg.scale: must be a finite number");
  expect("scale = -1", "factor = 1",
         ":13: file[0].columns.el_deg.factor: unknown key; allowed: at, field, offset, scale, unit");
  expect("outlier = \"ignore\"", "outlier = \"?\"", ":14: file[0].columns.outlier: must be \"ignore\"");
  expect("field = \"elevation\"", "field = \"azimuth\"", ":8: file[0].columns: two columns for one field");
  expect("{field = \"received\", unit = \"s\"}", "\"ignore\"", ":4: file[0].latency_s: needed where no column");
  expect("sensor = \"cape\"", "sensor = \"cape\"\nlatency_s = -1", ":8: file[0].latency_s: must be 0 to 3600");
  expect("outlier = \"ignore\"", "outlier = ", ":14: ");  // not TOML
  EXPECT_EQ(refusal(good), "");
}

constexpr const char* angles_mapping = R"(mission = "m1"
target = "rocket"
liftoff = 2018-02-06T20:45:00Z
[[file]]
path = "angles.csv"
kind = "angles"
sensor = "optical"
latency_s = 0.25
[file.columns]
time_s = {field = "epoch", unit = "s"}
az_deg = {field = "azimuth", unit = "deg"}
el_deg = {field = "elevation", unit = "deg"}
)";

TEST_F(ArchiveImport, AnglesHaveNoRange) {
  write_text(folder_ / "angles.csv", "time_s,az_deg,el_deg\n1.5,-10,20\n1.6,-11,nan\n1.6,-11,21\n");
  const ImportReport report = import(angles_mapping);
  EXPECT_EQ(report.files[0].imported, 2u);
  EXPECT_EQ(report.files[0].not_finite.count, 1u);
  const std::vector<Event> all = events();
  ASSERT_EQ(all.size(), 3u);  // lift-off first
  const auto& first = std::get<AngleTspi>(all[1]);
  EXPECT_EQ(first.sensor, Name("optical"));
  EXPECT_EQ(first.target, Name("rocket"));
  EXPECT_EQ(first.epoch, t0 + milliseconds(1500));
  EXPECT_EQ(first.received, t0 + milliseconds(1750));
  EXPECT_NEAR(first.azimuth_rad, 350 * std::numbers::pi / 180, 1e-15);
  EXPECT_NEAR(first.elevation_rad, 20 * std::numbers::pi / 180, 1e-15);
  EXPECT_EQ(first.mode, TrackMode::Track);
  EXPECT_EQ(std::get<AngleTspi>(all[2]).sequence, 3u);

  EXPECT_NE(refusal(replaced(angles_mapping, "field = \"elevation\"", "field = \"range\""))
                .find("'range' is no field of such a file; allowed: epoch, received, azimuth, elevation"),
            std::string::npos);
  EXPECT_NE(refusal(replaced(angles_mapping, "el_deg = {field = \"elevation\", unit = \"deg\"}", "el_deg = \"ignore\""))
                .find("only some of azimuth, elevation"),
            std::string::npos);
  EXPECT_NE(refusal(replaced(angles_mapping, "sensor = ", "station = ")).find("file[0].sensor: missing"),
            std::string::npos);
}

TEST(ImportMapping, TheExampleAndTheReferenceAreRight) {
  const ImportMapping mapping = load_mapping(DOWNRANGE_SOURCE_DIR "/tools/imports/example.toml");
  ASSERT_EQ(mapping.files.size(), 5u);
  EXPECT_EQ(mapping.leap_seconds, 18);
  EXPECT_EQ(mapping.files[0].decimal, DecimalMark::Comma);
  EXPECT_EQ(mapping.files[0].sort, true);
  EXPECT_EQ(mapping.files[1].delimiter, blanks);
  EXPECT_FALSE(mapping.files[1].header);
  EXPECT_EQ(mapping.files[2].scale, TimeScale::Gps);
  EXPECT_EQ(mapping.files[2].wrap, Duration{604'800'000'000'000});
  EXPECT_EQ(mapping.files[0].source_column->names.size(), 2u);
  EXPECT_EQ(mapping.files[3].fixed.size(), 4u);
  EXPECT_TRUE(mapping.files[4].nmea);
  const std::string reference = mapping_reference();
  for (const FieldInfo& field : all_fields()) EXPECT_NE(reference.find(field.name), std::string::npos) << field.name;
  for (const UnitInfo& unit : all_units()) EXPECT_NE(reference.find(unit.name), std::string::npos) << unit.name;
}

TEST_F(ArchiveImport, ACsvThatDoesNotFitIsRefused) {
  EXPECT_NE(refusal(radar_mapping).find("radar.csv: cannot open the file: no such file"), std::string::npos);
  write_text(folder_ / "radar.csv", "");
  EXPECT_NE(refusal(radar_mapping).find("radar.csv: no header line"), std::string::npos);
  write_text(folder_ / "radar.csv", "time_s,recv_s,range_km,az_deg,el_deg\n");
  EXPECT_NE(
      refusal(radar_mapping)
          .find("radar.csv:1: no column 'outlier'; the columns there are: time_s, recv_s, range_km, az_deg, el_deg"),
      std::string::npos);
  write_text(folder_ / "radar.csv", "time_s,recv_s,range_km,az_deg,el_deg,outlier,snr\n");
  EXPECT_NE(refusal(radar_mapping).find("radar.csv:1: column 'snr' is not in the mapping"), std::string::npos);
  EXPECT_FALSE(std::filesystem::exists(folder_ / "out.mcap")) << "nothing is written before all files are read";
}

/// The real flights: present where the range's shared folder is.
class SharedData : public ArchiveImport {
 protected:
  void SetUp() override {
    const char* folder = std::getenv("DOWNRANGE_SHARED");
    data_ = std::filesystem::path(folder != nullptr ? folder : DOWNRANGE_SOURCE_DIR "/../shared") / "data";
    if (!std::filesystem::exists(data_)) GTEST_SKIP() << data_ << " is not here";
  }
  ImportReport import_flight(const std::string& mapping, const std::string& name) {
    ImportOptions options;
    options.folder = data_ / name;
    options.writer.overwrite = true;
    return import_csv(std::filesystem::path(DOWNRANGE_SOURCE_DIR "/tools/imports") / mapping, folder_ / "out.mcap",
                      options);
  }
  /// Lines of a file less its header, counted here.
  std::uint64_t rows_of(const std::filesystem::path& path) {
    std::ifstream in(path);
    const auto lines = std::count(std::istreambuf_iterator<char>(in), {}, '\n');
    return static_cast<std::uint64_t>(lines) - 1;
  }
  std::filesystem::path data_;
};

TEST_F(SharedData, FalconFlightsImportWhole) {
  for (const std::string name : {"falcon9_crs11", "falcon_heavy_demo"}) {
    const ImportReport report = import_flight(name + ".toml", name);
    std::uint64_t rows = 0;
    for (const FileReport& file : report.files) {
      EXPECT_EQ(file.rows, rows_of(file.path)) << file.path;
      EXPECT_EQ(file.imported, file.rows) << file.path;
      rows += file.rows;
    }
    EXPECT_EQ(report.events + report.truths, rows + 1);
    EXPECT_EQ(report.archive.messages_written, rows + 1);

    EventSource source(folder_ / "out.mcap");
    std::uint64_t truths = 0;
    source.on_truth([&](const Truth&) { ++truths; });
    Time last{0};
    std::uint64_t events = 0;
    while (const auto event = source.next()) {
      EXPECT_GE(received_of(*event), last);
      last = received_of(*event);
      ++events;
    }
    EXPECT_EQ(events, report.events);
    EXPECT_EQ(truths, report.truths);
    EXPECT_FALSE(source.truncated());
  }
}

// The data's README: "its clock steps backwards six times, three fixes repeat".
TEST_F(SharedData, JunosClockStepsAndRepeatsAreReported) {
  const ImportReport report = import_flight("juno3.toml", "gnss_juno3");
  const FileReport& file = report.files.at(0);
  EXPECT_EQ(file.rows, 444u);
  EXPECT_EQ(file.imported, 444u);
  EXPECT_EQ(file.epoch_backwards.count, 6u);
  EXPECT_EQ(file.epoch_backwards.first.at(0).line, 4u);
  EXPECT_EQ(file.epoch_repeated.count, 3u);
  EXPECT_EQ(file.received_backwards.count, 0u);

  const auto all = events();
  const auto& apogee = *std::max_element(all.begin(), all.end(), [](const Event& a, const Event& b) {
    const auto height = [](const Event& e) {
      const auto* gps = std::get_if<GpsFix>(&e);
      return gps == nullptr ? -1e9 : geodetic_from_ecef(gps->position).height_m;
    };
    return height(a) < height(b);
  });
  // README.txt of the log: 3213 m above ground by the flight card's barometer, from a pad at 4583 ft. A tenth:
  // barometer against satellites; a wrong unit of height would be off by a factor of three.
  EXPECT_NEAR(geodetic_from_ecef(std::get<GpsFix>(apogee).position).height_m - 4583 * 0.3048, 3213, 321);
}

}  // namespace
}  // namespace downrange::archive
