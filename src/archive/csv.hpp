#pragma once
/// Rows of a CSV file: a header line, then one record a line. Quoted fields may hold the delimiter, not a line break.

#include <cstdint>
#include <filesystem>
#include <fstream>
#include <string>
#include <string_view>
#include <vector>

namespace downrange::archive {

class CsvFile {
 public:
  /// Reads the header. Throws std::runtime_error when the file cannot be opened or is empty.
  CsvFile(const std::filesystem::path& path, char delimiter);

  [[nodiscard]] const std::vector<std::string>& columns() const { return columns_; }

  /// Goes to the next line that is not blank; false at the end of the file.
  [[nodiscard]] bool next();
  /// Of the current line, without surrounding blanks and quotes; live until next().
  [[nodiscard]] const std::vector<std::string_view>& fields() const { return fields_; }
  /// Of the current line in the file, the header's being 1.
  [[nodiscard]] std::uint64_t line() const { return line_; }
  [[nodiscard]] std::uint64_t bytes_read() const { return bytes_read_; }

 private:
  bool read_line();
  void split();

  std::ifstream in_;
  char delimiter_;
  std::string text_;
  std::vector<std::string_view> fields_;
  std::vector<std::string> columns_;
  std::uint64_t line_ = 0;
  std::uint64_t bytes_read_ = 0;
};

}  // namespace downrange::archive
