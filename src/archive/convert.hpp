#pragma once
/// Structs of the engine to and from their Protobuf messages. Doubles keep every bit.

#include <archive.pb.h>

#include <archive/record.hpp>
#include <string>

namespace downrange::archive {

/// Fill a message that is used again and again: every field is set. A name that is not UTF-8 is written with '?' for
/// each foreign byte, because Protobuf would refuse to read it back.
void to_proto(const RadarTspi& in, record::RadarTspi& out);
void to_proto(const GpsFix& in, record::GpsFix& out);
void to_proto(const AngleTspi& in, record::AngleTspi& out);
void to_proto(const MissionEvent& in, record::MissionEvent& out);
void to_proto(const OperatorCommand& in, record::OperatorCommand& out);
void to_proto(const AntennaReport& in, record::AntennaReport& out);
void to_proto(const PlatformState& in, record::PlatformState& out);
void to_proto(const Observation& in, record::Observation& out);
void to_proto(const SensorBias& in, record::SensorBias& out);
void to_proto(const Trajectory& in, record::Trajectory& out);
void to_proto(const Integrity& in, record::Integrity& out);
void to_proto(const SlavingCommand& in, record::SlavingCommand& out);
void to_proto(const SourceHealth& in, record::SourceHealth& out);
void to_proto(const ClockGap& in, record::ClockGap& out);
void to_proto(const LastTick& in, record::LastTick& out);
void to_proto(const Truth& in, record::Truth& out);

/// The first thing found wrong with a message; empty when all is right.
struct Defect {
  std::string what;
};

/// What comes back is only of use where `defect` stayed empty: names of at most 31 characters, enumerators that exist,
/// arrays of the size their count says.
[[nodiscard]] RadarTspi from_proto(const record::RadarTspi& in, Defect& defect);
[[nodiscard]] GpsFix from_proto(const record::GpsFix& in, Defect& defect);
[[nodiscard]] AngleTspi from_proto(const record::AngleTspi& in, Defect& defect);
[[nodiscard]] MissionEvent from_proto(const record::MissionEvent& in, Defect& defect);
[[nodiscard]] OperatorCommand from_proto(const record::OperatorCommand& in, Defect& defect);
[[nodiscard]] AntennaReport from_proto(const record::AntennaReport& in, Defect& defect);
[[nodiscard]] PlatformState from_proto(const record::PlatformState& in, Defect& defect);
[[nodiscard]] Observation from_proto(const record::Observation& in, Defect& defect);
[[nodiscard]] SensorBias from_proto(const record::SensorBias& in, Defect& defect);
[[nodiscard]] Trajectory from_proto(const record::Trajectory& in, Defect& defect);
[[nodiscard]] Integrity from_proto(const record::Integrity& in, Defect& defect);
[[nodiscard]] SlavingCommand from_proto(const record::SlavingCommand& in, Defect& defect);
[[nodiscard]] SourceHealth from_proto(const record::SourceHealth& in, Defect& defect);
[[nodiscard]] ClockGap from_proto(const record::ClockGap& in, Defect& defect);
[[nodiscard]] LastTick from_proto(const record::LastTick& in, Defect& defect);
[[nodiscard]] Truth from_proto(const record::Truth& in, Defect& defect);

}  // namespace downrange::archive
