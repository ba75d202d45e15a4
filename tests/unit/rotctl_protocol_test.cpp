/// Lines of the Hamlib protocol. The replies are those of rotctld 4.5.4 (Debian 12), model 1, as it sent them.
#include "rotctl/protocol.hpp"

#include <gtest/gtest.h>

#include <clocale>
#include <numbers>
#include <vector>

namespace downrange::rotctl {
namespace {

constexpr double deg = std::numbers::pi / 180;

std::vector<std::string> lines_of(LineReader& reader) {
  std::vector<std::string> lines;
  while (auto line = reader.next()) lines.push_back(*line);
  return lines;
}

TEST(LineReader, PutsLinesTogetherFromAnyPieces) {
  LineReader reader;
  for (const char c : std::string("12.50\n\r\n3")) reader.add(std::string_view(&c, 1));
  EXPECT_EQ(lines_of(reader), (std::vector<std::string>{"12.50", ""}));
  EXPECT_TRUE(reader.partial());
  reader.add("4\r\nRPRT 0\n");
  EXPECT_EQ(lines_of(reader), (std::vector<std::string>{"34", "RPRT 0"}));
  EXPECT_FALSE(reader.partial());
  EXPECT_FALSE(reader.endless());
}

TEST(LineReader, AnEndlessLineIsToldAndNotKept) {
  LineReader reader;
  reader.add("1\n" + std::string(max_line, 'x'));
  EXPECT_EQ(lines_of(reader).size(), 1u);
  EXPECT_FALSE(reader.endless());
  reader.add("x");
  EXPECT_EQ(reader.next(), std::nullopt);
  EXPECT_TRUE(reader.endless());
  reader.add("\n2\n");
  EXPECT_EQ(reader.next(), std::nullopt);  // what follows means nothing
  LineReader whole;
  whole.add(std::string(max_line + 1, 'x') + "\n1\n");
  EXPECT_EQ(whole.next(), std::nullopt);
  EXPECT_TRUE(whole.endless());
}

TEST(Numbers, AreFiniteBoundedAndAlone) {
  EXPECT_EQ(parse_degrees("-179.25"), -179.25);
  EXPECT_EQ(parse_degrees(" +1.5e1\t"), 15.0);
  EXPECT_EQ(parse_degrees("1080"), 1080.0);
  for (const char* wrong : {"", "nan", "inf", "-inf", "1e999", "1081", "12,5", "1 2", "0x10", "--1", "++1", "RPRT 0"})
    EXPECT_EQ(parse_degrees(wrong), std::nullopt) << wrong;
  EXPECT_EQ(parse_report("RPRT -11"), -11);
  EXPECT_EQ(parse_report("RPRT 0"), 0);
  for (const char* wrong : {"RPRT", "RPRT x", "rprt 0", "12.5", "RPRT 99999999999"})
    EXPECT_EQ(parse_report(wrong), std::nullopt) << wrong;
}

TEST(Numbers, WhateverTheCodeItHasWords) {
  EXPECT_EQ(meaning_of(-1), "invalid parameter");
  EXPECT_EQ(meaning_of(-11), "not available");
  EXPECT_EQ(meaning_of(-999), "an error");
  EXPECT_EQ(meaning_of(std::numeric_limits<int>::min()), "an error");
}

TEST(Lines, SayDegreesWithPointWhateverTheLocale) {
  const char* german = std::setlocale(LC_NUMERIC, "de_DE.UTF-8");  // where it is installed
  EXPECT_EQ(position_line(-180.5 * deg, 12.34567 * deg), "P -180.5000 12.3457\n");
  EXPECT_EQ(position_line(-1e-9, 0), "P 0.0000 0.0000\n");
  EXPECT_EQ(pointing_lines(450 * deg, 90 * deg), "450.0000\n90.0000\n");
  EXPECT_EQ(report_line(rprt_not_available), "RPRT -11\n");
  if (german != nullptr) std::setlocale(LC_NUMERIC, "C");
}

StateReply::Progress read(StateReply& state, std::string_view text) {
  LineReader reader;
  reader.add(text);
  StateReply::Progress progress = StateReply::Progress::More;
  while (auto line = reader.next()) {
    progress = state.add(*line);
    if (progress == StateReply::Progress::Wrong) break;
  }
  return progress;
}

constexpr const char* hamlib_4 =
    "1\n1\nmin_az=-180.000000\nmax_az=450.000000\nmin_el=0.000000\nmax_el=90.000000\nsouth_zero=0\nrot_type="
    "AzEl\ndone\n";

TEST(StateReply, OfHamlib4) {
  StateReply state;
  EXPECT_EQ(read(state, hamlib_4), StateReply::Progress::Done);
  EXPECT_EQ(state.model(), 1);
  ASSERT_TRUE(state.travel());
  EXPECT_EQ(to_string(*state.travel()), "azimuth -180 to 450, elevation 0 to 90 deg");
}

TEST(StateReply, OfProtocol0EndsWhereItEnds) {
  StateReply bare;
  EXPECT_EQ(read(bare, "0\n2\n0.000000\n360.000000\n-5.000000\n185.000000\n"), StateReply::Progress::Enough);
  EXPECT_EQ(to_string(*bare.travel()), "azimuth 0 to 360, elevation -5 to 185 deg");
  EXPECT_EQ(bare.add("0"), StateReply::Progress::Enough);  // south_zero
  EXPECT_EQ(bare.add("0"), StateReply::Progress::Wrong);
  StateReply ended;
  EXPECT_EQ(read(ended, "0\n2\n0\n360\n0\n90\nRPRT 0\n"), StateReply::Progress::Done);
  EXPECT_TRUE(ended.travel());
}

TEST(StateReply, WhatNoRotatorHasIsNoTravel) {
  for (const char* state :
       {"1\n1\nmin_az=10\nmax_az=10\nmin_el=0\nmax_el=90\ndone\n", "1\n1\nmin_az=0\nmax_az=360\ndone\n",
        "1\n1\nmin_az=0\nmax_az=nan\nmin_el=0\nmax_el=90\ndone\n",
        "1\n1\nmin_az=0\nmax_az=360\nmin_el=90\nmax_el=0\ndone\n", "1\n1\ndone\n"}) {
    StateReply reply;
    EXPECT_EQ(read(reply, state), StateReply::Progress::Done) << state;
    EXPECT_FALSE(reply.travel()) << state;
  }
  for (const char* garbage : {"hello\n", "1\nx\n", "-1\n", "1\n1\nmin_az\n", "0\n1\nleft\n", "SSH-2.0-OpenSSH_9.2\n"}) {
    StateReply reply;
    EXPECT_EQ(read(reply, garbage), StateReply::Progress::Wrong) << garbage;
  }
  StateReply endless;
  std::string lines = "1\n1\n";
  for (int i = 0; i < 100; ++i) lines += "more=1\n";
  EXPECT_EQ(read(endless, lines), StateReply::Progress::Wrong);
}

TEST(StateReply, ReadsOurOwn) {
  const Travel travel{-270 * deg, 270 * deg, 0, 90 * deg};
  StateReply state;
  EXPECT_EQ(read(state, state_lines(travel)), StateReply::Progress::Done);
  EXPECT_EQ(to_string(*state.travel()), to_string(travel));
}

}  // namespace
}  // namespace downrange::rotctl
