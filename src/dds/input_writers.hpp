#pragma once
/// Inside src/dds: the writers of the inputs, whose readers the range clock driver must know.

#include "dds/entities.hpp"
#include "dds/input_topic.hpp"
#include "dds/inputs.hpp"

namespace downrange::dds {

class InputWriters::Impl {
 public:
  explicit Impl(Participant& participant);

  [[nodiscard]] bool write(const Event& event, const RangeStamp& stamp);

  [[nodiscard]] const Peers& readers(InputTopic topic) const;

  Tally<WriteCounts> tally;

 private:
  TopicWriter<wire::MissionEventPubSubType> mission_;
  TopicWriter<wire::RadarTspiPubSubType> radar_;
  TopicWriter<wire::AngleTspiPubSubType> angles_;
  TopicWriter<wire::GpsFixPubSubType> gps_;
  wire::MissionEvent mission_sample_;
  wire::RadarTspi radar_sample_;
  wire::AngleTspi angles_sample_;
  wire::GpsFix gps_sample_;
};

}  // namespace downrange::dds
