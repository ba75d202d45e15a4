#pragma once
/// Reports on a key that is looked at together with others: at its line, or at that of the nearest table above it.

#include <toml++/toml.h>

#include <string>

#include "config/schema.hpp"

namespace downrange::config {

class Checker {
 public:
  Checker(const toml::table& root, const Report& report) : root_(root), report_(report) {}

  void require(bool holds, const std::string& path, const std::string& message) const {
    if (!holds) say(path, message);
  }
  void say(const std::string& path, const std::string& message) const { report_(node_at(path), path, message); }

  /// The file has this key.
  [[nodiscard]] bool given(const std::string& path) const { return toml::at_path(root_, path).node() != nullptr; }

 private:
  [[nodiscard]] const toml::node* node_at(std::string path) const {
    while (true) {
      if (const toml::node* node = toml::at_path(root_, path).node()) return node;
      const std::size_t dot = path.rfind('.');
      if (dot == std::string::npos) return nullptr;
      path.resize(dot);
    }
  }

  const toml::table& root_;
  const Report& report_;
};

/// "radar[0].id"
[[nodiscard]] inline std::string entry(const std::string& table, std::size_t index, const std::string& key) {
  return table + '[' + std::to_string(index) + "]." + key;
}

}  // namespace downrange::config
