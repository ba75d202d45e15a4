#pragma once
/// Inside src/dds: generated types made safe against any sender.

#include <downrangePubSubTypes.h>
#include <cstddef>
#include <cstring>
#include <exception>
#include <type_traits>

namespace downrange::dds {

/// What a reader's buffer holds.
template <class Wire>
struct WireSample {
  Wire value;
  bool intact = true;  ///< false: the payload was not in the type's format, `value` is to be ignored
};

/// Whether the payload's sequence lengths are within the type's bounds; types without sequences: yes.
template <class Wire>
[[nodiscard]] bool lengths_in_bounds(const eprosima::fastrtps::rtps::SerializedPayload_t&) {
  return true;
}

/// The generated code resizes to whatever length the payload claims. The members before it have fixed sizes.
template <>
[[nodiscard]] inline bool lengths_in_bounds<wire::RangeClockV2>(
    const eprosima::fastrtps::rtps::SerializedPayload_t& payload) {
  constexpr std::uint32_t offset = 4 + 28;  // encapsulation; run_id, step, time_ns, end and padding
  if (payload.length < offset + 4) return false;
  const bool little_endian = (payload.data[1] & 1) != 0;
  std::uint32_t length = 0;
  for (std::uint32_t i = 0; i < 4; ++i) {
    length |= std::uint32_t{payload.data[offset + i]} << (8 * (little_endian ? i : 3 - i));
  }
  return length <= 256;
}

/// Generated (de)serialisation throws on some malformed payloads, and a sample that fails to deserialise would stay
/// in the history: here it always succeeds and says whether the sample is intact.
template <class PubSubType>
class WireType final : public PubSubType {
 public:
  using Wire = typename PubSubType::type;
  using Payload = eprosima::fastrtps::rtps::SerializedPayload_t;
  // Writers pass a Wire, readers a WireSample: both begin with the Wire.
  static_assert(std::is_standard_layout_v<WireSample<Wire>> && offsetof(WireSample<Wire>, value) == 0);

  bool deserialize(Payload* payload, void* data) override {
    auto* sample = static_cast<WireSample<Wire>*>(data);
    try {
      sample->intact =
          payload->length >= 4 && lengths_in_bounds<Wire>(*payload) && PubSubType::deserialize(payload, &sample->value);
    } catch (const std::exception&) {
      sample->intact = false;
    }
    return true;
  }
  void* createData() override { return new WireSample<Wire>; }
  void deleteData(void* data) override { delete static_cast<WireSample<Wire>*>(data); }
};

}  // namespace downrange::dds
