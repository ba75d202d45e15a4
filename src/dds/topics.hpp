#pragma once
/// Inside src/dds: the topics that are not messages of stage/catalogue.hpp, and the list of all. By these nodes tell
/// each other of themselves: they are no part of a flight, and no archive holds them as messages. downrange/impact has
/// a type in the IDL; no stage makes it yet.

#include <downrange/stage/catalogue.hpp>
#include <vector>

namespace downrange::dds {

namespace topics {
inline constexpr const char* clock = "range/clock";
inline constexpr const char* clock_ack = "downrange/clock_ack";
inline constexpr const char* ingest_progress = "downrange/ingest_progress";
inline constexpr const char* status = "downrange/status";
}  // namespace topics

struct Topic {
  const char* name;
  Delivery delivery;
};

/// Every topic that a program of ours reads or writes.
[[nodiscard]] const std::vector<Topic>& all_topics();

}  // namespace downrange::dds
