/// What `downrange rotctld` answers, line by line, and when it has had enough of a client.
#include "rotctl/responder.hpp"

#include <gtest/gtest.h>

#include <numbers>

namespace downrange::rotctl {
namespace {

constexpr double deg = std::numbers::pi / 180;

class ResponderTest : public testing::Test {
 protected:
  std::string ask(std::string_view bytes) { return responder_.receive(bytes, up_); }

  std::optional<CommandedPointing> aim_ =
      CommandedPointing{.azimuth_rad = -200.25 * deg, .elevation_rad = 45.5 * deg, .tick = {}};
  const Told told_{.travel = {-270 * deg, 270 * deg, 0, 90 * deg}, .info = "Downrange", .aim = [this] { return aim_; }};
  Duration up_ = milliseconds(1'000);
  Responder responder_{told_, Patience{}, up_};
};

TEST_F(ResponderTest, TellsWhereTheAntennaIsCommandedToPoint) {
  EXPECT_EQ(ask("p\n"), "-200.2500\n45.5000\n");
  EXPECT_EQ(ask("\\get_pos\n"), "-200.2500\n45.5000\n");
  EXPECT_EQ(ask("  p \r\n"), "-200.2500\n45.5000\n");
  EXPECT_EQ(ask("p\np\n"), "-200.2500\n45.5000\n-200.2500\n45.5000\n");
}

TEST_F(ResponderTest, NeverWhereItPointedWhenNoCommandHolds) {
  aim_.reset();
  EXPECT_EQ(ask("p\n"), "RPRT -11\n");
}

TEST_F(ResponderTest, SaysWhatItIs) {
  EXPECT_EQ(
      ask("\\dump_state\n"),
      "1\n2\nmin_az=-270.000000\nmax_az=270.000000\nmin_el=0.000000\nmax_el=90.000000\nsouth_zero=0\nrot_type=AzEl\n"
      "done\n");
  EXPECT_EQ(ask("_\n"), "Downrange\n");
}

TEST_F(ResponderTest, MovesNothing) {
  for (const char* order : {"P 10 20\n", "\\set_pos 10.5 -20\n", "S\n", "\\stop\n", "K\n", "R 1\n", "M 2 10\n"})
    EXPECT_EQ(ask(order), "RPRT -11\n") << order;
}

TEST_F(ResponderTest, WhatIsNoCommandIsSaidToBeNone) {
  for (const char* wrong : {"x\n", "\\foo\n", "P abc def\n", "P 100\n", "P 1 2 3\n", "P nan 0\n", "p p\n", "pp\n",
                            "+p\n", "GET / HTTP/1.1\n", "\\\n", "\x80\xff\n"})
    EXPECT_EQ(ask(wrong), "RPRT -1\n") << wrong;
  EXPECT_EQ(ask(std::string("p\0\n", 3)), "RPRT -1\n");
  EXPECT_EQ(ask("\n  \n"), "");
  EXPECT_FALSE(responder_.closing(up_));
}

TEST_F(ResponderTest, QuitEnds) {
  EXPECT_EQ(ask("p\nq\np\n"), "-200.2500\n45.5000\n");
  EXPECT_TRUE(responder_.closing(up_));
}

TEST_F(ResponderTest, AnEndlessLineEnds) {
  EXPECT_EQ(ask(std::string(max_line, 'x')), "");
  EXPECT_FALSE(responder_.closing(up_));
  EXPECT_EQ(ask("x"), "RPRT -1\n");
  EXPECT_TRUE(responder_.closing(up_));
  EXPECT_EQ(ask("\np\n"), "");
}

TEST_F(ResponderTest, ASlowLineEnds) {
  up_ = milliseconds(50'000);
  EXPECT_EQ(ask("p"), "");
  EXPECT_EQ(responder_.deadline(), milliseconds(60'000));
  up_ = milliseconds(59'999);
  EXPECT_EQ(ask(" "), "");  // a byte now and then buys no time
  EXPECT_FALSE(responder_.closing(up_));
  EXPECT_TRUE(responder_.closing(milliseconds(60'000)));
}

TEST_F(ResponderTest, WholeLinesBuyTime) {
  for (int i = 0; i < 100; ++i) {
    up_ = up_ + milliseconds(300'000);
    EXPECT_FALSE(responder_.closing(up_));
    EXPECT_NE(ask("p\n"), "");
  }
  EXPECT_TRUE(responder_.closing(up_ + milliseconds(600'000)));
}

}  // namespace
}  // namespace downrange::rotctl
