#include <algorithm>
#include <archive/import/nmea.hpp>
#include <archive/import/source_text.hpp>
#include <array>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <numbers>
#include <optional>
#include <text/printable.hpp>

namespace downrange::archive {
namespace {

constexpr std::array<const char*, 8> columns{"time", "latitude",   "longitude",        "height",
                                             "fix",  "satellites", "sigma_horizontal", "sigma_vertical"};

/// One sentence: its type without the talker, its fields without the type.
struct Sentence {
  std::string_view type;
  std::vector<std::string_view> fields;
  std::string_view stated_sum;
  std::optional<unsigned> expected_sum;  ///< where the stated checksum is another

  [[nodiscard]] std::string_view at(std::size_t i) const { return i < fields.size() ? fields[i] : std::string_view(); }
};

/// The checksum that should be there; nothing where it is.
std::optional<unsigned> expected_sum(std::string_view body, std::string_view stated) {
  unsigned sum = 0;
  for (const char c : body) sum ^= static_cast<unsigned char>(c);
  unsigned said = 0;
  const auto [end, error] =
      std::from_chars(stated.data(), stated.data() + std::min<std::size_t>(2, stated.size()), said, 16);
  if (error == std::errc() && end == stated.data() + 2 && said == sum) return {};
  return sum;
}

std::string show_sum(unsigned sum) {
  std::array<char, 8> text{};
  std::snprintf(text.data(), text.size(), "%02X", sum);
  return text.data();
}

std::optional<Sentence> sentence_of(std::string_view line) {
  const std::size_t start = line.find('$');
  if (start == std::string_view::npos) return std::nullopt;
  line = trimmed(line.substr(start + 1));
  Sentence sentence;
  if (const std::size_t star = line.rfind('*'); star != std::string_view::npos) {
    sentence.stated_sum = line.substr(star + 1, 2);
    sentence.expected_sum = expected_sum(line.substr(0, star), line.substr(star + 1));
    line = line.substr(0, star);
  }
  std::size_t comma = line.find(',');
  if (comma != 5) return std::nullopt;
  sentence.type = line.substr(2, 3);
  while (comma < line.size()) {
    const std::size_t next = std::min(line.find(',', comma + 1), line.size());
    sentence.fields.push_back(line.substr(comma + 1, next - comma - 1));
    comma = next;
  }
  return sentence;
}

std::optional<double> number(std::string_view text) {
  const auto found = parse_number<double>(text, DecimalMark::Point);
  return found.kind == NumberKind::Finite ? std::optional(found.value) : std::nullopt;
}

/// "050010.05" in seconds since midnight.
std::optional<double> second_of_day(std::string_view text) {
  const auto value = number(text);
  if (!value || text.size() < 6 || *value < 0) return std::nullopt;
  const double hours = std::floor(*value / 10'000);
  const double minutes = std::floor(*value / 100) - hours * 100;
  return (hours * 60 + minutes) * 60 + (*value - std::floor(*value / 100) * 100);
}

/// A date and the time of day that it was said at.
struct KnownDate {
  std::int64_t day = 0;  ///< since 1970
  double second = 0;
};

std::optional<KnownDate> date_of(const Sentence& sentence) {
  const auto second = second_of_day(sentence.at(0));
  std::array<std::optional<double>, 3> date;  // day, month, year
  if (sentence.type == "ZDA") {
    date = {number(sentence.at(1)), number(sentence.at(2)), number(sentence.at(3))};
  } else if (const auto text = sentence.at(8); sentence.type == "RMC" && text.size() == 6) {
    date = {number(text.substr(0, 2)), number(text.substr(2, 2)), number(text.substr(4, 2))};
    if (date[2]) *date[2] += *date[2] < 80 ? 2000 : 1900;
  }
  if (!second || !date[0] || !date[1] || !date[2]) return std::nullopt;
  std::array<char, 40> text{};
  std::snprintf(text.data(), text.size(), "%04.0f-%02.0f-%02.0fT00:00:00Z", *date[2], *date[1], *date[0]);
  const auto clock = parse_clock(text.data());
  if (!clock) return std::nullopt;
  return KnownDate{clock->ns / 86'400'000'000'000, *second};
}

/// "3425.9140" and "N" as "34:25.9140N".
std::string angle_of(std::string_view text, std::string_view letter) {
  const std::size_t point = std::min(text.find('.'), text.size());
  if (point < 3) return std::string(text);
  return std::string(text.substr(0, point - 2)) + ':' + std::string(text.substr(point - 2)) + std::string(letter);
}

std::string height_of(std::string_view above_sea, std::string_view separation) {
  const auto sea = number(above_sea);
  const auto geoid = number(separation);
  if (!sea) return std::string(above_sea);
  if (!geoid) return "no separation of the geoid";
  std::array<char, 40> text{};
  std::snprintf(text.data(), text.size(), "%.4f", *sea + *geoid);
  return text.data();
}

/// The worth of a fix: GGA's quality, or the best of GNS's mode letters.
const char* fix_of(const Sentence& sentence) {
  const std::string_view quality = sentence.at(5);
  if (sentence.type == "GGA") {
    if (quality == "1" || quality == "3") return "3d";
    return quality == "2" || quality == "4" || quality == "5" ? "differential" : "none";
  }
  if (quality.find_first_of("DRF") != std::string_view::npos) return "differential";
  return quality.find_first_of("AP") != std::string_view::npos ? "3d" : "none";
}

struct Sigmas {
  std::string horizontal;
  std::string vertical;
};

class Table {
 public:
  explicit Table(std::string_view text) : text_(text) { look_ahead(); }

  NmeaTable run() {
    NmeaTable table;
    LineReader lines(text_);
    while (const auto line = lines.next()) {
      const auto sentence = sentence_of(*line);
      if (sentence) ++table.sentences[std::string(sentence->type)];
      if (sentence && !sentence->expected_sum) note_date(*sentence);
      if (sentence && sentence->expected_sum) note_wrong(*sentence, lines.line(), table);
      const bool fix = sentence && sentence->type == (has_gga_ ? "GGA" : "GNS");
      table.text += !fix                      ? "#"
                    : !sentence->expected_sum ? row_of(*sentence)
                                              : "checksum is not " + show_sum(*sentence->expected_sum) + ",,,,,,,";
      table.text += '\n';
    }
    return table;
  }

 private:
  /// What a fix needs that can stand behind it.
  void look_ahead() {
    LineReader lines(text_);
    while (const auto line = lines.next()) {
      const auto sentence = sentence_of(*line);
      if (!sentence || sentence->expected_sum) continue;
      has_gga_ |= sentence->type == "GGA";
      if (!date_) date_ = date_of(*sentence);
      if (sentence->type != "GST") continue;
      const auto north = number(sentence->at(5));
      const auto east = number(sentence->at(6));
      if (!north || !east) continue;
      std::array<char, 40> horizontal{};
      std::snprintf(horizontal.data(), horizontal.size(), "%.4f", std::sqrt((*north * *north + *east * *east) / 2));
      sigmas_[std::string(sentence->at(0))] = {horizontal.data(), std::string(sentence->at(7))};
    }
  }

  static void note_wrong(const Sentence& sentence, std::uint64_t line, NmeaTable& table) {
    if (++table.wrong_checksums > 1) return;
    table.first_wrong = "line " + std::to_string(line) + ": found *" + text::printable(sentence.stated_sum, false, 10) +
                        ", expected *" + show_sum(*sentence.expected_sum);
  }

  void note_date(const Sentence& sentence) {
    if (const auto found = date_of(sentence)) date_ = found;
  }

  [[nodiscard]] std::string time_of(std::string_view text) const {
    const auto clock = unpacked_clock(text);
    if (!clock) return std::string(text);
    const auto second = second_of_day(text);
    if (!date_ || !second) return *clock;
    constexpr double half_day = 43'200;
    std::int64_t day = date_->day;
    if (*second - date_->second > half_day) --day;
    if (*second - date_->second < -half_day) ++day;
    return show_utc(Time{day * 86'400'000'000'000}).substr(0, 11) + *clock;
  }

  [[nodiscard]] std::string row_of(const Sentence& s) const {
    const bool gga = s.type == "GGA";
    const auto sigmas = sigmas_.find(std::string(s.at(0)));
    std::string row = time_of(s.at(0)) + ',' + angle_of(s.at(1), s.at(2)) + ',' + angle_of(s.at(3), s.at(4)) + ',' +
                      height_of(s.at(8), s.at(gga ? 10 : 9)) + ',' + fix_of(s) + ',' + std::string(s.at(6));
    if (sigmas == sigmas_.end()) return row + ",,";
    return row + ',' + sigmas->second.horizontal + ',' + sigmas->second.vertical;
  }

  std::string_view text_;
  bool has_gga_ = false;
  std::optional<KnownDate> date_;
  std::map<std::string, Sigmas> sigmas_;
};

}  // namespace

void declare_nmea(FileMapping& file) {
  file.nmea = true;
  file.delimiter = ',';
  file.decimal = DecimalMark::Point;
  file.given_names.assign(columns.begin(), columns.end());
  const auto add = [&](const char* name, Field field, double factor) -> ColumnMapping& {
    ColumnMapping column;
    column.column = name;
    column.field = field;
    column.factor = factor;
    return file.columns.emplace_back(std::move(column));
  };
  constexpr double deg = std::numbers::pi / 180;
  ColumnMapping& time = add("time", Field::Epoch, 1);
  time.text = true;
  time.since = Since::Midnight;
  add("latitude", Field::Latitude, deg).unit = "deg";
  add("longitude", Field::Longitude, deg).unit = "deg";
  add("height", Field::Height, 1);
  ColumnMapping& fix = add("fix", Field::FixType, 1);
  const auto names = choices_of(Field::FixType);
  for (std::size_t i = 0; i < names.size(); ++i) fix.values.emplace_back(names[i], static_cast<int>(i));
  add("satellites", Field::Satellites, 1);
  add("sigma_horizontal", Field::SigmaHorizontal, 1);
  add("sigma_vertical", Field::SigmaVertical, 1);
}

NmeaTable nmea_table(std::string_view text) { return Table(text).run(); }

}  // namespace downrange::archive
