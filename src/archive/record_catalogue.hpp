#pragma once
/// The Protobuf message of each record of an archive, and the channels that carry them.

#include <archive.pb.h>

#include <archive/channels.hpp>
#include <downrange/stage/catalogue.hpp>

namespace downrange::archive {

template <class Record>
struct ProtoOf;
template <>
struct ProtoOf<MissionEvent> {
  using Message = record::MissionEvent;
};
template <>
struct ProtoOf<RadarTspi> {
  using Message = record::RadarTspi;
};
template <>
struct ProtoOf<GpsFix> {
  using Message = record::GpsFix;
};
template <>
struct ProtoOf<AngleTspi> {
  using Message = record::AngleTspi;
};
template <>
struct ProtoOf<OperatorCommand> {
  using Message = record::OperatorCommand;
};
template <>
struct ProtoOf<AntennaReport> {
  using Message = record::AntennaReport;
};
template <>
struct ProtoOf<PlatformState> {
  using Message = record::PlatformState;
};
template <>
struct ProtoOf<ClockGap> {
  using Message = record::ClockGap;
};
template <>
struct ProtoOf<Observation> {
  using Message = record::Observation;
};
template <>
struct ProtoOf<SensorBias> {
  using Message = record::SensorBias;
};
template <>
struct ProtoOf<Trajectory> {
  using Message = record::Trajectory;
};
template <>
struct ProtoOf<Integrity> {
  using Message = record::Integrity;
};
template <>
struct ProtoOf<SlavingCommand> {
  using Message = record::SlavingCommand;
};
template <>
struct ProtoOf<SourceHealth> {
  using Message = record::SourceHealth;
};
template <>
struct ProtoOf<LastTick> {
  using Message = record::LastTick;
};
template <>
struct ProtoOf<Truth> {
  using Message = record::Truth;
};

template <class Record>
using Proto = typename ProtoOf<Record>::Message;

}  // namespace downrange::archive
