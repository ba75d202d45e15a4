/// The conversation with a rotator daemon, without sockets: what is asked when, what is made of the answers.
#include "rotctl/link.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

namespace downrange::rotctl {
namespace {

constexpr double deg = std::numbers::pi / 180;
constexpr Time start{1'700'000'000'000'000'000};
constexpr const char* state =
    "1\n1\nmin_az=-180.000000\nmax_az=450.000000\nmin_el=0.000000\nmax_el=90.000000\nsouth_zero=0\nrot_type="
    "AzEl\ndone\n";

LinkSettings settings() {
  return {.antenna = "dish",
          .travel = {-180 * deg, 270 * deg, 0, 90 * deg},
          .link_delay = milliseconds(20),
          .lead = milliseconds(80),
          .rate_hz = 5,
          .timeout = milliseconds(2000)};
}

/// A rotator that answers when the test says so. Azimuth moves at 1 deg/s from 10 deg.
class LinkTest : public testing::Test {
 protected:
  Instant at(std::int64_t ms) const { return {start + milliseconds(ms), milliseconds(ms + 5'000)}; }
  Instant now() const { return at(ms_); }

  /// SLAVE's tick: applies 100 ms later, is valid for 200 ms more.
  void command() {
    SlavingCommand c;
    c.antenna = "dish";
    c.tick = now().utc;
    c.apply_at = c.tick + milliseconds(100);
    c.valid_until = c.apply_at + milliseconds(200);
    c.azimuth_rad = (10 + (c.apply_at - start).seconds()) * deg;
    c.elevation_rad = 45 * deg;
    c.azimuth_rate_rad_s = 1 * deg;
    ASSERT_TRUE(book_.take(c, now().utc));
  }
  /// Some milliseconds later; what is asked.
  std::string after(std::int64_t ms) {
    ms_ += ms;
    link_.step(book_, now());
    return link_.take_output();
  }
  std::string answer(std::string_view bytes) {
    link_.receive(bytes, now());
    link_.step(book_, now());
    return link_.take_output();
  }
  void connect() {
    link_.connected(book_, now());
    EXPECT_EQ(link_.take_output(), "\\dump_state\n");
    link_.receive(state, now());
    ASSERT_TRUE(link_.established()) << link_.fault();
    static_cast<void>(link_.take_notes());
  }
  /// Connected, and on its way by one command.
  void follow() {
    connect();
    command();
    ASSERT_EQ(after(0), "P 10.1000 45.0000\n");
    ASSERT_EQ(answer("RPRT 0\n"), "p\n");
    ASSERT_EQ(answer("9.50\n44.00\n"), "");
    static_cast<void>(link_.take_reports());
    static_cast<void>(link_.take_notes());
  }
  std::string notes() {
    std::string all;
    for (const std::string& text : link_.take_notes()) all += text + '\n';
    return all;
  }

  std::int64_t ms_ = 0;
  CommandBook book_{milliseconds(100)};
  Link link_{settings()};
};

TEST_F(LinkTest, TellsTheRotatorsTravelAndWhatDoesNotFit) {
  link_.connected(book_, now());
  link_.receive(state, now());
  EXPECT_EQ(notes(), "connected, rotator model 1: azimuth -180 to 450, elevation 0 to 90 deg\n");
  link_.connected(book_, now());
  link_.receive("0\n5\n0\n360\n0\n90\nRPRT 0\n", now());
  EXPECT_NE(notes().find("the configuration has more (azimuth -180 to 270"), std::string::npos);
}

TEST_F(LinkTest, ADaemonThatDoesNotTellItsTravelHasTheConfigurations) {
  link_.connected(book_, now());
  link_.receive("RPRT -1\n", now());
  EXPECT_TRUE(link_.established());
  EXPECT_NE(notes().find("does not tell its travel"), std::string::npos);
}

TEST_F(LinkTest, Protocol0EndsWhenNothingMoreComes) {
  link_.connected(book_, now());
  static_cast<void>(link_.take_output());
  link_.receive("0\n5\n0\n360\n0\n90\n", now());
  EXPECT_EQ(after(100), "");
  link_.receive("0\n", now());  // south_zero
  EXPECT_EQ(after(200), "");
  EXPECT_FALSE(link_.established());
  EXPECT_EQ(link_.due(book_, now()), now().up + milliseconds(50));
  EXPECT_EQ(after(50), "p\n");
  EXPECT_TRUE(link_.established());
}

TEST_F(LinkTest, SendsThePositionForTheInstantOfArrivalAtItsRate) {
  connect();
  std::string asked;
  for (int i = 0; i <= 24; ++i) {  // 600 ms of commands at 40 Hz, the first position 13 ms after a command
    if (i > 0) ms_ += 12;
    command();
    for (std::string line = after(13); !line.empty(); line = answer(line[0] == 'P' ? "RPRT 0\n" : "9\n9\n"))
      asked += line;
  }
  // Sent at 13, 213, 413 and 613 ms, for 100 ms later.
  EXPECT_EQ(asked, "P 10.1130 45.0000\np\nP 10.3130 45.0000\np\nP 10.5130 45.0000\np\nP 10.7130 45.0000\np\n");
}

TEST_F(LinkTest, AsksNothingTwiceOfASlowRotatorAndSendsItNothingOld) {
  connect();
  for (int i = 0; i < 40; ++i) {
    command();
    const std::string asked = after(25);
    EXPECT_EQ(asked, i == 0 ? "P 10.1250 45.0000\n" : "");
  }
  EXPECT_EQ(answer("RPRT 0\n"), "p\n");
  EXPECT_EQ(answer("9\n9\n"), "P 11.1000 45.0000\n");  // of now, a second later
  EXPECT_EQ(link_.counts().positions, 2u);
}

TEST_F(LinkTest, NothingExpiredIsSent) {
  connect();
  command();
  EXPECT_EQ(after(201), "p\n");  // would arrive at 301 ms: valid until 300 ms
  EXPECT_EQ(link_.counts().positions, 0u);
}

TEST_F(LinkTest, StopsWhenCommandsEnd) {
  follow();
  EXPECT_EQ(link_.due(book_, now()), at(200).up);
  EXPECT_EQ(after(200), "P 10.3000 45.0000\n");
  EXPECT_EQ(answer("RPRT 0\n"), "p\n");
  EXPECT_EQ(answer("9.50\n44.00\n"), "");
  // 20 ms on the way: it is there when the command expires.
  EXPECT_EQ(link_.due(book_, now()), at(280).up);
  EXPECT_EQ(after(79), "");
  EXPECT_EQ(after(1), "S\n");
  EXPECT_EQ(answer("RPRT 0\n"), "");
  EXPECT_FALSE(link_.moving());
  EXPECT_EQ(notes(), "stopped: there is no command to follow\n");
  EXPECT_EQ(after(120), "p\n");  // goes on telling where it points
  EXPECT_EQ(answer("9.50\n44.00\n"), "");
  EXPECT_EQ(link_.take_reports().back().mode, AntennaMode::Manual);
  EXPECT_EQ(after(200), "p\n");
  EXPECT_EQ(link_.counts().stops, 1u);
}

TEST_F(LinkTest, AStopWaitsForNoAnswer) {
  connect();
  command();
  EXPECT_EQ(after(0), "P 10.1000 45.0000\n");
  EXPECT_EQ(link_.due(book_, now()), at(280).up);
  EXPECT_EQ(after(280), "S\n");
  EXPECT_EQ(answer("RPRT 0\n"), "");  // of the position
  EXPECT_TRUE(link_.moving());
  EXPECT_EQ(answer("RPRT 0\n"), "p\n");
  EXPECT_FALSE(link_.moving());
  static_cast<void>(answer("9\n9\n"));
  const auto reports = link_.take_reports();
  ASSERT_EQ(reports.size(), 1u);
  EXPECT_EQ(reports[0].mode, AntennaMode::Manual);
}

TEST_F(LinkTest, AStopThatIsRefusedIsTriedAgain) {
  follow();
  EXPECT_EQ(after(290), "S\n");
  EXPECT_EQ(answer("RPRT -5\n"), "p\n");
  EXPECT_NE(notes().find("refuses to stop: RPRT -5, the rotator does not answer"), std::string::npos);
  EXPECT_EQ(answer("9\n9\n"), "");
  EXPECT_EQ(after(199), "p\n");
  EXPECT_EQ(answer("9\n9\n"), "");
  EXPECT_EQ(after(1), "S\n");
  EXPECT_TRUE(link_.moving());
}

TEST_F(LinkTest, AfterAnOutageTheStopComesFirst) {
  follow();
  link_.disconnected();
  ms_ += 3000;
  link_.connected(book_, now());
  EXPECT_EQ(link_.take_output(), "S\n\\dump_state\n");
  link_.receive("RPRT 0\n" + std::string(state), now());
  EXPECT_TRUE(link_.established());
  EXPECT_FALSE(link_.moving());
}

TEST_F(LinkTest, AfterAnOutageOfANetworkOnlyItFollowsAgain) {
  follow();
  link_.disconnected();
  ms_ += 3000;
  command();
  link_.connected(book_, now());
  EXPECT_EQ(link_.take_output(), "\\dump_state\n");
  EXPECT_EQ(answer(state), "P 13.1000 45.0000\n");
}

TEST_F(LinkTest, WhatNeverMovedIsNotStopped) {
  connect();
  EXPECT_EQ(after(0), "p\n");
  EXPECT_EQ(answer("9\n9\n"), "");
  link_.stop(now());
  EXPECT_EQ(link_.take_output(), "");
  EXPECT_EQ(link_.counts().stops, 0u);
}

TEST_F(LinkTest, StopsAtTheEnd) {
  follow();
  link_.stop(now());
  link_.stop(now());
  EXPECT_EQ(link_.take_output(), "S\n");
  link_.receive("RPRT 0\n", now());
  EXPECT_FALSE(link_.moving());
  EXPECT_EQ(notes(), "stopped\n");
}

TEST_F(LinkTest, ReportsWhatIsMeasuredInTheCommandsTurn) {
  connect();
  SlavingCommand c;
  c.tick = start;
  c.apply_at = start + milliseconds(100);
  c.valid_until = start + milliseconds(300);
  c.azimuth_rad = -200 * deg;  // the rotator begins at -180: it goes to 160
  c.elevation_rad = 45 * deg;
  ASSERT_TRUE(book_.take(c, now().utc));
  EXPECT_EQ(after(0), "P 160.0000 45.0000\n");
  ms_ = 40;
  EXPECT_EQ(answer("RPRT 0\n"), "p\n");
  ms_ = 50;
  EXPECT_EQ(answer("159.5\n"), "");
  ms_ = 60;
  EXPECT_EQ(answer("44.25\n"), "");
  const auto reports = link_.take_reports();
  ASSERT_EQ(reports.size(), 1u);
  EXPECT_EQ(reports[0].antenna.view(), "dish");
  EXPECT_EQ(reports[0].sequence, 1u);
  EXPECT_EQ(reports[0].epoch, at(50).utc);  // asked at 40 ms, told at 60 ms
  EXPECT_NEAR(reports[0].azimuth_rad / deg, -200.5, 1e-9);
  EXPECT_NEAR(reports[0].elevation_rad / deg, 44.25, 1e-9);
  EXPECT_EQ(reports[0].mode, AntennaMode::Slaved);
  EXPECT_EQ(reports[0].command_tick, start);
  EXPECT_FALSE(reports[0].simulated);
}

TEST_F(LinkTest, ARefusedPositionIsSaidOnceAndIsNotFollowed) {
  connect();
  for (int i = 0; i < 3; ++i) {
    ms_ += 200;
    command();
    ASSERT_NE(after(0), "");
    EXPECT_EQ(answer("RPRT -9\n"), "p\n");
    static_cast<void>(answer("9\n9\n"));
  }
  EXPECT_EQ(notes(), "the rotator refuses a position: RPRT -9, rejected by the rotator\n");
  EXPECT_EQ(link_.counts().refused, 3u);
  for (const AntennaReport& report : link_.take_reports()) {
    EXPECT_EQ(report.mode, AntennaMode::Manual);
    EXPECT_EQ(report.command_tick, Time{});
  }
  ms_ += 200;
  command();
  ASSERT_NE(after(0), "");
  EXPECT_EQ(answer("RPRT 0\n"), "p\n");
  EXPECT_EQ(notes(), "follows its commands\n");
}

TEST_F(LinkTest, ARotatorWithoutEncodersIsMovedAllTheSame) {
  connect();
  command();
  static_cast<void>(after(0));
  EXPECT_EQ(answer("RPRT 0\n"), "p\n");
  EXPECT_EQ(answer("RPRT -11\n"), "");
  EXPECT_EQ(link_.fault(), "");
  EXPECT_TRUE(link_.take_reports().empty());
  EXPECT_NE(notes().find("does not tell where it points: RPRT -11, not available"), std::string::npos);
  EXPECT_EQ(after(200), "P 10.3000 45.0000\n");
}

TEST_F(LinkTest, AnAnswerTooLateEndsTheConnection) {
  follow();
  EXPECT_EQ(after(200), "P 10.3000 45.0000\n");
  EXPECT_EQ(link_.due(book_, now()), at(280).up);
  EXPECT_EQ(after(100), "S\n");
  EXPECT_EQ(after(1899), "");
  EXPECT_EQ(link_.fault(), "");
  EXPECT_EQ(after(1), "");
  EXPECT_EQ(link_.fault(), "no answer to P within 2 s");
  EXPECT_EQ(after(1000), "");
}

TEST_F(LinkTest, GarbageEndsTheConnection) {
  struct Case {
    const char* bytes;
    const char* why;
  };
  for (const Case& c :
       {Case{"nonsense\n", "no answer to P: found 'nonsense'"}, Case{"12.5\n", "no answer to P: found '12.5'"},
        Case{"\x1b[2J\n", "no answer to P: found '\\x1b[2J'"},
        Case{"RPRT 0\nRPRT 0\n", "an answer that nobody asked for: found 'RPRT 0'"}}) {
    connect();
    command();
    ASSERT_EQ(after(0).substr(0, 2), "P ") << c.why;
    link_.receive(c.bytes, now());
    EXPECT_EQ(link_.fault(), c.why);
    // What it may have moved is stopped by the next connection.
    link_.disconnected();
    ms_ += 300;
    link_.connected(book_, now());
    link_.receive("RPRT 0\n", now());
    EXPECT_FALSE(link_.moving());
    EXPECT_EQ(link_.take_output(), "S\n\\dump_state\n");
    link_.disconnected();
  }
  for (const char* wrong : {"nan\n", "9\ninf\n", "9\nRPRT 0\n", "9\n1e9\n"}) {
    connect();
    ASSERT_EQ(after(0), "p\n");
    link_.receive(wrong, now());
    EXPECT_EQ(link_.fault().substr(0, 21), "no answer to p: found") << wrong;
    EXPECT_TRUE(link_.take_reports().empty());
    link_.disconnected();
    ms_ += 300;
  }
}

TEST_F(LinkTest, ALineWithoutEndEndsTheConnection) {
  connect();
  link_.receive(std::string(100'000, '1'), now());
  EXPECT_EQ(link_.fault(), "a line without end: this is no rotctld");
}

TEST_F(LinkTest, ClocksThatDifferAreSaid) {
  connect();
  SlavingCommand c;
  c.apply_at = start + milliseconds(5'000);
  c.valid_until = c.apply_at + milliseconds(200);
  EXPECT_FALSE(book_.take(c, now().utc));
  c.apply_at = start - milliseconds(5'000);
  c.valid_until = c.apply_at + milliseconds(200);
  EXPECT_FALSE(book_.take(c, now().utc));
  static_cast<void>(after(0));
  const std::string said = notes();
  EXPECT_NE(said.find("too far ahead"), std::string::npos);
  EXPECT_NE(said.find("have expired when they come"), std::string::npos);
  static_cast<void>(after(10));
  EXPECT_EQ(notes(), "");
}

}  // namespace
}  // namespace downrange::rotctl
