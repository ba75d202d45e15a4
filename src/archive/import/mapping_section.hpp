#pragma once
/// One table of a mapping while it is read: gives its keys one by one; what is left over is unknown.

#include <toml++/toml.h>

#include <cstdint>
#include <downrange/geo/name.hpp>
#include <downrange/geo/time.hpp>
#include <filesystem>
#include <optional>
#include <set>
#include <string>
#include <vector>

namespace downrange::archive {

class MappingSection {
 public:
  /// `prefix` stands before a key in messages: "file[0].columns.". File and table outlive the section.
  MappingSection(const std::filesystem::path& file, const toml::table& table, std::string prefix)
      : file_(file), table_(table), prefix_(std::move(prefix)) {}

  /// Throws ImportError with file, line and key.
  [[noreturn]] void fail(const std::string& key, const std::string& what) const;
  [[nodiscard]] const toml::node* find(const std::string& key);

  // Nothing where the key is absent; fail() where its value is of another kind.
  [[nodiscard]] std::optional<std::string> text(const std::string& key);
  [[nodiscard]] std::string required_text(const std::string& key, const std::string& meaning);
  [[nodiscard]] std::optional<double> number(const std::string& key);
  [[nodiscard]] std::optional<bool> flag(const std::string& key);
  [[nodiscard]] std::optional<Name> name(const std::string& key);
  [[nodiscard]] Name required_name(const std::string& key, const std::string& meaning);
  /// One text or a list of texts; no number passes for a text unless `numbers`.
  [[nodiscard]] std::optional<std::vector<std::string>> texts(const std::string& key, bool numbers = false);
  /// The table `key`.
  [[nodiscard]] const toml::table* table(const std::string& key);

  void no_other_keys() const;

  [[nodiscard]] const std::filesystem::path& file() const { return file_; }
  [[nodiscard]] const std::string& prefix() const { return prefix_; }

 private:
  const std::filesystem::path& file_;
  const toml::table& table_;
  std::string prefix_;
  std::set<std::string> known_;
};

/// Nothing for the years before 1800 and after 2160, and for a date and time without its offset from UTC. A date alone
/// is its midnight UTC.
[[nodiscard]] std::optional<Time> time_of(const toml::date_time& moment);
[[nodiscard]] std::optional<Time> time_of(const toml::date& date);

}  // namespace downrange::archive
