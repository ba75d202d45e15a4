#include "sim/toml_section.hpp"

#include <chrono>
#include <cmath>
#include <limits>
#include <sstream>

namespace downrange::sim {
namespace {

std::string range_text(const Limits& limits) {
  std::ostringstream text;
  const bool low = limits.low > -Limits::beyond_any;
  const bool high = limits.high < Limits::beyond_any;
  if (low && high) {
    text << limits.low << " to " << limits.high;
  } else if (low) {
    text << limits.low << " or more";
  } else {
    text << -Limits::beyond_any << " to " << Limits::beyond_any;
  }
  return text.str();
}

/// NaN where the node is no number. (toml++ gives nothing for a whole number that a double cannot hold exactly.)
double number_of(const toml::node& node) {
  if (const auto* whole = node.as_integer()) return static_cast<double>(whole->get());
  if (const auto* real = node.as_floating_point()) return real->get();
  return std::numeric_limits<double>::quiet_NaN();
}

}  // namespace

TomlSection::TomlSection(const toml::table& table, std::string file, std::string name)
    : table_(&table), file_(std::move(file)), name_(std::move(name)) {}

std::string TomlSection::path_of(std::string_view key) const {
  return name_.empty() ? std::string(key) : name_ + "." + std::string(key);
}

void TomlSection::fail(std::string_view key, const std::string& what) const {
  const toml::node* node = table_->get(key);
  const toml::source_region& source = node != nullptr ? node->source() : table_->source();
  std::ostringstream message;
  message << file_ << ":" << source.begin.line << ": " << path_of(key) << ": " << what;
  throw ScenarioError(message.str());
}

const toml::node& TomlSection::required(std::string_view key) {
  known_.emplace(key);
  const toml::node* node = table_->get(key);
  if (node == nullptr) fail(key, "is missing");
  return *node;
}

bool TomlSection::optional(std::string_view key) {
  known_.emplace(key);
  return table_->contains(key);
}

double TomlSection::number(std::string_view key, Limits limits) {
  const toml::node& node = required(key);
  if (!node.is_number()) fail(key, "must be a number, " + range_text(limits));
  const double value = number_of(node);
  if (!(limits.low <= value && value <= limits.high)) {
    std::ostringstream text;
    text << value << " is not allowed: " << range_text(limits);
    fail(key, text.str());
  }
  return value;
}

double TomlSection::number(std::string_view key, Limits limits, double fallback) {
  return optional(key) ? number(key, limits) : fallback;
}

std::string TomlSection::text(std::string_view key) {
  const auto value = required(key).value<std::string>();
  if (!value || value->empty()) fail(key, "must be a text in quotes, not empty");
  return *value;
}

bool TomlSection::flag(std::string_view key, bool fallback) {
  if (!optional(key)) return fallback;
  const toml::node& node = required(key);
  if (!node.is_boolean()) fail(key, "must be true or false");
  return *node.value<bool>();
}

std::vector<double> TomlSection::numbers(std::string_view key, Limits limits, std::vector<double> fallback) {
  if (!optional(key)) return fallback;
  const std::string expected = "must be a list of numbers, each " + range_text(limits) + ", such as [150.0, 290.0]";
  const toml::array* list = required(key).as_array();
  if (list == nullptr || list->empty()) fail(key, expected);
  std::vector<double> numbers;
  for (const toml::node& entry : *list) {
    const double value = number_of(entry);
    if (!(limits.low <= value && value <= limits.high)) fail(key, expected);
    numbers.push_back(value);
  }
  return numbers;
}

std::vector<std::string> TomlSection::texts(std::string_view key) {
  std::vector<std::string> texts;
  if (!optional(key)) return texts;
  const char* const expected = "must be a list of texts in quotes, none empty";
  const toml::array* list = required(key).as_array();
  if (list == nullptr) fail(key, expected);
  for (const toml::node& entry : *list) {
    const auto text = entry.value<std::string>();
    if (!entry.is_string() || !text || text->empty()) fail(key, expected);
    texts.push_back(*text);
  }
  return texts;
}

std::int64_t TomlSection::instant_ns(std::string_view key) {
  const toml::date_time* value = nullptr;
  if (const auto* node = required(key).as_date_time()) value = &node->get();
  if (value == nullptr || !value->offset)
    fail(key, "must be a date and time with offset, such as 2026-03-01T08:00:00Z");
  if (value->date.year < 1970 || value->date.year > 2100) fail(key, "must be in the years 1970 to 2100");
  const std::chrono::year_month_day date{std::chrono::year{value->date.year}, std::chrono::month{value->date.month},
                                         std::chrono::day{value->date.day}};
  const auto days = std::chrono::sys_days(date).time_since_epoch();
  const auto time_of_day = std::chrono::hours{value->time.hour} +
                           std::chrono::minutes{value->time.minute - value->offset->minutes} +
                           std::chrono::seconds{value->time.second};
  return std::chrono::nanoseconds(days + time_of_day).count() + value->time.nanosecond;
}

std::vector<std::pair<double, double>> TomlSection::windows(std::string_view key) {
  std::vector<std::pair<double, double>> windows;
  if (!optional(key)) return windows;
  const char* const expected = "must be a list of [from, to] with from < to, such as [[80.0, 103.0]]";
  const toml::array* list = required(key).as_array();
  if (list == nullptr) fail(key, expected);
  for (const toml::node& entry : *list) {
    const toml::array* pair = entry.as_array();
    if (pair == nullptr || pair->size() != 2) fail(key, expected);
    const double from = number_of(*pair->get(0));
    const double to = number_of(*pair->get(1));
    if (!(from < to) || !std::isfinite(from) || !std::isfinite(to)) fail(key, expected);
    windows.emplace_back(from, to);
  }
  return windows;
}

TomlSection TomlSection::section(std::string_view key) {
  const toml::table* table = required(key).as_table();
  if (table == nullptr) fail(key, "must be a table");
  return {*table, file_, path_of(key)};
}

std::vector<TomlSection> TomlSection::sections(std::string_view key) {
  std::vector<TomlSection> sections;
  if (!optional(key)) return sections;
  const toml::array* list = required(key).as_array();
  if (list == nullptr) fail(key, "must be a list of tables, each headed [[" + path_of(key) + "]]");
  for (const toml::node& entry : *list) {
    const toml::table* table = entry.as_table();
    if (table == nullptr) fail(key, "must be a list of tables, each headed [[" + path_of(key) + "]]");
    sections.emplace_back(*table, file_, path_of(key));
  }
  return sections;
}

void TomlSection::reject_unknown() const {
  std::string allowed;
  for (const std::string& key : known_) allowed += (allowed.empty() ? "" : ", ") + key;
  for (const auto& [key, node] : *table_)
    if (!known_.contains(key.str())) fail(key.str(), "is not a key of this table; allowed: " + allowed);
}

}  // namespace downrange::sim
