#pragma once
/// Inside src/dds: the writers of the inputs, whose readers the range clock driver must know.

#include "dds/entities.hpp"
#include "dds/inputs.hpp"

namespace downrange::dds {

class InputWriters::Impl {
 public:
  explicit Impl(Participant& participant);

  [[nodiscard]] bool write(const Event& event, const RangeStamp& stamp);

  Tally<WriteCounts> tally;
  TopicWriter<wire::MissionEventPubSubType> mission;
  TopicWriter<wire::RadarTspiPubSubType> radar;
  TopicWriter<wire::GpsFixPubSubType> gps;

 private:
  wire::MissionEvent mission_sample_;
  wire::RadarTspi radar_sample_;
  wire::GpsFix gps_sample_;
};

}  // namespace downrange::dds
