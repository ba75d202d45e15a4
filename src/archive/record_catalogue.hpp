#pragma once
/// Of each record of an archive: its Protobuf message, and the conversions to and from it. Doubles keep every bit.
///
/// to_proto fills a message that is used again and again: every field is set. A name that is not UTF-8 is written with
/// '?' for each foreign byte, because Protobuf would refuse to read it back. What from_proto returns is only of use
/// where `defect` stayed empty: names of at most 31 characters, enumerators that exist, arrays of the size their count
/// says.

#include <archive.pb.h>

#include <archive/channels.hpp>
#include <downrange/stage/catalogue.hpp>
#include <string>

namespace downrange::archive {

/// The first thing found wrong with a message; empty when all is right.
struct Defect {
  std::string what;
};

template <class Record>
struct ProtoOf;

template <>
struct ProtoOf<MissionEvent> {
  using Message = record::MissionEvent;
};
void to_proto(const MissionEvent& in, record::MissionEvent& out);
[[nodiscard]] MissionEvent from_proto(const record::MissionEvent& in, Defect& defect);

template <>
struct ProtoOf<RadarTspi> {
  using Message = record::RadarTspi;
};
void to_proto(const RadarTspi& in, record::RadarTspi& out);
[[nodiscard]] RadarTspi from_proto(const record::RadarTspi& in, Defect& defect);

template <>
struct ProtoOf<GpsFix> {
  using Message = record::GpsFix;
};
void to_proto(const GpsFix& in, record::GpsFix& out);
[[nodiscard]] GpsFix from_proto(const record::GpsFix& in, Defect& defect);

template <>
struct ProtoOf<AngleTspi> {
  using Message = record::AngleTspi;
};
void to_proto(const AngleTspi& in, record::AngleTspi& out);
[[nodiscard]] AngleTspi from_proto(const record::AngleTspi& in, Defect& defect);

template <>
struct ProtoOf<OperatorCommand> {
  using Message = record::OperatorCommand;
};
void to_proto(const OperatorCommand& in, record::OperatorCommand& out);
[[nodiscard]] OperatorCommand from_proto(const record::OperatorCommand& in, Defect& defect);

template <>
struct ProtoOf<AntennaReport> {
  using Message = record::AntennaReport;
};
void to_proto(const AntennaReport& in, record::AntennaReport& out);
[[nodiscard]] AntennaReport from_proto(const record::AntennaReport& in, Defect& defect);

template <>
struct ProtoOf<PlatformState> {
  using Message = record::PlatformState;
};
void to_proto(const PlatformState& in, record::PlatformState& out);
[[nodiscard]] PlatformState from_proto(const record::PlatformState& in, Defect& defect);

template <>
struct ProtoOf<ClockGap> {
  using Message = record::ClockGap;
};
void to_proto(const ClockGap& in, record::ClockGap& out);
[[nodiscard]] ClockGap from_proto(const record::ClockGap& in, Defect& defect);

template <>
struct ProtoOf<Observation> {
  using Message = record::Observation;
};
void to_proto(const Observation& in, record::Observation& out);
[[nodiscard]] Observation from_proto(const record::Observation& in, Defect& defect);

template <>
struct ProtoOf<SensorBias> {
  using Message = record::SensorBias;
};
void to_proto(const SensorBias& in, record::SensorBias& out);
[[nodiscard]] SensorBias from_proto(const record::SensorBias& in, Defect& defect);

template <>
struct ProtoOf<Trajectory> {
  using Message = record::Trajectory;
};
void to_proto(const Trajectory& in, record::Trajectory& out);
[[nodiscard]] Trajectory from_proto(const record::Trajectory& in, Defect& defect);

template <>
struct ProtoOf<Integrity> {
  using Message = record::Integrity;
};
void to_proto(const Integrity& in, record::Integrity& out);
[[nodiscard]] Integrity from_proto(const record::Integrity& in, Defect& defect);

template <>
struct ProtoOf<SlavingCommand> {
  using Message = record::SlavingCommand;
};
void to_proto(const SlavingCommand& in, record::SlavingCommand& out);
[[nodiscard]] SlavingCommand from_proto(const record::SlavingCommand& in, Defect& defect);

template <>
struct ProtoOf<AntennaAccount> {
  using Message = record::AntennaAccount;
};
void to_proto(const AntennaAccount& in, record::AntennaAccount& out);
[[nodiscard]] AntennaAccount from_proto(const record::AntennaAccount& in, Defect& defect);

template <>
struct ProtoOf<ImpactPoint> {
  using Message = record::ImpactPoint;
};
void to_proto(const ImpactPoint& in, record::ImpactPoint& out);
[[nodiscard]] ImpactPoint from_proto(const record::ImpactPoint& in, Defect& defect);

template <>
struct ProtoOf<SourceHealth> {
  using Message = record::SourceHealth;
};
void to_proto(const SourceHealth& in, record::SourceHealth& out);
[[nodiscard]] SourceHealth from_proto(const record::SourceHealth& in, Defect& defect);

template <>
struct ProtoOf<LastTick> {
  using Message = record::LastTick;
};
void to_proto(const LastTick& in, record::LastTick& out);
[[nodiscard]] LastTick from_proto(const record::LastTick& in, Defect& defect);

template <>
struct ProtoOf<Truth> {
  using Message = record::Truth;
};
void to_proto(const Truth& in, record::Truth& out);
[[nodiscard]] Truth from_proto(const record::Truth& in, Defect& defect);

template <class Record>
using Proto = typename ProtoOf<Record>::Message;

}  // namespace downrange::archive
