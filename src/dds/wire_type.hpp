#pragma once
/// Inside src/dds: generated types made safe against any sender.

#include <downrangePubSubTypes.h>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <exception>
#include <limits>
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

/// Walks over the members of a payload in plain CDR: each is aligned to its size, counted from behind the
/// encapsulation.
class CdrWalk {
 public:
  explicit CdrWalk(const eprosima::fastrtps::rtps::SerializedPayload_t& payload)
      : data_(payload.data + encapsulation),
        size_(payload.length - encapsulation),
        little_endian_(payload.data[1] & 1) {}

  /// `count` members of `size` bytes each.
  CdrWalk& skip(std::uint32_t size, std::uint32_t count = 1) {
    at_ = (at_ + size - 1) / size * size + std::uint64_t{size} * count;
    return *this;
  }
  CdrWalk& skip_string() {
    const std::uint32_t length = read_length();
    at_ += length;
    return *this;
  }
  /// Of a string or sequence, which follows. Behind the payload's end: as long as can be.
  std::uint32_t read_length() {
    skip(4);
    if (at_ > size_) return std::numeric_limits<std::uint32_t>::max();
    std::uint32_t length = 0;
    for (std::uint32_t i = 0; i < 4; ++i)
      length |= std::uint32_t{data_[at_ - 4 + i]} << (8 * (little_endian_ ? i : 3 - i));
    return length;
  }

 private:
  static constexpr std::uint32_t encapsulation = 4;
  const std::uint8_t* data_;
  std::uint64_t size_;
  bool little_endian_;
  std::uint64_t at_ = 0;  ///< may run past the end, never over: lengths have 32 bits
};

/// The generated code resizes to whatever length the payload claims.
template <>
[[nodiscard]] inline bool lengths_in_bounds<wire::RangeClockV2>(
    const eprosima::fastrtps::rtps::SerializedPayload_t& payload) {
  return CdrWalk(payload).skip(8, 3).skip(1).read_length() <= 256;
}
template <>
[[nodiscard]] inline bool lengths_in_bounds<wire::IntegrityV3>(
    const eprosima::fastrtps::rtps::SerializedPayload_t& payload) {
  CdrWalk walk(payload);
  walk.skip_string().skip(8, 2).skip(1).skip_string().skip_string();  // target_id ... held_by
  return walk.skip(8).skip(1).skip(8).read_length() <= 64;            // bound_m, bound_valid, events
}
template <>
[[nodiscard]] inline bool lengths_in_bounds<wire::ImpactPointV3>(
    const eprosima::fastrtps::rtps::SerializedPayload_t& payload) {
  CdrWalk walk(payload);
  walk.skip_string().skip_string().skip(8, 2).skip(1);  // target_id ... impact_valid
  return walk.skip(8, 10).skip(1).read_length() <= 32;  // latitude_rad ... data_loss_limit_valid
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
