/// [antenna.rotctl]: a table of its own under an entry of a list.
#include <gtest/gtest.h>

#include <sstream>

#include "config_testing.hpp"

namespace downrange::config {
namespace {

using namespace test;

const char* const base = R"([range]
name = "small"
[[target]]
id = "t"
[[telemetry]]
id = "s"
latitude_deg = 1
longitude_deg = 2
height_m = 3
)";

std::string antenna(const std::string& id, const std::string& more = "") {
  return "[[antenna]]\nid = \"" + id +
         "\"\nlatitude_deg = 1\nlongitude_deg = 2\nheight_m = 3\nlink_delay_ms = 5\nlead_ms = 50\n" + more;
}

TEST(Rotctl, BelongsToTheAntennaAboveIt) {
  const ServiceConfig config =
      load_text(base + antenna("a") + antenna("b", "[antenna.rotctl]\nport = 4534\nrate_hz = 2\n") +
                    antenna("c", "[antenna.rotctl]\nhost = \"::1\"\ntimeout_ms = 500\n"),
                "test.toml");
  ASSERT_EQ(config.rotctl.size(), 2u);
  EXPECT_EQ(config.rotctl[0].antenna.view(), "b");
  EXPECT_EQ(config.rotctl[0].host, "127.0.0.1");
  EXPECT_EQ(config.rotctl[0].port, 4534);
  EXPECT_EQ(config.rotctl[0].rate_hz, 2);
  EXPECT_EQ(config.rotctl[0].timeout, milliseconds(2000));
  EXPECT_EQ(config.rotctl[1].antenna.view(), "c");
  EXPECT_EQ(config.rotctl[1].host, "::1");
  EXPECT_EQ(config.rotctl[1].timeout, milliseconds(500));
}

TEST(Rotctl, TheExampleIsCompleteAndSaysTheDefaults) {
  std::istringstream lines(read(naro));
  std::string text;
  bool example = false;
  for (std::string line; std::getline(lines, line);) {
    example = (example || line == "# [antenna.rotctl]") && line.starts_with("# ");
    text += (example ? line.substr(2) : line) + '\n';
  }
  EXPECT_EQ(joined(problems_of(text)), "");
  const ServiceConfig config = load_text(text, naro);
  ASSERT_EQ(config.rotctl.size(), 1u);
  EXPECT_EQ(config.rotctl[0].antenna.view(), "goheung-tm");
  const std::string reference = key_reference();
  const std::size_t begin = reference.find("[antenna.rotctl]");
  ASSERT_NE(begin, std::string::npos);
  EXPECT_NE(reference[begin - 1], '[');  // of one antenna there is one
  std::istringstream keys(reference.substr(begin, reference.find("\n\n", begin) - begin));
  int count = 0;
  for (std::string line; std::getline(keys, line);) {
    const std::size_t colon = line.find(':');
    if (!line.starts_with("  ") || line.starts_with("   ") || colon == std::string::npos) continue;
    EXPECT_NE(text.find('\n' + line.substr(2, colon - 2) + " = ", text.find("[antenna.rotctl]")), std::string::npos);
    ++count;
  }
  EXPECT_EQ(count, 4);
  // Without what the example says it is the same.
  EXPECT_EQ(differences(config, load_text(read(naro) + "", naro)), (std::vector<std::string>{"antenna.rotctl"}));
}

TEST(Rotctl, ChangesAreToldByTheAntennasPath) {
  const auto with_port = [](const char* port) {
    return load_text(base + antenna("a") + antenna("b", std::string("[antenna.rotctl]\nport = ") + port + '\n'),
                     "test.toml");
  };
  EXPECT_EQ(differences(with_port("1"), with_port("2")), (std::vector<std::string>{"antenna[1].rotctl.port"}));
}

TEST(Rotctl, ProblemsNameTheKey) {
  const auto problem_of = [&](const std::string& more) {
    const std::vector<Problem> problems = problems_of(base + antenna("a") + antenna("b", more));
    if (problems.size() != 1) return std::to_string(problems.size()) + " problems: " + joined(problems);
    return problems[0].key + ": " + problems[0].message;
  };
  EXPECT_EQ(problem_of("[antenna.rotctl]\nhosts = \"x\"\n"),
            "antenna[1].rotctl.hosts: unknown key, did you mean host?");
  EXPECT_EQ(problem_of("[antenna.rotctl]\nport = 0\n"),
            "antenna[1].rotctl.port: found 0 (whole number), allowed: a whole number from 1 to 65535");
  EXPECT_EQ(problem_of("[antenna.rotctl]\nhost = \"a b\"\n"),
            "antenna[1].rotctl.host: found \"a b\" (text), allowed: the name or address of a machine, as text");
  EXPECT_EQ(problem_of("[antenna.rotctl]\nhost = \"\"\n").substr(0, 32), "antenna[1].rotctl.host: found \"\"");
  EXPECT_EQ(problem_of("[antenna.rotctl]\nrate_hz = 0\n").substr(0, 33), "antenna[1].rotctl.rate_hz: found ");
  EXPECT_EQ(problem_of("[antenna.rotctl]\nantenna = \"a\"\n").substr(0, 38), "antenna[1].rotctl.antenna: unknown key");
  EXPECT_EQ(problem_of("rotctl = 3\n"),
            "antenna[1].rotctl: found 3 (whole number), allowed: one table headed [antenna.rotctl]");
  EXPECT_EQ(problem_of("rotctld = 3\n"), "antenna[1].rotctld: unknown key, did you mean rotctl?");
  EXPECT_EQ(problem_of("[[antenna.rotctl]]\nport = 1\n").substr(0, 24), "antenna[1].rotctl: found");
}

TEST(Rotctl, ARotatorTurnsOneAntenna) {
  const std::string rotctl = "[antenna.rotctl]\nhost = \"tower\"\n";
  EXPECT_EQ(joined(problems_of(base + antenna("a", rotctl) + antenna("b", rotctl))),
            "test.toml:26: antenna[1].rotctl.port: found 4533 of \"tower\", already used by antenna[0].rotctl\n");
  EXPECT_EQ(joined(problems_of(base + antenna("a", rotctl) + antenna("b", rotctl + "port = 4534\n"))), "");
}

}  // namespace
}  // namespace downrange::config
