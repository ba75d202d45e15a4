#pragma once
/// The channels of our archives: which topic carries which record. Made from the message catalogue.

#include <archive/bytes.hpp>
#include <archive/record.hpp>
#include <cstdint>
#include <downrange/stage/catalogue.hpp>
#include <optional>
#include <string_view>
#include <vector>

namespace downrange {

// Records of archives alone: no topic of the range carries them.
template <>
struct MessageInfo<archive::LastTick> {
  static constexpr std::string_view topic = "downrange/last_tick";
};
template <>
struct MessageInfo<archive::Truth> {
  static constexpr std::string_view topic = "sim/truth";
};

}  // namespace downrange

namespace downrange::archive {

using RecordKind = std::size_t;
template <class T>
inline constexpr RecordKind kind_of_record = Records::index_of<T>();

/// One MCAP channel. Two share the topic of observations: an event that a centre consumed must not be taken for a
/// result of it.
struct Channel {
  std::uint16_t id = 0;
  RecordKind kind = 0;
  Role role = Role::Input;
  std::string_view topic;

  [[nodiscard]] std::uint16_t schema_id() const { return static_cast<std::uint16_t>(1 + kind); }
};

/// All of them; a channel's id is 1 + its place.
[[nodiscard]] const std::vector<Channel>& channels();

/// The channel of a record in this role, which it must have.
template <class T>
[[nodiscard]] const Channel& channel_of(Role role) {
  static_assert(Records::contains<T>);
  for (const Channel& channel : channels()) {
    if (channel.kind == kind_of_record<T> && channel.role == role) return channel;
  }
  std::abort();
}

/// The role of a channel that does not state it, as in archives of other writers.
[[nodiscard]] Role usual_role(RecordKind kind);

/// The word of a channel's metadata key "role": "input", "output", "mark", "truth".
[[nodiscard]] std::string_view to_string(Role role);
[[nodiscard]] std::optional<Role> role_named(std::string_view name);

/// Full name of the Protobuf message, e.g. "downrange.record.RadarTspi".
[[nodiscard]] std::string_view schema_name(RecordKind kind);
/// The kind of records whose message has this full name.
[[nodiscard]] std::optional<RecordKind> kind_of_schema(std::string_view name);

/// Content of the MCAP Schema record, FileDescriptorSet included.
[[nodiscard]] Bytes schema_record(const Channel& channel);
/// Content of the MCAP Channel record.
[[nodiscard]] Bytes channel_record(const Channel& channel);

}  // namespace downrange::archive
