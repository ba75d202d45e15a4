#pragma once
/// One table of a TOML file, read key by key; what is wrong is an error that names file, line, key and what is allowed.

#include <toml++/toml.h>

#include <set>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "sim/scenario_error.hpp"

namespace downrange::sim {

/// Inclusive limits of a number. By default what no length, angle or scale of a range comes near: finite in any unit.
struct Limits {
  static constexpr double beyond_any = 1e9;
  double low = -beyond_any;
  double high = beyond_any;
};

class TomlSection {
 public:
  /// `name` is how messages call the table; empty for the file's root. The table outlives the section.
  TomlSection(const toml::table& table, std::string file, std::string name);

  /// Whether the key, which may be absent, is there.
  [[nodiscard]] bool optional(std::string_view key);

  [[nodiscard]] double number(std::string_view key, Limits limits);
  [[nodiscard]] double number(std::string_view key, Limits limits, double fallback);
  [[nodiscard]] std::string text(std::string_view key);
  [[nodiscard]] bool flag(std::string_view key, bool fallback);
  /// A list of numbers, not empty; `fallback` when the key is absent.
  [[nodiscard]] std::vector<double> numbers(std::string_view key, Limits limits, std::vector<double> fallback);
  /// A list of texts; empty when the key is absent.
  [[nodiscard]] std::vector<std::string> texts(std::string_view key);
  /// With its UTC offset; nanoseconds since 1970.
  [[nodiscard]] std::int64_t instant_ns(std::string_view key);
  /// [[from, to], ...]; empty when the key is absent.
  [[nodiscard]] std::vector<std::pair<double, double>> windows(std::string_view key);
  [[nodiscard]] TomlSection section(std::string_view key);
  /// [[key]] tables; none when the key is absent.
  [[nodiscard]] std::vector<TomlSection> sections(std::string_view key);

  /// Throws for the first key that nobody read: most often a misspelling.
  void reject_unknown() const;

  [[noreturn]] void fail(std::string_view key, const std::string& what) const;

  /// Of the table's head.
  [[nodiscard]] int line() const { return static_cast<int>(table_->source().begin.line); }
  [[nodiscard]] const std::string& file() const { return file_; }

 private:
  const toml::node& required(std::string_view key);
  [[nodiscard]] std::string path_of(std::string_view key) const;

  const toml::table* table_;
  std::string file_;
  std::string name_;
  std::set<std::string, std::less<>> known_;
};

}  // namespace downrange::sim
