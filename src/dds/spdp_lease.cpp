#include "dds/spdp_lease.hpp"

#include <algorithm>
#include <array>
#include <cstddef>
#include <optional>

namespace downrange::dds {
namespace {

using Bytes = std::span<std::uint8_t>;

constexpr std::size_t header_size = 20;
constexpr std::size_t submessage_header_size = 4;
constexpr std::uint8_t data_submessage = 0x15;
constexpr std::uint8_t little_endian_flag = 0x01;
constexpr std::uint8_t inline_qos_flag = 0x02;
constexpr std::array<std::uint8_t, 4> participant_announcer{0x00, 0x01, 0x00, 0xc2};
constexpr std::uint16_t sentinel = 0x0001;
constexpr std::uint16_t lease_parameter = 0x0002;

std::uint16_t number_at(Bytes bytes, std::size_t at, bool little_endian) {
  const unsigned low = bytes[at + (little_endian ? 0 : 1)];
  const unsigned high = bytes[at + (little_endian ? 1 : 0)];
  return static_cast<std::uint16_t>(high << 8U | low);
}

/// Calls `use(id, value)` for each parameter of a list; what follows its end, or nothing where it has none.
template <class Use>
std::optional<Bytes> for_each_parameter(Bytes list, bool little_endian, Use use) {
  while (list.size() >= 4) {
    const std::uint16_t id = number_at(list, 0, little_endian);
    const std::size_t length = number_at(list, 2, little_endian);
    list = list.subspan(4);
    if (id == sentinel) return list;
    if (length > list.size()) return std::nullopt;
    use(id, list.first(length));
    list = list.subspan(length);
  }
  return std::nullopt;
}

void put_duration(Bytes value, bool little_endian, std::int32_t seconds) {
  if (value.size() < 8) return;
  std::ranges::fill(value, std::uint8_t{0});  // the fraction with it
  const auto number = static_cast<std::uint32_t>(seconds);
  for (std::size_t i = 0; i < 4; ++i) {
    value[little_endian ? i : 3 - i] = static_cast<std::uint8_t>(number >> (8 * i));
  }
}

/// `content`: of a DATA submessage, behind its header.
void put_lease_in_data(Bytes content, std::uint8_t flags, std::int32_t seconds) {
  const bool little_endian = (flags & little_endian_flag) != 0;
  constexpr std::size_t to_inline_qos_at = 2;
  constexpr std::size_t writer_at = 8;
  if (content.size() < writer_at + 4) return;
  if (!std::ranges::equal(content.subspan(writer_at, 4), participant_announcer)) return;
  const std::size_t start = to_inline_qos_at + 2 + number_at(content, to_inline_qos_at, little_endian);
  if (start > content.size()) return;
  std::optional<Bytes> payload = content.subspan(start);
  if ((flags & inline_qos_flag) != 0) payload = for_each_parameter(*payload, little_endian, [](auto, Bytes) {});
  constexpr std::size_t encapsulation_size = 4;
  if (!payload || payload->size() < encapsulation_size || (*payload)[0] != 0) return;
  const std::uint8_t encapsulation = (*payload)[1];
  if (encapsulation != 0x02 && encapsulation != 0x03) return;  // a parameter list, big and little endian
  const bool little_endian_list = encapsulation == 0x03;
  for_each_parameter(payload->subspan(encapsulation_size), little_endian_list, [&](std::uint16_t id, Bytes value) {
    if (id == lease_parameter) put_duration(value, little_endian_list, seconds);
  });
}

}  // namespace

void put_lease(Bytes message, std::int32_t seconds) {
  constexpr std::array<std::uint8_t, 4> magic{'R', 'T', 'P', 'S'};
  if (message.size() < header_size || !std::ranges::equal(message.first(4), magic)) return;
  Bytes rest = message.subspan(header_size);
  while (rest.size() >= submessage_header_size) {
    const std::uint8_t id = rest[0];
    const std::uint8_t flags = rest[1];
    std::size_t length = number_at(rest, 2, (flags & little_endian_flag) != 0);
    rest = rest.subspan(submessage_header_size);
    if (length == 0 && id == data_submessage) length = rest.size();  // the last one may leave its length out
    if (length > rest.size()) return;
    if (id == data_submessage) put_lease_in_data(rest.first(length), flags, seconds);
    rest = rest.subspan(length);
  }
}

}  // namespace downrange::dds
