#include <archive/csv.hpp>
#include <stdexcept>

namespace downrange::archive {
namespace {

constexpr std::string_view blanks = " \t\r";

std::string_view trimmed(std::string_view text) {
  const std::size_t begin = text.find_first_not_of(blanks);
  if (begin == std::string_view::npos) return {};
  return text.substr(begin, text.find_last_not_of(blanks) - begin + 1);
}

}  // namespace

CsvFile::CsvFile(const std::filesystem::path& path, char delimiter) : in_(path), delimiter_(delimiter) {
  if (!in_ || !std::filesystem::is_regular_file(path)) {
    throw std::runtime_error(path.string() + ": cannot open the CSV file");
  }
  if (!read_line()) throw std::runtime_error(path.string() + ": no header line: the file is empty");
  if (text_.starts_with("\xEF\xBB\xBF")) text_.erase(0, 3);  // byte order mark of spreadsheets
  split();
  columns_.assign(fields_.begin(), fields_.end());
}

bool CsvFile::next() {
  while (read_line()) {
    if (trimmed(text_).empty()) continue;
    split();
    return true;
  }
  return false;
}

bool CsvFile::read_line() {
  if (!std::getline(in_, text_)) return false;
  ++line_;
  bytes_read_ += text_.size() + 1;
  return true;
}

void CsvFile::split() {
  fields_.clear();
  const std::string_view text = text_;
  std::size_t begin = 0;
  bool quoted = false;
  for (std::size_t i = 0; i <= text.size(); ++i) {
    if (i < text.size() && text[i] == '"') quoted = !quoted;
    if (i < text.size() && (quoted || text[i] != delimiter_)) continue;
    std::string_view field = trimmed(text.substr(begin, i - begin));
    if (field.size() >= 2 && field.front() == '"' && field.back() == '"') field = field.substr(1, field.size() - 2);
    fields_.push_back(field);
    begin = i + 1;
  }
}

}  // namespace downrange::archive
