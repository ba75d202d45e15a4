#pragma once
/// Inside src/dds: wire types <-> events and results.
/// to_wire never fails. from_wire trusts nothing: a sample whose enumerators, sizes or names the types do not allow
/// gives the defect and leaves the target in an unspecified state. Numbers are not judged: that is ingest's work.

#include <downrange.h>

#include <downrange/stage/event.hpp>
#include <downrange/stage/result.hpp>
#include <string>

#include "dds/inputs.hpp"
#include "dds/service_status.hpp"

namespace downrange::dds {

/// Why a sample cannot be used; empty: it can.
using Defect = std::string;

void to_wire(const RangeStamp& from, wire::RangeStamp& to);
[[nodiscard]] RangeStamp from_wire(const wire::RangeStamp& from);

void to_wire(const RadarTspi& from, wire::RadarTspi& to);
void to_wire(const AngleTspi& from, wire::AngleTspi& to);
void to_wire(const GpsFix& from, wire::GpsFix& to);
void to_wire(const MissionEvent& from, wire::MissionEvent& to);
void to_wire(const Observation& from, wire::Observation& to);
void to_wire(const SensorBias& from, wire::SensorBias& to);
void to_wire(const Trajectory& from, wire::Trajectory& to);
void to_wire(const SlavingCommand& from, wire::SlavingCommand& to);
void to_wire(const SourceHealth& from, wire::SourceHealth& to);
void to_wire(const ServiceStatus& from, wire::ServiceStatus& to);

[[nodiscard]] Defect from_wire(const wire::RadarTspi& from, RadarTspi& to);
[[nodiscard]] Defect from_wire(const wire::AngleTspi& from, AngleTspi& to);
[[nodiscard]] Defect from_wire(const wire::GpsFix& from, GpsFix& to);
[[nodiscard]] Defect from_wire(const wire::MissionEvent& from, MissionEvent& to);
[[nodiscard]] Defect from_wire(const wire::Observation& from, Observation& to);
[[nodiscard]] Defect from_wire(const wire::SensorBias& from, SensorBias& to);
[[nodiscard]] Defect from_wire(const wire::Trajectory& from, Trajectory& to);
[[nodiscard]] Defect from_wire(const wire::SlavingCommand& from, SlavingCommand& to);
/// `node`: whose account it is.
[[nodiscard]] Defect from_wire(const wire::SourceHealth& from, SourceHealth& to, Name& node);
[[nodiscard]] Defect from_wire(const wire::ServiceStatus& from, ServiceStatus& to);

}  // namespace downrange::dds
