#include "command.hpp"

#include <charconv>
#include <cmath>
#include <filesystem>
#include <sstream>

namespace downrange::app {
namespace {

/// By whatever links and detours the names lead there; also for files that do not exist yet.
bool same_file(const std::string& a, const std::string& b) {
  std::error_code error;
  if (std::filesystem::equivalent(a, b, error)) return true;
  const auto full_a = std::filesystem::weakly_canonical(a, error);
  return !error && full_a == std::filesystem::weakly_canonical(b, error) && !error;
}

bool is_device(const std::string& path) {
  std::error_code error;
  const auto status = std::filesystem::status(path, error);
  return std::filesystem::exists(status) && !std::filesystem::is_regular_file(status);
}

}  // namespace

void OutputFiles::add_to(CLI::App& command) {
  command.add_flag("--force", force, "Write over a file that exists (never over one that is read)");
}

void OutputFiles::check(const std::vector<std::string>& outputs, const std::vector<std::string>& inputs) const {
  for (std::size_t i = 0; i < outputs.size(); ++i) {
    const std::string& output = outputs[i];
    if (output.empty() || is_device(output)) continue;
    for (const std::string& input : inputs) {
      if (!input.empty() && same_file(output, input))
        throw std::runtime_error(output + ": is read as well (" + input + "): write to another file");
    }
    for (std::size_t k = 0; k < i; ++k) {
      if (!outputs[k].empty() && same_file(output, outputs[k]))
        throw std::runtime_error(output + ": shall be written twice: name two files");
    }
    std::error_code error;
    if (!force && std::filesystem::is_regular_file(output, error))
      throw std::runtime_error(output + ": exists already; --force writes over it");
  }
}

bool OutputFiles::overwrite(const std::string& output) const { return force || is_device(output); }

void DdsOptions::add_to(CLI::App& command) {
  command.add_option("--domain", domain, "DDS domain, 0 to 232 (default: the configuration's)");
  command.add_option("--clock", clock, "wall or range (default: the configuration's)")
      ->check(CLI::IsMember({"wall", "range"}));
  command.add_option("--set", set, "Replace any key of the configuration, e.g. ingest.expect_simulated=true")
      ->type_name("KEY=VALUE");
}

config::Overrides DdsOptions::overrides() const {
  config::Overrides overrides;
  if (domain) overrides.push_back({"dds.domain", std::to_string(*domain), "--domain"});
  if (clock) overrides.push_back({"clock.mode", *clock, "--clock"});
  for (const std::string& assignment : set) {
    const std::size_t equals = assignment.find('=');
    const std::string value = equals == std::string::npos ? "" : assignment.substr(equals + 1);
    overrides.push_back({assignment.substr(0, equals), value, "--set"});
  }
  return overrides;
}

dds::ParticipantOptions participant_options(const config::ServiceConfig& config, const Name& node) {
  config::require_dds(config);
  return {.domain = config.dds.domain,
          .profiles = config.dds.profiles,
          .node = node,
          .clock = config.clock.mode == config::ClockMode::Range ? dds::ClockMode::Range : dds::ClockMode::Wall};
}

double parse_rate(const std::string& text) {
  if (text == "max") return 0;
  double rate = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), rate);
  if (error != std::errc() || end != text.data() + text.size() || !(rate > 0) || !std::isfinite(rate))
    throw CLI::ValidationError("--rate", "'" + text + "': allowed are a positive number or max");
  return rate;
}

std::vector<Name> parse_names(const std::string& text) {
  std::vector<Name> names;
  std::istringstream in(text);
  for (std::string part; std::getline(in, part, ',');) {
    const auto name = Name::parse(part);
    if (!name || name->empty())
      throw CLI::ValidationError("'" + part + "' in '" + text + "': a name has 1 to 31 characters");
    names.push_back(*name);
  }
  return names;
}

}  // namespace downrange::app
