#include "config/load.hpp"

#include <openssl/evp.h>
#include <toml++/toml.h>

#include <algorithm>
#include <array>
#include <cstdio>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <sstream>
#include <system_error>

#include "config/calibration.hpp"
#include "config/nominal.hpp"
#include "config/schema.hpp"
#include "text/file.hpp"
#include "text/parse_toml.hpp"
#include "text/printable.hpp"

namespace downrange::config {
namespace {

std::string sha256_hex(std::string_view text) {
  std::array<unsigned char, EVP_MAX_MD_SIZE> digest{};
  unsigned int size = 0;
  if (EVP_Digest(text.data(), text.size(), digest.data(), &size, EVP_sha256(), nullptr) != 1) {
    throw std::runtime_error("SHA-256 is not available from this OpenSSL");
  }
  std::string hex;
  for (unsigned int i = 0; i < size; ++i) {
    std::array<char, 3> byte{};
    std::snprintf(byte.data(), byte.size(), "%02x", digest[i]);
    hex += byte.data();
  }
  return hex;
}

int line_of(const toml::node* node) { return node == nullptr ? 0 : static_cast<int>(node->source().begin.line); }

/// Collects the problems of one file and says where each is.
class Problems {
 public:
  Problems(const std::filesystem::path& file, const Overrides& overrides)
      : file_(file.string()), overrides_(overrides) {}

  void add_at_line(int line, const std::string& key, const std::string& message) {
    list_.push_back({file_, line, key, message});
  }
  void add_option(const std::string& option, const std::string& key, const std::string& message) {
    list_.push_back({option, 0, key, message});
  }
  void add_of_file(const std::string& file, int line, const std::string& key, const std::string& message) {
    list_.push_back({file, line, key, message});
  }
  void add(const toml::node* node, const std::string& key, const std::string& message) {
    const auto from = std::ranges::find(overrides_, key, &Override::key);
    if (from != overrides_.end()) return add_option(from->option, key, message);
    add_at_line(line_of(node), key, message);
  }
  [[nodiscard]] Report report() {
    return
        [this](const toml::node* node, const std::string& key, const std::string& message) { add(node, key, message); };
  }

  void throw_if_any() {
    if (!list_.empty()) throw ConfigError(std::move(*this).in_order());
  }
  /// By line.
  [[nodiscard]] std::vector<Problem> in_order() && {
    std::ranges::stable_sort(list_, {}, &Problem::line);
    return std::move(list_);
  }

