// Numbers and times as people and instruments write them.

#include <archive/import/angles.hpp>
#include <archive/import/numbers.hpp>
#include <archive/import/times.hpp>
#include <cmath>
#include <limits>

#include "archive_testing.hpp"

namespace downrange::archive {
namespace {

/// NaN where it is no number, infinity where it is not finite.
double number(std::string_view text, DecimalMark mark = DecimalMark::Point) {
  const auto found = parse_number<double>(text, mark);
  if (found.kind == NumberKind::NotANumber) return std::numeric_limits<double>::quiet_NaN();
  if (found.kind == NumberKind::NotFinite) return std::numeric_limits<double>::infinity();
  return found.value;
}
double comma(std::string_view text) { return number(text, DecimalMark::Comma); }

TEST(ParseNumber, KnowsTheSpellings) {
  EXPECT_EQ(number("12030.5"), 12030.5);
  EXPECT_EQ(number("+12030.5"), 12030.5);
  EXPECT_EQ(number("-.5"), -0.5);
  EXPECT_EQ(number("12."), 12);
  EXPECT_EQ(number("+1.203E+04"), 12030);
  EXPECT_EQ(number("1.203D4"), 12030);
  EXPECT_EQ(number("-1.5d-03"), -0.0015);
  EXPECT_EQ(number("\u2212"
                   "3"),
            -3)
      << "the typographic minus";
  EXPECT_EQ(number("1e-999"), 0) << "smaller than any instrument tells";
  EXPECT_EQ(comma("12030,5"), 12030.5);
  EXPECT_EQ(comma("1,5E+03"), 1500);
  EXPECT_EQ(comma("+,5"), 0.5);
  EXPECT_EQ(number("0.1"), 0.1) << "the nearest double, grouped or not";
  EXPECT_EQ(number("1,234.1"), 1234.1);
}

TEST(ParseNumber, DigitsAreGroupedByThreeOrNotAtAll) {
  EXPECT_EQ(number("12,030.5"), 12030.5);
  EXPECT_EQ(number("1,234,567"), 1234567);
  EXPECT_EQ(number("12 030.5"), 12030.5);
  EXPECT_EQ(number("12\u00A0"
                   "030"),
            12030);
  EXPECT_EQ(number("12\u202F"
                   "030"),
            12030);
  EXPECT_EQ(number("12'030"), 12030);
  EXPECT_EQ(comma("12.030,5"), 12030.5);
  for (const char* wrong : {"1,23", "12,0300", "1234,567", ",123", "1,,234", "12,030,", "1.2.3", "12.030,5", "1 2"}) {
    EXPECT_TRUE(std::isnan(number(wrong))) << wrong;
  }
  for (const char* wrong : {"12,030.5", "1,2,3", "1.23", "12.0300"}) EXPECT_TRUE(std::isnan(comma(wrong))) << wrong;
}

TEST(ParseNumber, OtherTextIsNoNumber) {
  for (const char* wrong :
       {"", "+", "-", "+-5", "--5", "12x", "12 km", "1e", "1e+", "e5", ".", "0x10", "12\"", "1/2"}) {
    EXPECT_TRUE(std::isnan(number(wrong))) << wrong;
  }
  for (const char* wrong : {"nan", "NaN", "-nan", "inf", "+Inf", "INFINITY", "1e999", "1.#QNAN", "1.#INF"}) {
    EXPECT_TRUE(std::isinf(number(wrong))) << wrong;
  }
}

TEST(NoValue, HasManyNames) {
  for (const char* none : {"", "-", "---", "*****", "N/A", "n/a", "NA", "#N/A", "null", "None", "?", "."}) {
    EXPECT_TRUE(is_no_value(none)) << none;
  }
  for (const char* some : {"0", "-1", "nan", "x"}) EXPECT_FALSE(is_no_value(some)) << some;
}

/// "p", "c", "e": point, comma, either seen.
std::string evidence(std::initializer_list<const char*> cells) {
  DecimalEvidence found;
  std::uint64_t line = 1;
  for (const char* cell : cells) found.observe(cell, ++line);
  return std::string(found.point() ? "p" : "") + (found.comma() ? "c" : "") + (found.either() ? "e" : "");
}

TEST(DecimalEvidence, IsWhatCanBeReadInOneWayOnly) {
  EXPECT_EQ(evidence({"10.05", "12", "text", "05:00:10.5"}), "p");
  EXPECT_EQ(evidence({"10,05"}), "c");
  EXPECT_EQ(evidence({"12,000"}), "e");
  EXPECT_EQ(evidence({"120.000"}), "") << "a point is a decimal point where nothing is said against it";
  EXPECT_EQ(evidence({"12,000.0"}), "p");
  EXPECT_EQ(evidence({"12.000,0"}), "c");
  EXPECT_EQ(evidence({"1,234,567"}), "p");
  EXPECT_EQ(evidence({"0,123"}), "c");
  EXPECT_EQ(evidence({"0.123"}), "p");
  EXPECT_EQ(evidence({"12,000", "10.5"}), "pe");
  DecimalEvidence found;
  found.observe("1,5", 7);
  EXPECT_EQ(found.comma()->text, "1,5");
  EXPECT_EQ(found.comma()->line, 7u);
}

constexpr std::int64_t s = 1'000'000'000;
/// 2025-03-04T05:00:10.050Z, by date -u -d.
constexpr std::int64_t moment = 1'741'064'410 * s + 50'000'000;

TEST(ParseClock, DatesInEverySpellingThatIsCertain) {
  for (const char* text :
       {"2025-03-04T05:00:10.050Z", "2025-03-04T05:00:10.05", "2025-03-04 05:00:10,050", "2025/03/04 05:00:10.050 UTC",
        "2025-3-4 5:00:10.05", "2025-03-04T14:00:10.050+09:00", "2025-03-04T14:00:10.050+0900",
        "2025-03-03T22:30:10.05-06:30", "2025-063T05:00:10.050Z", "2025-063 05:00:10.050", "2025:063:05:00:10.050",
        "20250304T050010.050Z", "2025-03-04T05:00:10.050000000", "2025.03.04 05:00:10.05", "4-Mar-2025 05:00:10.05",
        "04MAR2025:05:00:10.05", "Mar 4, 2025 05:00:10.05", "4 March 2025, 05:00:10.050 UTC",
        "2025-03-04 5:00:10.05 AM"}) {
    const auto clock = parse_clock(text);
    ASSERT_TRUE(clock) << text;
    EXPECT_EQ(clock->shape, ClockShape::Instant) << text;
    EXPECT_EQ(clock->ns, moment) << text;
  }
  EXPECT_TRUE(parse_clock("2025-03-04T05:00:10Z")->zoned);
  EXPECT_TRUE(parse_clock("2025-03-04T05:00:10+00:00")->zoned);
  EXPECT_FALSE(parse_clock("2025-03-04T05:00:10")->zoned);
  EXPECT_EQ(parse_clock("2016-12-31T23:59:60Z")->ns, parse_clock("2017-01-01T00:00:00Z")->ns) << "a leap second";
  EXPECT_EQ(parse_clock("2025-03-03T24:00:00Z")->ns, parse_clock("2025-03-04T00:00:00Z")->ns);
  EXPECT_EQ(parse_clock("2025-03-04T05:00:10.0000000004Z")->ns % s, 0);
  EXPECT_EQ(parse_clock("2025-03-04T05:00:10.0000000006Z")->ns % s, 1) << "to the nearest nanosecond";
  EXPECT_EQ(show_utc(Time{moment}), "2025-03-04T05:00:10.050Z");
  EXPECT_EQ(show_utc(Time{-1'000'000}), "1969-12-31T23:59:59.999Z");
}

TEST(ParseClock, DayOrMonthFirstWhereTheMappingSaysSo) {
  EXPECT_EQ(parse_clock("04/03/2025 05:00:10.05", DateOrder::DayFirst)->ns, moment);
  EXPECT_EQ(parse_clock("4.3.2025 05:00:10.05", DateOrder::DayFirst)->ns, moment);
  EXPECT_EQ(parse_clock("03/04/2025 05:00:10.05", DateOrder::MonthFirst)->ns, moment);
  EXPECT_FALSE(parse_clock("13/04/2025 05:00:10.05", DateOrder::MonthFirst));
  EXPECT_EQ(parse_clock("2025-03-04T05:00:10.05", DateOrder::MonthFirst)->ns, moment) << "a year first is a year";
}

TEST(ParseClock, HalvesOfADay) {
  EXPECT_EQ(parse_clock("12:00:10 AM")->ns, 10 * s);
  EXPECT_EQ(parse_clock("12:00:10 PM")->ns, (12 * 3600 + 10) * s);
  EXPECT_EQ(parse_clock("1:00:10 pm")->ns, (13 * 3600 + 10) * s);
  EXPECT_FALSE(parse_clock("13:00:10 pm"));
}

TEST(ParseClock, HoursMinutesAndSecondsAsOneNumber) {
  EXPECT_EQ(unpacked_clock("050010.05"), "05:00:10.05");
  EXPECT_EQ(unpacked_clock("50010"), "05:00:10") << "a leading zero lost";
  for (const char* text : {"", ".5", "1050010", "05001a", "05:00:10"}) EXPECT_FALSE(unpacked_clock(text)) << text;
}

/// Degrees, or -999 for what is none.
double degrees(std::string_view text, AngleLetters letters = AngleLetters::None,
               DecimalMark mark = DecimalMark::Point) {
  return parse_degrees(text, mark, letters).value_or(-999);
}

TEST(ParseDegrees, EverySpellingThatIsCertain) {
  constexpr double angle = 12 + 34 / 60.0 + 56.7 / 3600;
  for (const char* text : {"12:34:56.7", "12 34 56.7", "12\u00B034'56.7\"", "12d34m56.7s",
                           "12\u00B0 34\u2032 56.7\u2033", "+12:34:56.7", "12\u00BA34'56.7''", "12 deg 34 m 56.7 s"}) {
    EXPECT_NEAR(degrees(text), angle, 1e-12) << text;
  }
  EXPECT_NEAR(degrees("-12:34:56.7"), -angle, 1e-12);
  EXPECT_NEAR(degrees("-0:30:00"), -0.5, 1e-12) << "the sign of a zero counts";
  EXPECT_NEAR(degrees("12:34.5"), 12.575, 1e-12);
  EXPECT_EQ(degrees("120.5\u00B0"), 120.5);
  EXPECT_NEAR(degrees("12:34:56,7", AngleLetters::None, DecimalMark::Comma), angle, 1e-12);
  EXPECT_EQ(degrees("34.5N", AngleLetters::NorthSouth), 34.5);
  EXPECT_EQ(degrees("S 34.5", AngleLetters::NorthSouth), -34.5);
  EXPECT_EQ(degrees("127:30:00 W", AngleLetters::EastWest), -127.5);
  EXPECT_EQ(degrees("127\u00B030'00\"E", AngleLetters::EastWest), 127.5);
}

TEST(ParseDegrees, OtherTextIsNone) {
  for (const char* text : {"", "120.5", "12:60.5", "12:34:61", "12.5:30", "12:34.5:10", "12:34:56:7", "abc", "12:-3",
                           "N", ":30", "12 034x"}) {
    EXPECT_EQ(degrees(text), -999) << text;
  }
  EXPECT_EQ(degrees("34.5E", AngleLetters::NorthSouth), -999);
  EXPECT_EQ(degrees("-34.5S", AngleLetters::NorthSouth), -999) << "one sign only";
  EXPECT_EQ(degrees("34.5N"), -999) << "an azimuth has no hemisphere";
}

TEST(ParseClock, TimesWithoutAYear) {
  EXPECT_EQ(parse_clock("063:05:00:10.5")->shape, ClockShape::DayOfYear);
  EXPECT_EQ(parse_clock("063:05:00:10.5")->ns, (62 * 86'400 + 5 * 3600 + 10) * s + s / 2);
  EXPECT_EQ(parse_clock("05:00:10.5")->shape, ClockShape::Hours);
  EXPECT_EQ(parse_clock("05:00:10.5")->ns, (5 * 3600 + 10) * s + s / 2);
  EXPECT_EQ(parse_clock("-00:00:10.5")->ns, -(10 * s + s / 2));
  EXPECT_EQ(parse_clock("30:00:00")->ns, 108'000 * s) << "a span may have more than a day";
  EXPECT_EQ(parse_clock("T+00:01:02.5")->shape, ClockShape::Countdown);
  EXPECT_EQ(parse_clock("T+00:01:02.5")->ns, 62 * s + s / 2);
  EXPECT_EQ(parse_clock("T-10.5")->ns, -(10 * s + s / 2));
}

TEST(ParseClock, OtherTextIsNone) {
  for (const char* text : {"", "12030.5", "03/04/2025 05:00:10", "2025-13-04T05:00:10", "2025-02-29T05:00:10",
                           "2025-366T05:00:10", "05:60:10", "05:00:61", "05:00", "2025-03-04T25:00:00", "T", "T+",
                           "2025-03-04T13:00:10 PM", "5:00:10.", "2025-03-04", "ten:past:five"}) {
    EXPECT_FALSE(parse_clock(text)) << text;
  }
}

}  // namespace
}  // namespace downrange::archive
