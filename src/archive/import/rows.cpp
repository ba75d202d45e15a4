#include <algorithm>
#include <archive/import/rows.hpp>
#include <array>
#include <text/utf8.hpp>

namespace downrange::archive {
namespace {

constexpr std::string_view line_blanks = " \t\v\f\r";
/// No-break space, narrow no-break space, thin space, byte order mark (of files put together).
constexpr std::array<std::string_view, 4> wide_blanks{"\u00A0", "\u202F", "\u2009", "\uFEFF"};

std::size_t blank_at_start(std::string_view text) {
  if (text.empty()) return 0;
  if (line_blanks.find(text.front()) != std::string_view::npos) return 1;
  for (const std::string_view blank : wide_blanks) {
    if (text.starts_with(blank)) return blank.size();
  }
  return 0;
}

std::size_t blank_at_end(std::string_view text) {
  if (text.empty()) return 0;
  if (line_blanks.find(text.back()) != std::string_view::npos) return 1;
  for (const std::string_view blank : wide_blanks) {
    if (text.ends_with(blank)) return blank.size();
  }
  return 0;
}

bool is_blank(char c) { return c == ' ' || c == '\t'; }

}  // namespace

std::string_view trimmed(std::string_view text) {
  while (const std::size_t size = blank_at_start(text)) text.remove_prefix(size);
  while (const std::size_t size = blank_at_end(text)) text.remove_suffix(size);
  return text;
}

std::string show_delimiter(Delimiter delimiter) {
  if (delimiter == blanks) return "\"blanks\"";
  if (delimiter == '\t') return "\"tab\"";
  return std::string("\"") + delimiter + '"';
}

std::vector<std::string> usual_comments(Delimiter delimiter) {
  std::vector<std::string> marks{"#", "%", "//"};
  if (delimiter != ';') marks.emplace_back(";");
  return marks;
}

std::optional<std::string_view> comment_of(std::string_view line, const std::vector<std::string>& marks) {
  constexpr std::array<std::string_view, 7> errors{"#N/A", "#NUM!", "#DIV/0!", "#VALUE!", "#REF!", "#NAME?", "#NULL!"};
  std::string_view text = trimmed(line);
  if (text.starts_with('"')) text.remove_prefix(1);
  if (std::any_of(errors.begin(), errors.end(), [&](std::string_view e) { return text.starts_with(e); })) return {};
  for (const std::string& mark : marks) {
    if (!mark.empty() && text.starts_with(mark)) return trimmed(text.substr(mark.size()));
  }
  return std::nullopt;
}

std::size_t RowSplitter::delimiter_at(std::string_view line, std::size_t from) const {
  const std::size_t found = delimiter_ == blanks ? line.find_first_of(" \t", from) : line.find(delimiter_, from);
  return std::min(found, line.size());
}

std::optional<std::string_view> RowSplitter::quoted_field(std::string_view line, std::size_t& at) {
  std::size_t begin = at;
  while (begin < line.size() && is_blank(line[begin]) && line[begin] != delimiter_) ++begin;
  if (begin >= line.size() || line[begin] != '"') return std::nullopt;
  std::size_t end = begin + 1;
  bool doubled = false;
  for (;; ++end) {
    end = line.find('"', end);
    if (end == std::string_view::npos) {
      open_ = true;
      return std::nullopt;
    }
    if (end + 1 >= line.size() || line[end + 1] != '"') break;
    doubled = true;
    ++end;
  }
  const std::size_t next = delimiter_at(line, end + 1);
  if (!trimmed(line.substr(end + 1, next - end - 1)).empty()) return std::nullopt;  // closed within the field
  at = next + 1;
  const std::string_view inside = line.substr(begin + 1, end - begin - 1);
  if (!doubled) return trimmed(inside);
  std::string& text = unquoted_.emplace_back();
  for (std::size_t i = 0; i < inside.size(); ++i) {
    text += inside[i];
    if (inside[i] == '"') ++i;
  }
  return trimmed(text);
}

const std::vector<std::string_view>& RowSplitter::split(std::string_view line) {
  fields_.clear();
  unquoted_.clear();
  open_ = false;
  if (delimiter_ == blanks) line = trimmed(line);
  for (std::size_t at = 0; at <= line.size();) {
    if (delimiter_ == blanks) {
      while (at < line.size() && is_blank(line[at])) ++at;
      if (at >= line.size() && !fields_.empty()) break;
    }
    if (fields_.size() + 1 == max_fields) {
      fields_.push_back(line.substr(at));
      break;
    }
    if (const auto field = quoted_field(line, at)) {
      fields_.push_back(*field);
      continue;
    }
    const std::size_t end = delimiter_at(line, at);
    fields_.push_back(trimmed(line.substr(at, end - at)));
    at = end + 1;
  }
  return fields_;
}

std::vector<std::string_view> split_fixed(std::string_view line, const std::vector<FixedPlace>& places) {
  const bool ascii = std::all_of(line.begin(), line.end(), [](char c) { return static_cast<unsigned char>(c) < 0x80; });
  std::vector<std::size_t> starts;  // of each character, where they are not all of one byte
  for (std::size_t at = 0; !ascii && at < line.size();
       at += std::max<std::size_t>(1, text::utf8_size(line.substr(at, 4)))) {
    starts.push_back(at);
  }
  const auto byte_of = [&](std::size_t character) {
    if (ascii) return std::min(character, line.size());
    return character < starts.size() ? starts[character] : line.size();
  };
  std::vector<std::string_view> fields;
  for (const FixedPlace& place : places) {
    const std::size_t begin = byte_of(place.first - 1);
    fields.push_back(trimmed(line.substr(begin, byte_of(place.last) - begin)));
  }
  return fields;
}

}  // namespace downrange::archive
