#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <numbers>
#include <sstream>
#include <string>

#include "config/load.hpp"

namespace downrange::config {
namespace {

const std::filesystem::path source_dir = DOWNRANGE_SOURCE_DIR;
const std::filesystem::path naro = source_dir / "config/naro.toml";
constexpr double degree = std::numbers::pi / 180;

std::string read(const std::filesystem::path& file) {
  std::ostringstream text;
  text << std::ifstream(file, std::ios::binary).rdbuf();
  return text.str();
}

std::string joined(const std::vector<Problem>& problems) {
  std::string text;
  for (const Problem& problem : problems) text += problem.to_string() + '\n';
  return text;
}

std::vector<Problem> problems_of(std::string_view text, const Overrides& overrides = {}) {
  try {
    static_cast<void>(load_text(text, "test.toml", overrides));
    return {};
  } catch (const ConfigError& error) {
    return error.problems();
  }
}

TEST(Naro, IsValid) { EXPECT_EQ(joined(check(naro)), ""); }

TEST(Naro, RadarsAreExact) {
  const RangeConfig range = load(naro).range;
  EXPECT_EQ(range.name.view(), "naro");
  ASSERT_EQ(range.radars.size(), 2u);
  const RadarConfig& goheung = range.radars[0];
  EXPECT_EQ(goheung.id.view(), "goheung");
  EXPECT_EQ(goheung.site.geodetic().latitude_rad, 34.4450 * degree);
  EXPECT_EQ(goheung.site.geodetic().longitude_rad, 127.5200 * degree);
  EXPECT_EQ(goheung.site.geodetic().height_m, 120);
  EXPECT_EQ(goheung.rate_hz, 10);
  const RadarConfig& jeju = range.radars[1];
  EXPECT_EQ(jeju.id.view(), "jeju");
  EXPECT_EQ(jeju.site.geodetic().latitude_rad, 33.2900 * degree);
  EXPECT_EQ(jeju.site.geodetic().longitude_rad, 126.4600 * degree);
  EXPECT_EQ(jeju.site.geodetic().height_m, 350);
  EXPECT_EQ(jeju.rate_hz, 20);
  for (const RadarConfig& radar : range.radars) {
    EXPECT_EQ(radar.sigma.range_m, 25);
    EXPECT_EQ(radar.sigma.azimuth_rad, 0.01 * degree);
    EXPECT_EQ(radar.sigma.elevation_rad, 0.01 * degree);
    EXPECT_EQ(radar.elevation_max_rad, 90 * degree);
  }
}

TEST(Naro, StationsAndAntennasAreExact) {
  const RangeConfig range = load(naro).range;
  ASSERT_EQ(range.targets.size(), 1u);
  EXPECT_EQ(range.targets[0].id.view(), "kslv");
  ASSERT_EQ(range.telemetry.size(), 3u);
  EXPECT_EQ(range.telemetry[2].id.view(), "ship-tgs");
  EXPECT_EQ(range.telemetry[2].site.geodetic().latitude_rad, 14 * degree);
  ASSERT_EQ(range.antennas.size(), 4u);
  const AntennaConfig& ship = range.antennas[2];
  EXPECT_EQ(ship.id.view(), "ship-tm");
  EXPECT_EQ(ship.azimuth_min_rad, -360 * degree);
  EXPECT_EQ(ship.elevation_min_rad, -2 * degree);
  EXPECT_EQ(ship.azimuth_rate_max_rad_s, 12 * degree);
  EXPECT_EQ(ship.link_delay, milliseconds(600));
  EXPECT_EQ(ship.lead, milliseconds(80));
  for (const AntennaConfig& antenna : range.antennas) {
    for (const RadarConfig& radar : range.radars) EXPECT_GT((antenna.site.ecef() - radar.site.ecef()).m.norm(), 100);
  }
}

TEST(Naro, ServiceIsExact) {
  const ServiceConfig config = load(naro);
  EXPECT_EQ(config.range.tick, milliseconds(25));
  EXPECT_EQ(config.range.gps.sigma_horizontal_m, 5);
  EXPECT_EQ(config.range.gps.sigma_vertical_m, 8);
  EXPECT_EQ(config.range.fuse.methods, (std::vector<Name>{"song2015", "uncorrected"}));
  EXPECT_EQ(config.range.fuse.history, milliseconds(5000));
  EXPECT_FALSE(config.range.ingest.expect_simulated);
  EXPECT_EQ(config.clock.mode, ClockMode::Wall);
  EXPECT_EQ(config.dds.profiles, source_dir / "config/dds-qos.xml");
  EXPECT_EQ(config.archive.directory, source_dir / "config/archive");
  EXPECT_TRUE(config.log.file.empty());
}

// Keys marked "(default)" say what the structs say: leaving them all out changes nothing.
TEST(Naro, StatedDefaultsAreTheDefaults) {
  std::istringstream lines(read(naro));
  std::string reduced;
  for (std::string line; std::getline(lines, line);) {
    if (line.find("(default)") == std::string::npos) reduced += line + '\n';
  }
  ASSERT_LT(reduced.size(), read(naro).size() - 1000);
  const std::vector<std::string> changed = differences(load_text(reduced, naro), load(naro));
  for (const std::string& key : changed) ADD_FAILURE() << key;
}

TEST(Naro, NamesEveryKeyOfTheReference) {
  const std::string text = read(naro);
  std::istringstream lines(key_reference());
  int keys = 0;
  for (std::string line; std::getline(lines, line);) {
    const std::size_t colon = line.find(':');
    if (!line.starts_with("  ") || line.starts_with("   ") || colon == std::string::npos) continue;
    const std::string key = line.substr(2, colon - 2);
    EXPECT_NE(text.find('\n' + key + " = "), std::string::npos) << key;
    ++keys;
  }
  EXPECT_GT(keys, 60);
}

TEST(Hash, ChangesWithTheTextAndIsSha256) {
  const ServiceConfig config = load(naro);
  EXPECT_EQ(config.text, read(naro));
  EXPECT_EQ(config.hash.size(), 64u);
  EXPECT_EQ(config.hash, load(naro).hash);
  EXPECT_NE(config.hash, load_text(config.text + "# one more line\n", naro).hash);
}

TEST(Override, ReplacesTheFilesValueAndLoadsAgain) {
  const Overrides overrides{{"clock.mode", "range", "--clock"},
                            {"dds.domain", "7", "--domain"},
                            {"node.id", "42", "--node"},
                            {"node.stages", R"(["align", "fuse", "slave"])", "--stages"},
                            {"dds.ingest_nodes", R"(["site-a"])", "--set"},
                            {"log.level", "\"debug\"", "--log-level"},
                            {"ingest.expect_simulated", "true", "--set"}};
  const ServiceConfig config = load(naro, overrides);
  EXPECT_EQ(config.clock.mode, ClockMode::Range);
  EXPECT_EQ(config.dds.domain, 7);
  EXPECT_EQ(config.node.id.view(), "42");
  EXPECT_FALSE(config.node.stages.ingest);
  EXPECT_TRUE(config.node.stages.slave);
  EXPECT_EQ(config.log.level, LogLevel::Debug);
  EXPECT_TRUE(config.range.ingest.expect_simulated);
  EXPECT_NE(config.hash, load(naro).hash);

  const ServiceConfig again = load_text(config.text, naro);
  EXPECT_EQ(differences(config, again), std::vector<std::string>{});
  for (std::size_t i = 0; i < config.range.radars.size(); ++i) {
    EXPECT_EQ(config.range.radars[i].site.ecef().m, again.range.radars[i].site.ecef().m);
  }
}

TEST(Override, ProblemsNameTheOption) {
  const std::string text = read(naro);
  EXPECT_EQ(joined(problems_of(text, {{"dds.domain", "300", "--domain"}})),
            "--domain: dds.domain: found 300 (whole number), allowed: a whole number from 0 to 232\n");
  EXPECT_EQ(joined(problems_of(text, {{"dds.domain", "4]", "--domain"}})),
            "--domain: dds.domain: found 4], allowed: a whole number from 0 to 232\n");
  EXPECT_EQ(joined(problems_of(text, {{"clock.mod", "range", "--set"}})),
            "--set: clock.mod: unknown key, did you mean clock.mode?\n");
  EXPECT_EQ(joined(problems_of(text, {{"dds.domain", "4\ndomain2 = 5", "--set"}})),
            "--set: dds.domain: found 4\ndomain2 = 5, allowed: a whole number from 0 to 232\n");
}

TEST(Differences, NameTheKeys) {
  const ServiceConfig a = load(naro);
  ServiceConfig b = a;
  b.log.level = LogLevel::Debug;
  b.range.radars[1].sigma.range_m = 24;
  EXPECT_EQ(differences(a, b), (std::vector<std::string>{"radar[1].sigma_range_m", "log.level"}));
  b.range.antennas.pop_back();
  EXPECT_EQ(differences(a, b), (std::vector<std::string>{"radar[1].sigma_range_m", "antenna", "log.level"}));
}

TEST(File, MissingOrNoFile) {
  EXPECT_EQ(joined(check("/no/such/range.toml")), "/no/such/range.toml: no such file\n");
  EXPECT_EQ(joined(check(source_dir)), source_dir.string() + ": is a folder, not a file\n");
  EXPECT_EQ(check("/dev/zero").size(), 1u);
}

TEST(File, TooManyRadars) {
  std::string text = "[range]\nname = \"many\"\n[dds]\nprofiles = \"p.xml\"\n[[target]]\nid = \"t\"\n";
  const auto radar = [](int i) {
    return "[[radar]]\nid = \"r" + std::to_string(i) +
           "\"\nlatitude_deg = 1\nlongitude_deg = 2\nheight_m = 3\nsigma_range_m = 4\nsigma_azimuth_deg = 0.1\n"
           "sigma_elevation_deg = 0.1\n";
  };
  for (int i = 0; i < 64; ++i) text += radar(i);
  EXPECT_EQ(joined(problems_of(text)), "");
  EXPECT_EQ(joined(problems_of(text + radar(64))), "test.toml:7: radar: found 65 radars, allowed: 1 to 64\n");
}

struct Expectation {
  std::string text;
  int line;
};

std::vector<Expectation> expectations(const std::filesystem::path& file) {
  std::vector<Expectation> expected;
  std::ifstream stream(file);
  const std::string head = "# expect: ";
  const std::string at = " @ line ";
  for (std::string line; std::getline(stream, line) && line.starts_with(head);) {
    const std::size_t split = line.rfind(at);
    expected.push_back({line.substr(head.size(), split - head.size()), std::stoi(line.substr(split + at.size()))});
  }
  return expected;
}

// Each bad file says on its first lines which problems it has: these, at these lines, and no others.
TEST(Bad, EveryFileIsRejectedForItsReason) {
  int files = 0;
  for (const auto& entry : std::filesystem::directory_iterator(source_dir / "tests/fault/config_bad")) {
    if (entry.path().extension() != ".toml") continue;
    SCOPED_TRACE(entry.path().filename());
    ++files;
    const std::vector<Expectation> expected = expectations(entry.path());
    const std::vector<Problem> problems = check(entry.path());
    ASSERT_FALSE(expected.empty());
    EXPECT_EQ(problems.size(), expected.size()) << joined(problems);
    for (const Expectation& e : expected) {
      const bool found = std::any_of(problems.begin(), problems.end(), [&](const Problem& p) {
        return p.line == e.line && p.to_string().find(e.text) != std::string::npos;
      });
      EXPECT_TRUE(found) << "expected " << e.text << " @ line " << e.line << ", got\n" << joined(problems);
    }
    for (const Problem& p : problems)
      EXPECT_NE(p.to_string().find(entry.path().filename().string()), std::string::npos);
  }
  EXPECT_GE(files, 20);
}

// A file cut off anywhere is valid or has problems with lines inside of it; nothing else happens.
TEST(Damaged, TruncatedAnywhere) {
  const std::string text = read(naro);
  for (std::size_t size = 0; size <= text.size(); size += 7) {
    for (const Problem& problem : problems_of(std::string_view(text).substr(0, size))) {
      EXPECT_FALSE(problem.message.empty());
      EXPECT_LE(problem.line, std::count(text.begin(), text.begin() + static_cast<std::ptrdiff_t>(size), '\n') + 1);
    }
  }
}

TEST(Damaged, AnyByteReplaced) {
  const std::string text = read(naro);
  for (const char byte : {'\0', '"', '[', '\n', '=', '\xff', '-', '9'}) {
    for (std::size_t i = 0; i < text.size(); i += 61) {
      std::string damaged = text;
      damaged[i] = byte;
      for (const Problem& problem : problems_of(damaged)) EXPECT_FALSE(problem.message.empty());
    }
  }
}

}  // namespace
}  // namespace downrange::config
