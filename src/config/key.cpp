#include "config/key.hpp"

#include <toml++/toml.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <numbers>
#include <sstream>

namespace downrange::config {
namespace {

constexpr double degree = std::numbers::pi / 180;

// Longest suffix first.
constexpr std::array units{
    Unit{"_deg_sqrt_s", "deg/sqrt(s)", degree},
    Unit{"_ms_sqrt_s", "ms/sqrt(s)", 1e-3},
    Unit{"_m_sqrt_s", "m/sqrt(s)", 1},
    Unit{"_sqrt_s", "1/sqrt(s)", 1},
    Unit{"_m2_s3", "m^2/s^3", 1},
    Unit{"_m2_s5", "m^2/s^5", 1},
    Unit{"_deg_s2", "deg/s^2", degree},
    Unit{"_deg_s", "deg/s", degree},
    Unit{"_m_s2", "m/s^2", 1},
    Unit{"_m_s", "m/s", 1},
    Unit{"_deg", "deg", degree},
    Unit{"_ms", "ms", 1e-3},
    Unit{"_hz", "Hz", 1},
    Unit{"_db", "dB", 1},
    Unit{"_s", "s", 1},
    Unit{"_m", "m", 1},
    Unit{"_n", "N-units", 1},
    Unit{"", "", 1},
};

std::string quoted_list(const std::vector<std::string>& texts, std::string_view separator) {
  std::string list;
  for (const std::string& text : texts) list += (list.empty() ? "" : std::string(separator)) + show_text(text);
  return list;
}

}  // namespace

Unit unit_of(std::string_view key) {
  return *std::ranges::find_if(units, [&](const Unit& unit) { return key.ends_with(unit.suffix); });
}

std::optional<double> read_number(const toml::node& node, Limits limits) {
  if (!node.is_number()) return std::nullopt;
  const std::optional<double> value = node.value<double>();
  // Written so that NaN is outside of every interval.
  if (!value || !(*value >= limits.min && *value <= limits.max)) return std::nullopt;
  return value;
}

std::optional<int> read_integer(const toml::node& node, Limits limits) {
  const auto* integer = node.as_integer();
  if (integer == nullptr) return std::nullopt;
  const auto value = static_cast<double>(integer->get());
  if (!(value >= limits.min && value <= limits.max)) return std::nullopt;
  return static_cast<int>(integer->get());
}

std::optional<bool> read_flag(const toml::node& node) { return node.value_exact<bool>(); }

std::optional<std::string> read_text(const toml::node& node) { return node.value_exact<std::string>(); }

bool is_id(std::string_view text) {
  const auto allowed = [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '.' || c == '_' ||
           c == '-';
  };
  return !text.empty() && text.size() <= Name::max_size && std::ranges::all_of(text, allowed);
}

std::optional<Name> read_id(const toml::node& node) {
  const auto text = read_text(node);
  if (!text || !is_id(*text)) return std::nullopt;
  return Name::parse(*text);
}

std::optional<std::vector<std::string>> read_texts(const toml::node& node) {
  const toml::array* array = node.as_array();
  if (array == nullptr) return std::nullopt;
  std::vector<std::string> texts;
  for (const toml::node& element : *array) {
    auto text = read_text(element);
    if (!text) return std::nullopt;
    texts.push_back(std::move(*text));
  }
  return texts;
}

std::optional<std::vector<Name>> read_ids(const toml::node& node) {
  const auto texts = read_texts(node);
  if (!texts || !std::ranges::all_of(*texts, is_id)) return std::nullopt;
  return std::vector<Name>(texts->begin(), texts->end());
}

std::string allowed_number(std::string_view key, Limits limits) {
  const std::string_view unit = unit_of(key).name;
  return "a number from " + show_number(limits.min) + " to " + show_number(limits.max) +
         (unit.empty() ? "" : " " + std::string(unit));
}

std::string allowed_integer(Limits limits) {
  return "a whole number from " + show_number(limits.min) + " to " + show_number(limits.max);
}

std::string allowed_choice(const std::vector<std::string_view>& choices) {
  return quoted_list({choices.begin(), choices.end()}, " or ");
}

std::string show_number(double value) {
  // 12 digits: a value brought to radians and back reads as it was written.
  std::array<char, 32> text{};
  std::snprintf(text.data(), text.size(), "%.12g", value);
  return text.data();
}

std::string show_text(std::string_view text) {
  std::string shown = "\"";
  for (const char c : text) {
    if (c == '"' || c == '\\') {
      shown += std::string("\\") + c;
    } else if (static_cast<unsigned char>(c) < 0x20 || c == 0x7F) {
      std::array<char, 8> escape{};
      std::snprintf(escape.data(), escape.size(), "\\u%04X", static_cast<unsigned>(c));
      shown += escape.data();
    } else {
      shown += c;
    }
  }
  return shown + '"';
}

std::string show_texts(const std::vector<std::string>& texts) { return '[' + quoted_list(texts, ", ") + ']'; }

std::string show_ids(const std::vector<Name>& ids) {
  std::vector<std::string> texts;
  texts.reserve(ids.size());
  for (const Name& name : ids) texts.emplace_back(name.view());
  return show_texts(texts);
}

std::string show_found(const toml::node& node) {
  if (node.is_table()) return "a table";
  if (node.is_array_of_tables()) return "an array of tables";
  if (const auto* number = node.as_floating_point()) return show_number(number->get());
  std::ostringstream text;
  text << toml::toml_formatter(node, toml::format_flags::none);
  std::string shown = text.str();
  if (shown.size() > 60) shown = shown.substr(0, 57) + "...";
  if (node.is_string()) return shown + " (text)";
  if (node.is_integer()) return shown + " (whole number)";
  if (node.is_boolean()) return shown + " (true/false)";
  if (node.is_array()) return shown + " (list)";
  return shown;
}

}  // namespace downrange::config