 private:
  std::string file_;
  const Overrides& overrides_;
  std::vector<Problem> list_;
};

std::string read_file(const std::filesystem::path& file) {
  try {
    return text::read_file(file, text::max_toml_size);
  } catch (const text::FileError& error) {
    throw ConfigError({{file.string(), 0, "", error.what()}});
  }
}

toml::table parse(std::string_view text, Problems& problems) {
  try {
    return text::parse_toml(text);
  } catch (const text::TomlError& error) {
    problems.add_at_line(error.line(), "", error.what());
    problems.throw_if_any();
    throw;
  }
}

const KeyInfo* find_key(const std::string& path) {
  for (const Section& section : schema()) {
    for (const KeyInfo& key : section.keys) {
      if (!section.many && path == section.name + '.' + key.name) return &key;
    }
  }
  return nullptr;
}

/// The override's value as a table with the one entry `value`.
std::optional<toml::table> parse_value(const Override& override, bool text) {
  if (text && !override.value.starts_with('"')) return toml::table{{"value", override.value}};
  try {
    toml::table parsed = text::parse_toml("value = " + override.value);
    if (parsed.size() == 1) return parsed;
  } catch (const text::TomlError&) {
    return std::nullopt;
  }
  return std::nullopt;
}

void apply(const Override& override, toml::table& root, Problems& problems) {
  const KeyInfo* key = find_key(override.key);
  if (key == nullptr) {
    std::vector<std::string> known;
    for (const Section& section : schema()) {
      for (const KeyInfo& info : section.keys) {
        if (!section.many) known.push_back(section.name + '.' + info.name);
      }
    }
    return problems.add_option(override.option, override.key, "unknown key" + suggestion(override.key, known));
  }
  const std::optional<toml::table> value = parse_value(override, key->text);
  if (!value) {
    return problems.add_option(override.option, override.key, "found " + override.value + ", allowed: " + key->allowed);
  }
  const std::size_t dot = override.key.find('.');
  const std::string section = override.key.substr(0, dot);
  if (!root.contains(section)) root.insert(section, toml::table{});
  // A section that is no table is reported when the tables are read.
  if (toml::table* table = root.get(section)->as_table()) table->insert_or_assign(key->name, *value->get("value"));
}

std::string effective_text(std::string_view text, const std::filesystem::path& file, const toml::table& root,
                           const Overrides& overrides, bool other_files) {
  if (overrides.empty() && !other_files) return std::string(text);
  std::ostringstream effective;
  effective << "# " << file.filename().string() << (other_files ? " with its calibrations and plans" : " with");
  for (const Override& override : overrides) effective << ' ' << override.key << " = " << override.value << ';';
  effective << '\n' << root << '\n';
  return effective.str();
}

void make_absolute(std::filesystem::path& path, const std::filesystem::path& base) {
  if (!path.empty()) path = (base / path).lexically_normal();
}

std::string found_file(const std::string& file, const std::string& why) { return "found \"" + file + "\", " + why; }

/// The sensor's table of a calibration file; nothing after a problem. `list`: "radar", "angle_sensor".
std::optional<toml::table> take_calibration(const std::filesystem::path& file, const std::string& list,
                                            const std::string& id, const std::function<void(const std::string&)>& fail,
                                            Problems& problems) {
  std::error_code error;
  if (!std::filesystem::is_regular_file(file, error)) {
    fail("no such file");
    return std::nullopt;
  }
  const Report report = [&](const toml::node* node, const std::string& key, const std::string& message) {
    problems.add_of_file(file.string(), line_of(node), key, message);
  };
  toml::table root;
  try {
    root = text::parse_toml(read_file(file));
  } catch (const text::TomlError& wrong) {
    problems.add_of_file(file.string(), wrong.line(), "", wrong.what());
    return std::nullopt;
  }
  toml::array* entries = root[list].as_array();
  for (std::size_t i = 0; entries != nullptr && i < entries->size(); ++i) {
    toml::table* table = entries->get(i)->as_table();
    if (table == nullptr || table->at_path("id").value_or(std::string()) != id) continue;
    if (!read_calibration(*table, list + '[' + std::to_string(i) + ']', report)) return std::nullopt;
    return std::move(*table);
  }
  fail("it has no [[" + list + "]] with id \"" + id + '"');
  return std::nullopt;
}

/// Puts the calibrations of one list of sensors where the file names other files. True when there were any.
bool inline_calibrations(toml::table& root, const std::string& list, const std::filesystem::path& base,
                         Problems& problems) {
  bool any = false;
  toml::array* entries = root[list].as_array();
  for (std::size_t i = 0; entries != nullptr && i < entries->size(); ++i) {
    toml::table* sensor = entries->get(i)->as_table();
    if (sensor == nullptr) continue;
    const std::string file = sensor->at_path("calibration").value_or(std::string());
    if (file.empty()) continue;
    const auto fail = [&](const std::string& why) {
      problems.add(sensor->get("calibration"), list + '[' + std::to_string(i) + "].calibration", found_file(file, why));
    };
    auto table = take_calibration(base / file, list, sensor->at_path("id").value_or(std::string()), fail, problems);
    if (!table) continue;
    sensor->insert_or_assign("calibration", std::move(*table));
    any = true;
  }
  return any;
}

/// So that the configuration in force is whole. True when there were any.
bool inline_calibrations(toml::table& root, const std::filesystem::path& base, Problems& problems) {
  const bool of_radars = inline_calibrations(root, "radar", base, problems);
  return inline_calibrations(root, "angle_sensor", base, problems) || of_radars;
}

/// Puts the rows of nominal trajectories where the file names other files. True when there were any.
bool inline_nominals(toml::table& root, const std::filesystem::path& base, Problems& problems) {
  constexpr std::uint64_t max_size = 16'000'000;
  bool any = false;
  toml::array* targets = root["target"].as_array();
  for (std::size_t i = 0; targets != nullptr && i < targets->size(); ++i) {
    toml::table* target = targets->get(i)->as_table();
    const std::string file = target == nullptr ? "" : target->at_path("nominal").value_or(std::string());
    if (file.empty()) continue;
    NominalFormat format;
    format.object = target->at_path("nominal_object").value_or(std::string());
    if (format.object.empty()) format.object = target->at_path("id").value_or(std::string());
    if (const toml::node* columns = target->get("nominal_columns")) {
      format.columns = read_texts(*columns).value_or(std::vector<std::string>());
    }
    try {
      const std::string text = text::read_file(base / file, max_size);
      const auto nominal = read_nominal_csv(text, format, [&](int line, const std::string& message) {
        problems.add_of_file((base / file).lexically_normal().string(), line, "", message);
      });
      if (!nominal) continue;
      target->insert_or_assign("nominal", rows_of(*nominal));
      any = true;
    } catch (const text::FileError& error) {
      problems.add(target->get("nominal"), "target[" + std::to_string(i) + "].nominal", found_file(file, error.what()));
    }
  }
  return any;
}

void check_profiles(const ServiceConfig& config, const toml::table& root, const Report& report) {
  std::error_code error;
  if (config.dds.profiles.empty() || std::filesystem::is_regular_file(config.dds.profiles, error)) return;
  report(toml::at_path(root, "dds.profiles").node(), "dds.profiles",
         found_file(config.dds.profiles.string(), "no such file"));
}

/// Whether a bus that cannot be used is a problem of the configuration, or of whoever talks on it.
enum class Bus : std::uint8_t { Maybe, Needed };

ServiceConfig load_parts(std::string_view text, const std::filesystem::path& file, const Overrides& overrides,
                         Bus bus) {
  Problems problems(file, overrides);
  toml::table root = parse(text, problems);
  for (const Override& override : overrides) apply(override, root, problems);
  const std::filesystem::path base = std::filesystem::absolute(file).parent_path();
  const bool calibrated = inline_calibrations(root, base, problems);
  const bool planned = inline_nominals(root, base, problems);

  ServiceConfig config;
  const Report report = problems.report();
  read_tables(config, root, report);
  cross_check(config, root, report);

  make_absolute(config.dds.profiles, base);
  make_absolute(config.archive.directory, base);
  make_absolute(config.log.file, base);
  Problems of_bus(file, overrides);
  check_profiles(config, root, bus == Bus::Needed ? report : of_bus.report());
  problems.throw_if_any();
  config.bus_problems = std::move(of_bus).in_order();
  Problems warnings(file, overrides);
  warn_about(config, root, warnings.report());
  config.warnings = std::move(warnings).in_order();

  config.file = file;
  config.text = effective_text(text, file, root, overrides, calibrated || planned);
  config.hash = sha256_hex(config.text);
  return config;
}

std::string what_of(const std::vector<Problem>& problems) {
  std::string text;
  for (const Problem& problem : problems) text += (text.empty() ? "" : "\n") + problem.to_string();
  return text;
}

}  // namespace

std::string Problem::to_string() const {
  return text::printable(where + (line > 0 ? ':' + std::to_string(line) : "") + ": " + (key.empty() ? "" : key + ": ") +
                         message);
}

ConfigError::ConfigError(std::vector<Problem> problems)
    : std::runtime_error(what_of(problems)), problems_(std::move(problems)) {}

ServiceConfig load(const std::filesystem::path& file, const Overrides& overrides) {
  return load_parts(read_file(file), file, overrides, Bus::Maybe);
}

ServiceConfig load_text(std::string_view text, const std::filesystem::path& name, const Overrides& overrides) {
  return load_parts(text, name, overrides, Bus::Maybe);
}

void require_dds(const ServiceConfig& config) {
  if (config.dds.profiles.empty())
    throw ConfigError(
        {{config.file.string(), 0, "dds",
          "missing, required by whatever talks on the bus: [dds] with profiles, the file of QoS profiles"}});
  if (!config.bus_problems.empty()) throw ConfigError(config.bus_problems);
}

std::vector<Problem> check(const std::filesystem::path& file) {
  try {
    static_cast<void>(load_parts(read_file(file), file, {}, Bus::Needed));
    return {};
  } catch (const ConfigError& error) {
    return error.problems();
  }
}

std::string key_reference() {
  std::ostringstream reference;
  for (const Section& section : schema()) {
    reference << heading(section) << "  " << section.help << '\n';
    for (std::size_t i = 0; i < section.keys.size(); ++i) {
      const KeyInfo& key = section.keys[i];
      reference << "  " << key.name << ": " << key.help << '\n'
                << "      " << key.allowed << "; "
                << (key.need == Need::Required ? "required" : "default " + section.defaults[i]) << '\n';
    }
    reference << '\n';
  }
  return reference.str();
}

std::vector<std::string> differences(const ServiceConfig& a, const ServiceConfig& b) {
  std::vector<std::string> changed;
  for (const Section& section : schema()) {
    const auto old_values = section.flatten(a);
    const auto new_values = section.flatten(b);
    if (old_values.size() != new_values.size()) {
      changed.push_back(section.name);
      continue;
    }
    for (std::size_t i = 0; i < old_values.size(); ++i) {
      if (old_values[i] != new_values[i]) changed.push_back(old_values[i].first);
    }
  }
  return changed;
}

}  // namespace downrange::config
