#include <archive/import/import_error.hpp>
#include <archive/import/mapping_section.hpp>
#include <chrono>
#include <cmath>
#include <text/printable.hpp>

namespace downrange::archive {

void MappingSection::fail(const std::string& key, const std::string& what) const {
  const toml::node* node = table_.get(key);
  const auto line = (node != nullptr ? node->source() : table_.source()).begin.line;
  throw ImportError(file_.string() + ":" + std::to_string(line) + ": " +
                    text::printable(prefix_ + key + ": " + what, false, 2000));
}

const toml::node* MappingSection::find(const std::string& key) {
  known_.insert(key);
  return table_.get(key);
}

std::optional<std::string> MappingSection::text(const std::string& key) {
  const toml::node* node = find(key);
  if (node == nullptr) return std::nullopt;
  if (const auto* value = node->as_string()) return value->get();
  fail(key, "must be a text in quotes");
}

std::string MappingSection::required_text(const std::string& key, const std::string& meaning) {
  const auto found = text(key);
  if (!found) fail(key, "missing: " + meaning);
  return *found;
}

std::optional<double> MappingSection::number(const std::string& key) {
  const toml::node* node = find(key);
  if (node == nullptr) return std::nullopt;
  const auto value = node->is_number() ? node->value<double>() : std::nullopt;
  if (!value || !std::isfinite(*value)) fail(key, "must be a finite number");
  return value;
}

std::optional<bool> MappingSection::flag(const std::string& key) {
  const toml::node* node = find(key);
  if (node == nullptr) return std::nullopt;
  if (const auto* value = node->as_boolean()) return value->get();
  fail(key, "must be true or false");
}

std::optional<Name> MappingSection::name(const std::string& key) {
  const auto found = text(key);
  if (!found) return std::nullopt;
  const auto parsed = Name::parse(*found);
  if (!parsed || parsed->empty()) fail(key, "must be a name of 1 to 31 characters");
  return parsed;
}

Name MappingSection::required_name(const std::string& key, const std::string& meaning) {
  const auto found = name(key);
  if (!found) fail(key, "missing: " + meaning);
  return *found;
}

std::optional<std::vector<std::string>> MappingSection::texts(const std::string& key, bool numbers) {
  const toml::node* node = find(key);
  if (node == nullptr) return std::nullopt;
  std::vector<std::string> found;
  const auto add = [&](const toml::node& value) {
    if (const auto* string = value.as_string()) {
      found.push_back(string->get());
    } else if (const auto* whole = value.as_integer(); whole != nullptr && numbers) {
      found.push_back(std::to_string(whole->get()));
    } else {
      fail(key, numbers ? "must be a text in quotes, a whole number, or a list of them"
                        : "must be a text in quotes or a list of texts");
    }
  };
  if (const toml::array* list = node->as_array()) {
    for (const toml::node& value : *list) add(value);
  } else {
    add(*node);
  }
  return found;
}

const toml::table* MappingSection::table(const std::string& key) {
  const toml::node* node = find(key);
  if (node == nullptr) return nullptr;
  if (const toml::table* found = node->as_table()) return found;
  fail(key, "must be a table");
}

void MappingSection::no_other_keys() const {
  for (const auto& [key, node] : table_) {
    const std::string name(key.str());
    if (known_.contains(name)) continue;
    std::string known;
    for (const std::string& k : known_) known += (known.empty() ? "" : ", ") + k;
    fail(name, "unknown key; allowed: " + known);
  }
}

std::optional<Time> time_of(const toml::date& date) {
  if (date.year < 1800 || date.year > 2160) return std::nullopt;
  const std::chrono::year_month_day day(std::chrono::year(date.year), std::chrono::month(date.month),
                                        std::chrono::day(date.day));
  const std::int64_t days = std::chrono::sys_days(day).time_since_epoch().count();
  return Time{days * 86'400'000'000'000};
}

std::optional<Time> time_of(const toml::date_time& moment) {
  const auto midnight = time_of(moment.date);
  if (!midnight || !moment.offset) return std::nullopt;
  const std::int64_t minutes = moment.time.hour * std::int64_t{60} + moment.time.minute - moment.offset->minutes;
  const std::int64_t seconds = minutes * 60 + moment.time.second;
  return Time{midnight->ns + seconds * 1'000'000'000 + moment.time.nanosecond};
}

}  // namespace downrange::archive
