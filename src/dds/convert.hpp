#pragma once
/// Inside src/dds: wire types <-> events and results.
/// to_wire never fails. from_wire trusts nothing: a sample whose enumerators, sizes or names the types do not allow
/// gives the defect and leaves the target in an unspecified state. Numbers are not judged: that is ingest's work.

#include <string>

#include "dds/inputs.hpp"
#include "dds/service_status.hpp"
#include "dds/wire_catalogue.hpp"

namespace downrange::dds {

/// Why a sample cannot be used; empty: it can.
using Defect = std::string;

void to_wire(const RangeStamp& from, wire::RangeStamp& to);
[[nodiscard]] RangeStamp from_wire(const wire::RangeStamp& from);

void to_wire(const RadarTspi& from, Wire<RadarTspi>& to);
void to_wire(const AngleTspi& from, Wire<AngleTspi>& to);
void to_wire(const GpsFix& from, Wire<GpsFix>& to);
void to_wire(const MissionEvent& from, Wire<MissionEvent>& to);
void to_wire(const OperatorCommand& from, Wire<OperatorCommand>& to);
void to_wire(const AntennaReport& from, Wire<AntennaReport>& to);
void to_wire(const PlatformState& from, Wire<PlatformState>& to);
void to_wire(const Observation& from, Wire<Observation>& to);
void to_wire(const SensorBias& from, Wire<SensorBias>& to);
void to_wire(const Trajectory& from, Wire<Trajectory>& to);
void to_wire(const Integrity& from, Wire<Integrity>& to);
void to_wire(const SlavingCommand& from, Wire<SlavingCommand>& to);
void to_wire(const SourceHealth& from, Wire<SourceHealth>& to);
void to_wire(const ServiceStatus& from, wire::ServiceStatusV3& to);

[[nodiscard]] Defect from_wire(const Wire<RadarTspi>& from, RadarTspi& to);
[[nodiscard]] Defect from_wire(const Wire<AngleTspi>& from, AngleTspi& to);
[[nodiscard]] Defect from_wire(const Wire<GpsFix>& from, GpsFix& to);
[[nodiscard]] Defect from_wire(const Wire<MissionEvent>& from, MissionEvent& to);
[[nodiscard]] Defect from_wire(const Wire<OperatorCommand>& from, OperatorCommand& to);
[[nodiscard]] Defect from_wire(const Wire<AntennaReport>& from, AntennaReport& to);
[[nodiscard]] Defect from_wire(const Wire<PlatformState>& from, PlatformState& to);
[[nodiscard]] Defect from_wire(const Wire<Observation>& from, Observation& to);
[[nodiscard]] Defect from_wire(const Wire<SensorBias>& from, SensorBias& to);
[[nodiscard]] Defect from_wire(const Wire<Trajectory>& from, Trajectory& to);
[[nodiscard]] Defect from_wire(const Wire<Integrity>& from, Integrity& to);
[[nodiscard]] Defect from_wire(const Wire<SlavingCommand>& from, SlavingCommand& to);
/// Counts of reasons that this program does not know are left out.
[[nodiscard]] Defect from_wire(const Wire<SourceHealth>& from, SourceHealth& to);
[[nodiscard]] Defect from_wire(const wire::ServiceStatusV3& from, ServiceStatus& to);

}  // namespace downrange::dds
