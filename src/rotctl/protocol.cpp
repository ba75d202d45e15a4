#include "rotctl/protocol.hpp"

#include <array>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <numbers>

namespace downrange::rotctl {
namespace {

constexpr double deg = std::numbers::pi / 180;
/// Three turns: no rotator has more.
constexpr double most_deg = 1080;

std::string_view trimmed(std::string_view text) {
  const auto first = text.find_first_not_of(" \t");
  if (first == std::string_view::npos) return {};
  return text.substr(first, text.find_last_not_of(" \t") - first + 1);
}

template <class Number>
std::optional<Number> parse_number(std::string_view text) {
  text = trimmed(text);
  if (text.starts_with('+')) text.remove_prefix(1);
  Number value{};
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size()) return std::nullopt;
  return value;
}

/// Without the sign of a zero, and whatever the locale.
std::string fixed(double value, int digits) {
  std::array<char, 32> text{};
  const double scale = std::pow(10, digits);
  const double rounded = std::round(value * scale) / scale;
  const auto [end, error] = std::to_chars(text.data(), text.data() + text.size(), rounded == 0 ? 0 : rounded,
                                          std::chars_format::fixed, digits);
  return {text.data(), end};
}

}  // namespace

std::optional<std::string> LineReader::next() {
  const std::size_t end = bytes_.find('\n');
  if (endless_ || std::min(end, bytes_.size()) > max_line) {
    endless_ = true;
    bytes_.clear();
    return std::nullopt;
  }
  if (end == std::string::npos) return std::nullopt;
  std::string line = bytes_.substr(0, end);
  bytes_.erase(0, end + 1);
  if (line.ends_with('\r')) line.pop_back();
  return line;
}

std::optional<double> parse_degrees(std::string_view line) {
  const std::optional<double> value = parse_number<double>(line);
  if (!value || !(std::abs(*value) <= most_deg)) return std::nullopt;  // NaN too
  return value;
}

std::optional<int> parse_report(std::string_view line) {
  constexpr std::string_view head = "RPRT ";
  if (!line.starts_with(head)) return std::nullopt;
  return parse_number<int>(line.substr(head.size()));
}

std::string_view meaning_of(int code) {
  constexpr std::array<std::string_view, 12> meanings{"done",
                                                      "invalid parameter",
                                                      "invalid configuration",
                                                      "out of memory",
                                                      "not implemented",
                                                      "the rotator does not answer",
                                                      "input/output error",
                                                      "internal error",
                                                      "protocol error",
                                                      "rejected by the rotator",
                                                      "argument truncated",
                                                      "not available"};
  const auto index = static_cast<std::size_t>(code <= 0 ? -static_cast<long>(code) : code);
  return index < meanings.size() ? meanings[index] : "an error";
}

std::string report_line(int code) { return "RPRT " + std::to_string(code) + '\n'; }

std::string position_line(double azimuth_rad, double elevation_rad) {
  return "P " + fixed(azimuth_rad / deg, 4) + ' ' + fixed(elevation_rad / deg, 4) + '\n';
}

std::string pointing_lines(double azimuth_rad, double elevation_rad) {
  return fixed(azimuth_rad / deg, 4) + '\n' + fixed(elevation_rad / deg, 4) + '\n';
}

std::string to_string(const Travel& travel) {
  std::array<char, 120> text{};
  std::snprintf(text.data(), text.size(), "azimuth %g to %g, elevation %g to %g deg", travel.azimuth_min_rad / deg,
                travel.azimuth_max_rad / deg, travel.elevation_min_rad / deg, travel.elevation_max_rad / deg);
  return text.data();
}

std::string state_lines(const Travel& travel) {
  constexpr std::string_view head = "1\n2\n";  // protocol, model: another rotctld
  return std::string(head) + "min_az=" + fixed(travel.azimuth_min_rad / deg, 6) +
         "\nmax_az=" + fixed(travel.azimuth_max_rad / deg, 6) + "\nmin_el=" + fixed(travel.elevation_min_rad / deg, 6) +
         "\nmax_el=" + fixed(travel.elevation_max_rad / deg, 6) + "\nsouth_zero=0\nrot_type=AzEl\ndone\n";
}

StateReply::Progress StateReply::add(std::string_view line) {
  const int index = lines_++;
  if (index < 2) {
    const std::optional<int> value = parse_number<int>(line);
    if (!value || *value < 0) return Progress::Wrong;
    (index == 0 ? protocol_ : model_) = *value;
    return Progress::More;
  }
  return protocol_ == 0 ? add_bare(line) : add_named(line);
}

StateReply::Progress StateReply::add_named(std::string_view line) {
  constexpr std::array<std::string_view, 4> names{"min_az", "max_az", "min_el", "max_el"};
  constexpr int most_lines = 64;
  if (line == "done") return Progress::Done;
  const std::size_t equals = line.find('=');
  if (equals == std::string_view::npos || lines_ > most_lines) return Progress::Wrong;
  for (std::size_t i = 0; i < names.size(); ++i)
    if (line.substr(0, equals) == names[i]) end_deg_[i] = parse_degrees(line.substr(equals + 1));
  return Progress::More;  // names that a later Hamlib adds are not needed
}

StateReply::Progress StateReply::add_bare(std::string_view line) {
  if (parse_report(line)) return Progress::Done;
  constexpr int first = 2;
  constexpr int ends = 4;
  const std::optional<double> value = parse_degrees(line);
  const int index = lines_ - 1 - first;
  if (!value || index > ends) return Progress::Wrong;  // the one behind the ends is south_zero
  if (index < ends) end_deg_[index] = value;
  return index + 1 < ends ? Progress::More : Progress::Enough;
}

std::optional<Travel> StateReply::travel() const {
  for (const auto& end : end_deg_)
    if (!end) return std::nullopt;
  if (!(*end_deg_[0] < *end_deg_[1]) || !(*end_deg_[2] < *end_deg_[3])) return std::nullopt;
  return Travel{*end_deg_[0] * deg, *end_deg_[1] * deg, *end_deg_[2] * deg, *end_deg_[3] * deg};
}

}  // namespace downrange::rotctl
