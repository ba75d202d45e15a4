#include <algorithm>

#include "config/section.hpp"
#include "config/sections.hpp"

namespace downrange::config {
namespace {

using R = RotctlConfig;

bool is_host(const std::string& text) {
  constexpr std::size_t longest = 253;
  return !text.empty() && text.size() <= longest && std::ranges::all_of(text, [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '.' || c == '-' ||
           c == ':' || c == '_';
  });
}

Key<R> host_key() {
  return {{"host", "the name or address of a machine, as text", optional, "where the daemon runs", true},
          [](R& s, const toml::node& node) {
            auto value = read_text(node);
            const bool good = value && is_host(*value);
            if (good) s.host = std::move(*value);
            return good;
          },
          [](const R& s) { return show_text(s.host); }};
}

const std::vector<Key<R>>& keys() {
  static const std::vector<Key<R>> all{
      host_key(),
      integer("port", at(&R::port), {1, 65'535}, optional, "its TCP port"),
      number("rate_hz", at(&R::rate_hz), {0.1, 100}, optional,
             "positions a second, as many as the rotator takes; a slower one is sent fewer"),
      span("timeout_ms", at(&R::timeout), {50, 60'000}, optional,
           "an answer later than this: the connection is given up and made anew"),
  };
  return all;
}

}  // namespace

Section rotctl_section() {
  Section section = describe("antenna.rotctl",
                             "The antenna's rotator daemon (Hamlib's rotctld, or what speaks like it), for downrange "
                             "rotctl.",
                             keys());
  section.many = true;
  section.within = "antenna";
  section.read = [infos = section.keys](ServiceConfig& config, const toml::table& antenna, const std::string& entry,
                                        const Report& report) {
    const toml::node* node = antenna.get("rotctl");
    const toml::table* table = node == nullptr ? nullptr : node->as_table();
    if (table == nullptr) return;  // none, or a problem of the antenna's table
    const std::string path = entry + ".rotctl";
    check_key_names(infos, *table, path, report);
    R& rotctl = config.rotctl.emplace_back();
    if (const toml::node* id = antenna.get("id")) rotctl.antenna = read_id(*id).value_or(Name());
    read_keys(keys(), rotctl, *table, path, report);
  };
  section.flatten = [](const ServiceConfig& config) {
    std::vector<std::pair<std::string, std::string>> values;
    for (const R& rotctl : config.rotctl) {
      const auto antenna = std::ranges::find(config.range.antennas, rotctl.antenna, &AntennaConfig::id);
      const auto index = std::to_string(antenna - config.range.antennas.begin());
      for (const Key<R>& key : keys())
        values.emplace_back("antenna[" + index + "].rotctl." + key.info.name, key.show(rotctl));
    }
    return values;
  };
  return section;
}

}  // namespace downrange::config
