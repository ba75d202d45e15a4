// Text from outside: bounded before it is read, understood or printed.

#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>

#include "text/file.hpp"
#include "text/parse_toml.hpp"
#include "text/printable.hpp"

namespace downrange::text {
namespace {

std::string repeated(const std::string& part, int times) {
  std::string all;
  for (int i = 0; i < times; ++i) all += part;
  return all;
}

/// "LINE: reason" where parse_toml refuses; empty where it does not.
std::string refusal(const std::string& toml) {
  try {
    static_cast<void>(parse_toml(toml));
  } catch (const TomlError& error) {
    return std::to_string(error.line()) + ": " + error.what();
  }
  return "";
}

TEST(ParseToml, DepthIsRefusedBeforeItCanExhaustTheStack) {
  const std::string deep = repeated("a.", 50'000) + "a";
  EXPECT_EQ(refusal("x = 1\n" + deep + " = 1"), "2: a key of more than 16 parts: too deep for a file of this kind");
  EXPECT_EQ(refusal("[" + deep + "]").substr(0, 3), "1: ");
  EXPECT_EQ(refusal("[[" + deep + "]]").substr(0, 3), "1: ");
  EXPECT_EQ(refusal("x = {" + deep + " = 1}").substr(0, 3), "1: ");
  EXPECT_EQ(refusal(repeated("a . ", 50'000) + "a = 1").substr(0, 3), "1: ");
  EXPECT_EQ(refusal(repeated("\"a\".", 50'000) + "a = 1").substr(0, 3), "1: ");
  EXPECT_EQ(refusal("x = " + repeated("[", 50'000)),
            "1: more than 16 brackets in each other: too deep for a file of this kind");
  EXPECT_EQ(refusal("x = " + repeated("{a = ", 50'000)).substr(0, 3), "1: ");
}

TEST(ParseToml, DepthCannotHideBehindStringsAndComments) {
  const std::string deep = repeated("a.", 100) + "a = 1";
  EXPECT_NE(refusal("x = \"\"\"text \"\"\"\"\n" + deep).find("16 parts"), std::string::npos);
  EXPECT_NE(refusal("x = {y = \"\"\"t\"\"\"\", " + deep + "}").find("16 parts"), std::string::npos);
  EXPECT_NE(refusal("x = {y = '''t''''', " + deep + "}").find("16 parts"), std::string::npos);
  EXPECT_NE(refusal("x = {y = \"\\\\\", " + deep + "}").find("16 parts"), std::string::npos);
  EXPECT_NE(refusal("x = {y = 'C:\\', " + deep + "}").find("16 parts"), std::string::npos);
  EXPECT_NE(refusal("# it's\n" + deep).find("16 parts"), std::string::npos);
  EXPECT_NE(refusal("x = 'never closed\n" + deep), "");
}

TEST(ParseToml, WhatIsOnlyTextIsNotDeep) {
  const std::string dots(1000, '.');
  const std::string brackets(1000, '[');
  EXPECT_EQ(refusal("# " + dots + brackets), "");
  EXPECT_EQ(refusal("x = \"" + dots + brackets + "\""), "");
  EXPECT_EQ(refusal("x = '" + dots + "\"" + brackets + "'"), "");
  EXPECT_EQ(refusal("x = \"\"\"\n" + dots + "\n\" " + brackets + "\"\"\""), "");
  EXPECT_EQ(refusal("x = [" + repeated("1.5, ", 1000) + "2.5]\ny = [[1, 2], [3, 4]]"), "");
  EXPECT_EQ(refusal("[a.b.c]\nd.e = 1"), "");
}

TEST(ParseToml, WrongTextNamesItsLine) {
  EXPECT_EQ(refusal("a = 1\nb = \n").substr(0, 18), "2: not valid TOML:");
  EXPECT_EQ(refusal("a = \x1b[31m").find('\x1b'), std::string::npos) << "an escape is not passed on";
  EXPECT_EQ(refusal(std::string(max_toml_size + 1, '#')), "0: is larger than 4 MB");
}

class ReadFile : public testing::Test {
 protected:
  ReadFile() {
    std::string pattern = std::filesystem::temp_directory_path() / "downrange-text-XXXXXX";
    folder_ = ::mkdtemp(pattern.data());
  }
  ~ReadFile() override { std::filesystem::remove_all(folder_); }
  static std::string refusal(const std::filesystem::path& file, std::uint64_t max_size = 100) {
    try {
      static_cast<void>(read_file(file, max_size));
    } catch (const FileError& error) {
      return error.what();
    }
    return "";
  }
  std::filesystem::path folder_;
};

TEST_F(ReadFile, OnlyRegularFilesAreRead) {
  std::ofstream(folder_ / "text") << "some text";
  EXPECT_EQ(read_file(folder_ / "text", 9), "some text");
  EXPECT_EQ(refusal(folder_ / "text", 8), "is larger than 8 bytes");
  EXPECT_EQ(refusal(folder_ / "absent"), "no such file");
  EXPECT_EQ(refusal(folder_), "is a folder, not a file");
  EXPECT_EQ(refusal("/dev/zero"), "is a device, not a file");
  ASSERT_EQ(::mkfifo((folder_ / "pipe").c_str(), 0600), 0);
  EXPECT_EQ(refusal(folder_ / "pipe"), "is a pipe, not a file") << "and nobody waits for its writer";
  std::filesystem::create_symlink("/dev/zero", folder_ / "link");
  EXPECT_EQ(refusal(folder_ / "link"), "is a device, not a file");
}

TEST(Printable, WhatATerminalWouldObeyIsWrittenOut) {
  EXPECT_EQ(printable("dish-1 47°"), "dish-1 47°");
  EXPECT_EQ(printable("\x1b[2J\a\r\n\t\x7f"), "\\x1b[2J\\x07\\x0d\\x0a\\x09\\x7f");
  EXPECT_EQ(printable("a\n\tb\r", true), "a\n\tb\\x0d");
  EXPECT_EQ(printable("\xc2\x9b"
                      "31m"),
            "\\xc2\\x9b31m")
      << "C1 CSI in UTF-8";
  EXPECT_EQ(printable("\xff\xc0\x80"), "\\xff\\xc0\\x80") << "no UTF-8";
  EXPECT_EQ(printable("\xe2\x80\xae"
                      "abc"),
            "\\xe2\\x80\\xae"
            "abc")
      << "right-to-left override";
  EXPECT_EQ(printable(std::string("a\0b", 3)), "a\\x00b");
  EXPECT_EQ(printable("abcdef", false, 3), "abc...");
  EXPECT_EQ(in_quotes("a'b"), "'a'b'");
  EXPECT_EQ(in_quotes(std::string(60, 'x')), "'" + std::string(40, 'x') + "...'");
}

}  // namespace
}  // namespace downrange::text
