#pragma once
/// From the keys of a struct to a Section that does not know the struct.

#include <toml++/toml.h>

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "config/schema.hpp"

namespace downrange::config {

/// Problems of a table's keys against the schema: unknown ones, missing ones.
void check_key_names(const std::vector<KeyInfo>& keys, const toml::table& table, const std::string& path,
                     const Report& report);

template <class S>
void read_keys(const std::vector<Key<S>>& keys, S& s, const toml::table& table, const std::string& path,
               const Report& report) {
  for (const Key<S>& key : keys) {
    const toml::node* node = table.get(key.info.name);
    if (node != nullptr && !key.read(s, *node)) {
      report(node, path + '.' + key.info.name, "found " + show_found(*node) + ", allowed: " + key.info.allowed);
    }
  }
}

template <class S>
Section describe(std::string name, std::string help, const std::vector<Key<S>>& keys) {
  Section section;
  section.name = std::move(name);
  section.help = std::move(help);
  for (const Key<S>& key : keys) {
    section.keys.push_back(key.info);
    section.defaults.push_back(key.show(S{}));
  }
  return section;
}

/// [name]: the struct that `part` finds in the configuration.
template <class S>
Section single(std::string name, std::string help, S& (*part)(ServiceConfig&), std::vector<Key<S>> keys) {
  Section section = describe(std::move(name), std::move(help), keys);
  section.read = [=, infos = section.keys](ServiceConfig& config, const toml::table& table, const std::string& path,
                                           const Report& report) {
    check_key_names(infos, table, path, report);
    read_keys(keys, part(config), table, path, report);
  };
  section.flatten = [=, name = section.name](const ServiceConfig& config) {
    ServiceConfig copy = config;
    std::vector<std::pair<std::string, std::string>> values;
    values.reserve(keys.size());
    for (const Key<S>& key : keys) values.emplace_back(name + '.' + key.info.name, key.show(part(copy)));
    return values;
  };
  return section;
}

/// [name], which may be left out although keys of it are required.
template <class S>
Section absent_or_single(std::string name, std::string help, std::optional<S>& (*part)(ServiceConfig&),
                         std::vector<Key<S>> keys) {
  Section section = describe(std::move(name), std::move(help), keys);
  section.optional = true;
  section.read = [=, infos = section.keys](ServiceConfig& config, const toml::table& table, const std::string& path,
                                           const Report& report) {
    check_key_names(infos, table, path, report);
    read_keys(keys, part(config).emplace(), table, path, report);
  };
  section.flatten = [=, name = section.name](const ServiceConfig& config) {
    ServiceConfig copy = config;
    std::vector<std::pair<std::string, std::string>> values;
    if (const std::optional<S>& s = part(copy)) {
      for (const Key<S>& key : keys) values.emplace_back(name + '.' + key.info.name, key.show(*s));
    }
    return values;
  };
  return section;
}

/// [[name]]: entries of the list that `list` finds in the configuration.
template <class S>
Section many(std::string name, int at_least, std::string help, std::vector<S>& (*list)(ServiceConfig&),
             std::vector<Key<S>> keys) {
  Section section = describe(std::move(name), std::move(help), keys);
  section.many = true;
  section.at_least = at_least;
  section.read = [=, infos = section.keys](ServiceConfig& config, const toml::table& table, const std::string& path,
                                           const Report& report) {
    check_key_names(infos, table, path, report);
    read_keys(keys, list(config).emplace_back(), table, path, report);
  };
  section.flatten = [=, name = section.name](const ServiceConfig& config) {
    ServiceConfig copy = config;
    std::vector<std::pair<std::string, std::string>> values;
    int index = 0;
    for (const S& entry : list(copy)) {
      const std::string path = name + '[' + std::to_string(index++) + "].";
      for (const Key<S>& key : keys) values.emplace_back(path + key.info.name, key.show(entry));
    }
    return values;
  };
  return section;
}

}  // namespace downrange::config
