/// Files that are wrong: each problem is named, at its line, and nothing else happens.
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <string>

#include "config_testing.hpp"

namespace downrange::config {
namespace {

using namespace test;

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
  EXPECT_EQ(joined(problems_of(text + radar(64))), "test.toml:7: radar: found 65 radars, allowed: at most 64\n");
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
