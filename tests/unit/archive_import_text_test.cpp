// From bytes to fields: encodings, line ends, delimiters, quotes, comments.

#include <archive/import/import_error.hpp>
#include <archive/import/rows.hpp>
#include <archive/import/source_text.hpp>

#include "archive_testing.hpp"

namespace downrange::archive {
namespace {

using namespace std::string_literals;

std::string utf16(const std::string& ascii, bool big_endian) {
  std::string out;
  for (const char c : ascii) out += big_endian ? "\0"s + c : c + "\0"s;
  return out;
}

std::string refusal(const std::string& bytes) {
  try {
    static_cast<void>(decode_text(bytes));
  } catch (const ImportError& error) {
    return error.what();
  }
  return "";
}

TEST(SourceText, EveryEncodingThatIsCertainBecomesUtf8) {
  const std::string text = "time,rng\n10.0,12000\n";
  EXPECT_EQ(decode_text(text).text, text);
  EXPECT_EQ(decode_text(text).encoding, "");
  EXPECT_EQ(decode_text("\xEF\xBB\xBF" + text).text, text);
  EXPECT_EQ(decode_text("\xFF\xFE" + utf16(text, false)).text, text);
  EXPECT_EQ(decode_text("\xFE\xFF" + utf16(text, true)).text, text);
  EXPECT_EQ(decode_text(utf16(text, false)).text, text);
  EXPECT_EQ(decode_text(utf16(text, true)).text, text);
  EXPECT_EQ(decode_text(utf16(text, true)).encoding, "UTF-16 (big-endian, without a mark)");
  EXPECT_EQ(decode_text("az\xB0\n").text, "az\u00B0\n");
  EXPECT_EQ(decode_text("az\xB0\n").encoding, "Latin-1");
  EXPECT_EQ(decode_text("az\u00B0\n").encoding, "");
  EXPECT_EQ(decode_text("\xFE\xFF\xD8\x3D\xDE\x80"s).text, "\U0001F680") << "two units, one character";
  EXPECT_EQ(decode_text("\xFE\xFF\xDE\x80"s).text, "\uFFFD") << "half a character";
  EXPECT_EQ(decode_text("").text, "");
}

TEST(SourceText, FourBytesACharacterWithAMarkOrWithout) {
  const std::string text = "time,rng\n10.0,12000\n";
  for (const bool big : {false, true}) {
    std::string wide;
    for (const char c : text) wide += big ? std::string(3, '\0') + c : c + std::string(3, '\0');
    EXPECT_EQ(decode_text(wide).text, text);
    EXPECT_EQ(decode_text((big ? "\0\0\xFE\xFF"s : "\xFF\xFE\0\0"s) + wide).text, text);
    EXPECT_EQ(decode_text(wide).encoding.substr(0, 6), "UTF-32");
  }
  EXPECT_EQ(decode_text("\xFF\xFE\0\0\0\0\x11\0"s).text, "\uFFFD") << "beyond Unicode";
}

TEST(SourceText, ZeroBytesAtTheEndAreLeftOffAndAFewInsideStay) {
  EXPECT_EQ(decode_text("a,b\n1,2\n" + std::string(4096, '\0')).text, "a,b\n1,2\n");
  EXPECT_EQ(decode_text("a,b\n1,2\n" + std::string(4096, '\0')).end_zeros, 4096u);
  EXPECT_EQ(decode_text("a,b\n1,2\n\0,3\n"s).text, "a,b\n1,2\n\0,3\n"s);
}

TEST(SourceText, WhatIsNoTextIsNamed) {
  EXPECT_NE(refusal("PK\x03\x04...").find("ZIP"), std::string::npos);
  EXPECT_NE(refusal("\x1F\x8B...").find("gzip"), std::string::npos);
  EXPECT_EQ(refusal("a,b\n1,2\n\0\0\0\0\0\0\0,3\n"s), "holds many zero bytes (the first on line 3): it is no text");
  EXPECT_NE(refusal("\xD0\xCF\x11\xE0...").find(".xls"), std::string::npos);
  EXPECT_NE(refusal("<html><table>").find("HTML"), std::string::npos);
  EXPECT_NE(refusal("\x84\x31\x95\x33time").find("GB 18030"), std::string::npos);
  EXPECT_NE(refusal("\xFF\xFE" + utf16("abc", false) + "d").find("cut off"), std::string::npos);
}

std::vector<std::string> lines_of(std::string_view text) {
  LineReader reader(text);
  std::vector<std::string> lines;
  while (const auto line = reader.next()) lines.emplace_back(*line);
  EXPECT_EQ(reader.line(), lines.size());
  return lines;
}

TEST(LineReader, TakesEveryLineEnd) {
  const std::vector<std::string> abc{"a", "", "b"};
  EXPECT_EQ(lines_of("a\n\nb\n"), abc);
  EXPECT_EQ(lines_of("a\r\n\r\nb"), abc);
  EXPECT_EQ(lines_of("a\r\rb\r"), abc);
  EXPECT_EQ(lines_of("a\r\n\nb\r"), abc);
  EXPECT_EQ(lines_of("a\n\nb\n\x1A"), abc) << "the end of a DOS file";
  EXPECT_EQ(lines_of(""), std::vector<std::string>());
}

std::vector<std::string> split(std::string_view line, Delimiter delimiter = ',') {
  RowSplitter splitter(delimiter);
  const auto& fields = splitter.split(line);
  return {fields.begin(), fields.end()};
}
using Fields = std::vector<std::string>;

TEST(RowSplitter, FieldsStandBetweenDelimiters) {
  EXPECT_EQ(split("a, b ,,c"), (Fields{"a", "b", "", "c"}));
  EXPECT_EQ(split("a,b,"), (Fields{"a", "b", ""}));
  EXPECT_EQ(split(""), (Fields{""}));
  EXPECT_EQ(split("a\tb c", '\t'), (Fields{"a", "b c"}));
  EXPECT_EQ(split("\u00A0"
                  "12 000\u00A0;x",
                  ';'),
            (Fields{"12 000", "x"}));
  EXPECT_EQ(split("  a \t b   c  ", blanks), (Fields{"a", "b", "c"}));
  EXPECT_EQ(split("  ", blanks), (Fields{""}));
}

TEST(RowSplitter, AQuoteSpoilsItsOwnFieldOnly) {
  EXPECT_EQ(split(R"("12,000.0", "b" ,c)"), (Fields{"12,000.0", "b", "c"}));
  EXPECT_EQ(split(R"("az ""raw""",2)"), (Fields{R"(az "raw")", "2"}));
  EXPECT_EQ(split(R"(1,12030.0",3)"), (Fields{"1", R"(12030.0")", "3"}));
  EXPECT_EQ(split(R"(1,"12030.0,3)"), (Fields{"1", R"("12030.0)", "3"}));
  EXPECT_EQ(split(R"(1,"a"b,3)"), (Fields{"1", R"("a"b)", "3"}));
  EXPECT_EQ(split(R"(1,"",3)"), (Fields{"1", "", "3"}));
  EXPECT_EQ(split(R"("a b" c)", blanks), (Fields{"a b", "c"}));
}

TEST(RowSplitter, AQuotedFieldMayHaveLineBreaksAndAnOpenOneIsTold) {
  EXPECT_EQ(split("1,\"lost\nlock\",3"), (Fields{"1", "lost\nlock", "3"}));
  RowSplitter splitter(',');
  static_cast<void>(splitter.split("1,\"lost"));
  EXPECT_TRUE(splitter.open());
  static_cast<void>(splitter.split("1,lost\""));
  EXPECT_FALSE(splitter.open());
}

TEST(RowSplitter, AVeryLongLineMakesAMillionFieldsOfNobody) {
  const std::string line(1'000'000, ',');
  RowSplitter splitter(',');
  EXPECT_EQ(splitter.split(line).size(), RowSplitter::max_fields);
}

TEST(SplitFixed, PlacesAreCharacters) {
  const std::vector<FixedPlace> places{{1, 3}, {4, 6}, {8, 9}};
  const auto cells = [&](std::string_view line) {
    const auto found = split_fixed(line, places);
    return Fields{found.begin(), found.end()};
  };
  EXPECT_EQ(cells("abcdefghi"), (Fields{"abc", "def", "hi"}));
  EXPECT_EQ(cells(" b d"), (Fields{"b", "d", ""}));
  EXPECT_EQ(cells(""), (Fields{"", "", ""}));
  EXPECT_EQ(cells("\u00B0bcdefghi"), (Fields{"\u00B0bc", "def", "hi"})) << "two bytes, one character";
}

TEST(Comments, AreTakenOffAndTold) {
  const auto marks = usual_comments(',');
  EXPECT_EQ(comment_of("# operator: lost lock", marks), "operator: lost lock");
  EXPECT_EQ(comment_of("  % x", marks), "x");
  EXPECT_EQ(comment_of("// x", marks), "x");
  EXPECT_EQ(comment_of("; x", marks), "x");
  EXPECT_EQ(comment_of("\"# from a spreadsheet\",,", marks), "from a spreadsheet\",,");
  EXPECT_EQ(comment_of("#N/A,1,2", marks), std::nullopt) << "a spreadsheet's error is a value";
  EXPECT_EQ(comment_of("10.0,1,2", marks), std::nullopt);
  EXPECT_EQ(comment_of(";1;2", usual_comments(';')), std::nullopt) << "an empty first field";
  EXPECT_EQ(comment_of("# x", {}), std::nullopt);
}

}  // namespace
}  // namespace downrange::archive
