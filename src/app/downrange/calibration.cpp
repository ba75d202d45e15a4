#include "calibration.hpp"

#include <algorithm>
#include <archive/reader.hpp>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <map>
#include <set>
#include <text/printable.hpp>

#include "command.hpp"
#include "config/calibration.hpp"

namespace downrange::app {
namespace {

/// The last bias of each sensor by one method and what was learnt of its noise, and which methods the archive has
/// biases of.
struct LastBiases {
  std::map<Name, SensorBias> by_sensor;
  std::map<Name, SigmaRatios> noise;
  std::set<Name> methods;
  bool cut_off = false;
};

LastBiases last_biases(const std::string& flight, const Name& method) {
  LastBiases last;
  archive::Reader reader(flight);
  while (const auto entry = reader.next()) {
    if (const auto* health = std::get_if<SourceHealth>(&entry->record))
      last.noise[health->sensor] = health->sigma_ratio;
    const auto* bias = std::get_if<SensorBias>(&entry->record);
    if (bias == nullptr) continue;
    last.methods.insert(bias->method);
    if (bias->method == method) last.by_sensor[bias->sensor] = *bias;
  }
  reader.raw().require_declared();
  last.cut_off = reader.truncated().has_value();
  return last;
}

std::string listed(const std::set<Name>& names) {
  std::string text;
  for (const Name& name : names) text += (text.empty() ? "" : ", ") + std::string(name.view());
  return text.empty() ? "none" : text;
}

}  // namespace

int write_calibration(const std::string& flight, const std::string& method, const std::string& out,
                      const config::ServiceConfig& config) {
  const Name wanted = method.empty() ? config.range.fuse.methods.front() : Name(method);
  LastBiases last = last_biases(flight, wanted);
  if (last.by_sensor.empty())
    throw std::runtime_error(flight + " holds no biases of method " + std::string(wanted.view()) +
                             "; it has biases of: " + listed(last.methods));
  std::vector<config::CalibratedSensor> sensors;
  for (const Source& source : SourceTable(config.range)) {
    if (source.kind == SourceKind::Telemetry) continue;  // has no bias
    const auto found = last.by_sensor.find(source.name);
    if (found == last.by_sensor.end()) {
      std::cerr << "downrange: no bias of " << source.name.view() << " in " << flight << ": left out\n";
    } else {
      sensors.push_back({source.kind, found->second, last.noise[source.name]});
    }
  }
  std::ofstream stream(out);
  stream << config::calibration_text(
      {.archive = std::filesystem::path(flight).filename().string(), .configuration = config.hash}, sensors);
  if (!stream.flush()) throw std::runtime_error(out + ": cannot be written");
  for (const auto& [kind, bias, ratios] : sensors) {
    const std::string noise = learnt_noise(kind, ratios);
    const auto shown = std::count(bias.state.begin(), bias.state.begin() + bias.terms, BiasState::Converged);
    std::cout << text::printable(bias.sensor.view()) << ": " << bias.terms << " terms after " << bias.samples
              << " plots, " << shown << " converged" << (noise.empty() ? "" : "; noise over configured: ") << noise
              << '\n';
  }
  std::cout << out << ": use it with calibration = \"" << out << "\" in a [[radar]] or [[angle_sensor]]\n";
  return last.cut_off ? exit_cut_off : exit_ok;
}

}  // namespace downrange::app
