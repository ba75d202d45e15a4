#pragma once
/// Inside src/dds: wire types <-> events and results (wire_catalogue.hpp), stamps and the service's status.

#include "dds/inputs.hpp"
#include "dds/service_status.hpp"
#include "dds/wire_catalogue.hpp"

namespace downrange::dds {

void to_wire(const RangeStamp& from, wire::RangeStamp& to);
[[nodiscard]] RangeStamp from_wire(const wire::RangeStamp& from);

void to_wire(const ServiceStatus& from, wire::ServiceStatusV4& to);

[[nodiscard]] Defect from_wire(const wire::ServiceStatusV4& from, ServiceStatus& to);

}  // namespace downrange::dds
