/// Whatever can be wrong with the profiles and the domain is told at start, in one line. Domain 52.

#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <iterator>
#include <source_dir.hpp>

#include "dds/inputs.hpp"
#include "dds/participant.hpp"
#include "dds/range_clock.hpp"
#include "dds_samples.hpp"

namespace downrange::dds {
namespace {

constexpr int domain = 52;

std::string profiles_text() {
  std::ifstream file(std::string(DOWNRANGE_SOURCE_DIR) + "/config/dds-qos.xml");
  return {std::istreambuf_iterator<char>(file), {}};
}

/// The first `from` in the profiles replaced by `to`; written to a file that lives as long as this.
class BrokenProfiles {
 public:
  BrokenProfiles(const std::string& from, const std::string& to) : BrokenProfiles(replaced(from, to)) {}
  explicit BrokenProfiles(const std::string& text) {
    std::string name = std::filesystem::temp_directory_path() / "dds_start_test.XXXXXX";
    const int fd = ::mkstemp(name.data());
    EXPECT_GE(fd, 0);
    ::close(fd);
    path = name;
    std::ofstream(path) << text;
  }
  ~BrokenProfiles() { std::filesystem::remove(path); }
  BrokenProfiles(const BrokenProfiles&) = delete;
  BrokenProfiles& operator=(const BrokenProfiles&) = delete;
  std::filesystem::path path;

 private:
  static std::string replaced(const std::string& from, const std::string& to) {
    std::string text = profiles_text();
    const std::size_t at = text.find(from);
    EXPECT_NE(at, std::string::npos) << from;
    return text.replace(at, from.size(), to);
  }
};

/// What the participant says when it is opened with these; empty: it opens.
std::string error_of(int in_domain, const std::filesystem::path& profiles) {
  try {
    Participant participant({in_domain, profiles, "node", ClockMode::Wall});
    return {};
  } catch (const DdsError& error) {
    return error.what();
  }
}

TEST(DdsStart, GoodProfilesOpenAndSoDoTheBuiltInOnes) {
  EXPECT_EQ(error_of(domain, std::string(DOWNRANGE_SOURCE_DIR) + "/config/dds-qos.xml"), "");
  EXPECT_EQ(error_of(domain, {}), "");
}

TEST(DdsStart, MissingFile) {
  EXPECT_EQ(error_of(domain, "/nonexistent/qos.xml"), "DDS profiles /nonexistent/qos.xml: cannot be read");
  EXPECT_NE(error_of(domain, std::filesystem::temp_directory_path()), "") << "a directory is no file";
}

TEST(DdsStart, BrokenXml) {
  for (const std::string& text : {std::string(), std::string("no xml at all"), profiles_text().substr(0, 3000)}) {
    const BrokenProfiles broken(text);
    const std::string error = error_of(domain, broken.path);
    EXPECT_TRUE(error.starts_with("DDS profiles " + broken.path.string() + ": ")) << error;
  }
}

TEST(DdsStart, AnElementThatTheMiddlewareDoesNotKnow) {
  const BrokenProfiles broken("<ownership><kind>EXCLUSIVE</kind></ownership>",
                              "<ownershop><kind>EXCLUSIVE</kind></ownershop>");
  const std::string error = error_of(domain, broken.path);
  EXPECT_NE(error.find("ownershop"), std::string::npos) << error;
}

TEST(DdsStart, AValueThatTheMiddlewareDoesNotKnow) {
  const BrokenProfiles broken("<kind>RELIABLE</kind>", "<kind>DEPENDABLE</kind>");
  EXPECT_NE(error_of(domain, broken.path), "");
}

TEST(DdsStart, MissingProfilesAreNamed) {
  const BrokenProfiles writer("<data_writer profile_name=\"mark\">", "<data_writer profile_name=\"other\">");
  EXPECT_EQ(error_of(domain, writer.path),
            "DDS profiles " + writer.path.string() +
                ": missing profile: data_writer range/mission or mark, data_writer range/operator or mark");
  const BrokenProfiles reader("<data_reader profile_name=\"stream\">", "<data_reader profile_name=\"range/gps\">");
  const std::string error = error_of(domain, reader.path);
  EXPECT_NE(error.find("data_reader range/radar_tspi or stream"), std::string::npos) << error;
  EXPECT_EQ(error.find("range/gps"), std::string::npos) << "has a profile of its own: " << error;
  const BrokenProfiles participant("<participant profile_name=\"downrange\">", "<participant profile_name=\"x\">");
  EXPECT_EQ(error_of(domain, participant.path),
            "DDS profiles " + participant.path.string() + ": no participant profile 'downrange'");
}

TEST(DdsStart, InconsistentLimitsAreRefusedWithTheTopic) {
  const BrokenProfiles broken("<max_samples>262144</max_samples>", "<max_samples>10</max_samples>");
  Participant participant({domain, broken.path, "node", ClockMode::Wall});
  try {
    InputWriters writers(participant);
    FAIL() << "10 samples cannot hold 256 instances of 1024";
  } catch (const DdsError& error) {
    EXPECT_TRUE(std::string(error.what()).starts_with("DDS writer of range/radar_tspi refused: ")) << error.what();
  }
}

TEST(DdsStart, DomainsThatDoNotExist) {
  EXPECT_EQ(error_of(233, {}), "DDS domain 233: must be 0 to 232");
  EXPECT_EQ(error_of(1000, {}), "DDS domain 1000: must be 0 to 232");
  EXPECT_EQ(error_of(-1, {}), "DDS domain -1: must be 0 to 232");
}

TEST(DdsStart, ADriverAndAFollowerNeedTheRangeClock) {
  Participant participant({domain, {}, "node", ClockMode::Wall});
  EXPECT_THROW(RangeClockDriver(participant, {{"node"}}), LockstepError);
  EXPECT_THROW(RangeClockFollower(participant, {}, nullptr), LockstepError);
}

}  // namespace
}  // namespace downrange::dds
