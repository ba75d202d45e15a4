#include "stage/slaving_notes.hpp"

#include <cmath>
#include <numbers>
#include <utility>

#include "stage/decimal.hpp"

namespace downrange {
namespace {

constexpr Duration told_after = milliseconds(1000);
constexpr double degree = std::numbers::pi / 180;
constexpr double worth_telling_rad = 0.05 * degree;

}  // namespace

std::string followed_text(const SlavingCommand& command) {
  const std::string chain = command.chain.empty() ? "" : " (" + std::string(command.chain.view()) + ')';
  switch (command.source) {
    case SlavingSource::Fused:
      return "the fused track" + chain;
    case SlavingSource::Coasting:
      return "the coasting track" + chain;
    case SlavingSource::SingleSensor:
      return "one source alone" + chain;
    case SlavingSource::Gps:
      return "GPS alone" + chain;
    case SlavingSource::Nominal:
      return "the nominal trajectory";
  }
  return {};
}

std::string SlavingNotes::change(const SlavingCommand& command) {
  const auto [place, first] = told_.try_emplace(command.antenna);
  Told& told = place->second;
  told.newest = command.tick;
  if (command.source != SlavingSource::Coasting) {
    told.coasts_since.reset();
  } else {
    if (!told.coasts_since) told.coasts_since = command.tick;
    if (told.commanded && command.tick - *told.coasts_since < told_after) return {};
  }
  const bool alone = command.source == SlavingSource::SingleSensor;
  const Name chain = alone ? command.chain : Name{};  // INTEGRITY tells of the others
  const bool commanded = std::exchange(told.commanded, true);
  if (commanded && told.source == command.source && told.chain == chain && told.target == command.target) return {};
  told.source = command.source;
  told.chain = chain;
  told.target = command.target;
  return std::string(command.antenna.view()) + " follows " + std::string(command.target.view()) + " by " +
         followed_text(command);
}

std::string SlavingNotes::mount_error(const SlavingCommand& command) {
  Told& told = told_[command.antenna];
  const double azimuth = command.mount_azimuth_rad;
  const double elevation = command.mount_elevation_rad;
  if (std::hypot(azimuth - told.mount_azimuth_rad, elevation - told.mount_elevation_rad) < worth_telling_rad) return {};
  told.mount_azimuth_rad = azimuth;
  told.mount_elevation_rad = elevation;
  const std::string antenna(command.antenna.view());
  if (azimuth == 0 && elevation == 0) return antenna + ": what its mount reads tells no pointing error any more";
  const auto deg = [](double angle_rad) {
    return std::string(decimal(angle_rad / degree, 2, true).view()) + " deg in ";
  };
  return antenna + ": its mount reads " + deg(azimuth) + "azimuth and " + deg(elevation) +
         "elevation when it is on its target; commands have that added";
}

std::vector<std::string> SlavingNotes::ends(Time now) {
  std::vector<std::string> sentences;
  for (auto& [antenna, told] : told_) {
    if (!told.commanded || now - told.newest < told_after) continue;
    told.commanded = false;
    told.coasts_since.reset();
    sentences.push_back(
        std::string(antenna.view()) +
        " has no command any more: nothing is left to follow, it was stopped, or its platform is not heard");
  }
  return sentences;
}

}  // namespace downrange
