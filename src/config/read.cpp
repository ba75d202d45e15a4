/// Walks a parsed file by the schema.

#include <algorithm>
#include <numeric>

#include "config/section.hpp"

namespace downrange::config {
namespace {

std::size_t edit_distance(const std::string& a, const std::string& b) {
  std::vector<std::size_t> row(b.size() + 1);
  std::iota(row.begin(), row.end(), std::size_t{0});
  for (std::size_t i = 1; i <= a.size(); ++i) {
    std::size_t diagonal = row[0];
    row[0] = i;
    for (std::size_t j = 1; j <= b.size(); ++j) {
      const std::size_t above = row[j];
      row[j] = std::min({above + 1, row[j - 1] + 1, diagonal + (a[i - 1] == b[j - 1] ? 0 : 1)});
      diagonal = above;
    }
  }
  return row[b.size()];
}

void read_section(const Section& section, ServiceConfig& config, const toml::node& node, const Report& report) {
  const std::string wrong_kind = "found " + show_found(node) +
                                 ", allowed: " + (section.many ? "one or more tables headed " : "one table headed ") +
                                 heading(section);
  if (!section.many) {
    const toml::table* table = node.as_table();
    if (table == nullptr) return report(&node, section.name, wrong_kind);
    return section.read(config, *table, section.name, report);
  }
  const toml::array* entries = node.as_array();
  if (entries == nullptr) return report(&node, section.name, wrong_kind);
  int index = 0;
  for (const toml::node& entry : *entries) {
    const std::string path = section.name + '[' + std::to_string(index++) + ']';
    const toml::table* table = entry.as_table();
    if (table == nullptr) {
      report(&entry, path, "found " + show_found(entry) + ", allowed: a table");
    } else {
      section.read(config, *table, path, report);
    }
  }
}

/// What is wrong with the entries themselves is said where they are read.
void read_within(const Section& section, ServiceConfig& config, const toml::table& root, const Report& report) {
  const toml::node* node = root.get(section.within);
  const toml::array* entries = node == nullptr ? nullptr : node->as_array();
  for (std::size_t i = 0; entries != nullptr && i < entries->size(); ++i) {
    if (const toml::table* entry = entries->get(i)->as_table())
      section.read(config, *entry, section.within + '[' + std::to_string(i) + ']', report);
  }
}

}  // namespace

std::string heading(const Section& section) {
  const bool list = section.many && section.within.empty();
  return list ? "[[" + section.name + "]]" : '[' + section.name + ']';
}

std::string suggestion(const std::string& unknown, const std::vector<std::string>& known) {
  // The nearest name, if fewer than half of its letters would have to change.
  std::string best;
  std::size_t best_distance = std::min<std::size_t>(unknown.size(), 200) / 2 + 1;
  if (unknown.size() > 200) return {};
  for (const std::string& name : known) {
    const std::size_t distance = edit_distance(unknown, name);
    if (distance < best_distance) {
      best = name;
      best_distance = distance;
    }
  }
  return best.empty() ? "" : ", did you mean " + best + '?';
}

void check_key_names(const std::vector<KeyInfo>& keys, const toml::table& table, const std::string& path,
                     const Report& report) {
  std::vector<std::string> known;
  known.reserve(keys.size());
  for (const KeyInfo& key : keys) known.push_back(key.name);
  // Tables of their own within this one.
  const auto inner_name = [&](const Section& section) {
    const bool here = !section.within.empty() && path.starts_with(section.within + '[');
    return here ? section.name.substr(section.within.size() + 1) : std::string();
  };
  for (const Section& section : schema()) {
    const std::string name = inner_name(section);
    if (name.empty()) continue;
    known.push_back(name);
    const toml::node* node = table.get(name);
    if (node != nullptr && !node->is_table())
      report(node, std::string(path).append(".").append(name),
             "found " + show_found(*node) + ", allowed: one table headed " + heading(section));
  }
  for (const auto& [key, node] : table) {
    const std::string name(key.str());
    if (std::ranges::find(known, name) == known.end()) {
      report(&node, std::string(path).append(".").append(name), "unknown key" + suggestion(name, known));
    }
  }
  for (const KeyInfo& key : keys) {
    if (key.need == Need::Required && !table.contains(key.name)) {
      report(&table, path + '.' + key.name, "missing, required: " + key.allowed + " (" + key.help + ')');
    }
  }
}

void read_tables(ServiceConfig& config, const toml::table& root, const Report& report) {
  std::vector<std::string> known;
  for (const Section& section : schema())
    if (section.within.empty()) known.push_back(section.name);
  for (const auto& [key, node] : root) {
    const std::string name(key.str());
    if (std::ranges::find(known, name) == known.end()) {
      report(
          &node, name,
          (node.is_table() || node.is_array_of_tables() ? "unknown table" : "unknown key") + suggestion(name, known));
    }
  }
  for (const Section& section : schema()) {
    if (!section.within.empty()) {
      read_within(section, config, root, report);
      continue;
    }
    const toml::node* node = root.get(section.name);
    if (node != nullptr) read_section(section, config, *node, report);
    const bool keys_required = std::ranges::any_of(section.keys, [](const KeyInfo& k) { return k.need == required; });
    const bool needed = section.many ? section.at_least > 0 : keys_required && !section.optional;
    const bool empty = node == nullptr || (node->is_array() && node->as_array()->empty());
    if (needed && empty)
      report(node, section.name, "missing, required: " + heading(section) + " (" + section.help + ')');
  }
}

}  // namespace downrange::config
