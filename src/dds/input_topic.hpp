#pragma once
/// Inside src/dds: the topics that carry the inputs of a range, and the stream that an input belongs to.

#include <downrange.h>

#include <array>
#include <cstdint>
#include <downrange/stage/event.hpp>
#include <optional>
#include <utility>

#include "dds/topics.hpp"

namespace downrange::dds {

/// As wire::InputTopic.
enum class InputTopic : std::uint8_t { Mission, RadarTspi, Gps, Angles };
inline constexpr std::array input_topics{InputTopic::Mission, InputTopic::RadarTspi, InputTopic::Gps,
                                         InputTopic::Angles};
static_assert(int(InputTopic::Angles) == int(wire::INPUT_ANGLES) && input_topics.size() == wire::INPUT_ANGLES + 1);

[[nodiscard]] constexpr const char* name_of(InputTopic topic) {
  constexpr std::array<const char*, input_topics.size()> names{topics::mission, topics::radar_tspi, topics::gps,
                                                               topics::angles};
  return names.at(static_cast<std::size_t>(topic));
}

/// In ClockAck.topics.
[[nodiscard]] constexpr unsigned bit_of(InputTopic topic) { return 1U << static_cast<unsigned>(topic); }

/// The topic and the source of an input. Nothing of an observation, which an ingest node makes.
[[nodiscard]] inline std::optional<std::pair<InputTopic, Name>> stream_of(const Event& event) {
  if (const auto* plot = std::get_if<RadarTspi>(&event)) return std::pair{InputTopic::RadarTspi, plot->sensor};
  if (const auto* angles = std::get_if<AngleTspi>(&event)) return std::pair{InputTopic::Angles, angles->sensor};
  if (const auto* fix = std::get_if<GpsFix>(&event)) return std::pair{InputTopic::Gps, fix->station};
  if (const auto* mark = std::get_if<MissionEvent>(&event)) return std::pair{InputTopic::Mission, mark->mission};
  return std::nullopt;
}

}  // namespace downrange::dds
