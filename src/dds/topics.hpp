#pragma once
/// Topic names: also the names of their QoS profiles.

namespace downrange::dds::topics {

inline constexpr const char* radar_tspi = "range/radar_tspi";
inline constexpr const char* angles = "range/angles";
inline constexpr const char* gps = "range/gps";
inline constexpr const char* mission = "range/mission";
inline constexpr const char* clock = "range/clock";
inline constexpr const char* clock_ack = "downrange/clock_ack";
inline constexpr const char* ingest_progress = "downrange/ingest_progress";
inline constexpr const char* observation = "downrange/observation";
inline constexpr const char* bias = "downrange/bias";
inline constexpr const char* trajectory = "downrange/trajectory";
inline constexpr const char* slaving = "downrange/slaving";
inline constexpr const char* health = "downrange/health";
inline constexpr const char* status = "downrange/status";

}  // namespace downrange::dds::topics
