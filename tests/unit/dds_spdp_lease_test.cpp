/// The lease in participants' announcements: found in both byte orders, behind other submessages and inline QoS;
/// nothing else is changed, and nothing outside of a malformed message is touched.

#include <gtest/gtest.h>

#include <cstdint>
#include <random>
#include <vector>

#include "dds/spdp_lease.hpp"

namespace downrange::dds {
namespace {

using Bytes = std::vector<std::uint8_t>;

void append(Bytes& to, const Bytes& more) { to.insert(to.end(), more.begin(), more.end()); }

Bytes number(std::uint32_t value, std::size_t size, bool little) {
  Bytes bytes(size);
  for (std::size_t i = 0; i < size; ++i) bytes[little ? i : size - 1 - i] = static_cast<std::uint8_t>(value >> (8 * i));
  return bytes;
}

Bytes parameter(std::uint16_t id, const Bytes& value, bool little) {
  Bytes bytes = number(id, 2, little);
  append(bytes, number(static_cast<std::uint32_t>(value.size()), 2, little));
  append(bytes, value);
  return bytes;
}

Bytes lease(std::uint32_t seconds, bool little) {
  Bytes value = number(seconds, 4, little);
  append(value, number(0, 4, little));
  return value;
}

struct Announcement {
  std::uint32_t lease_s = 10;
  bool little = true;
  bool inline_qos = false;
  std::uint8_t writer = 0xc2;  ///< last byte of the writer's entity id: 0xc2 announces participants
};

Bytes message(const Announcement& a) {
  Bytes bytes{'R', 'T', 'P', 'S', 2, 1, 1, 15, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12};
  append(bytes, {0x09, 0x01, 8, 0, 1, 2, 3, 4, 5, 6, 7, 8});  // INFO_TS
  Bytes content{0, 0};
  append(content, number(16, 2, a.little));
  append(content, {0, 0, 0, 0, 0, 1, 0, a.writer, 0, 0, 0, 0, 1, 0, 0, 0});
  if (a.inline_qos) {
    append(content, parameter(0x0002, lease(77, a.little), a.little));  // not the announcement's
    append(content, parameter(0x0001, {}, a.little));
  }
  append(content, {0, static_cast<std::uint8_t>(a.little ? 3 : 2), 0, 0});
  append(content, parameter(0x0050, Bytes(16, 0x42), a.little));
  append(content, parameter(0x0002, lease(a.lease_s, a.little), a.little));
  append(content, parameter(0x0001, {}, a.little));
  const auto flags = static_cast<std::uint8_t>(0x04 | (a.little ? 1 : 0) | (a.inline_qos ? 2 : 0));
  append(bytes, {0x15, flags});
  append(bytes, number(static_cast<std::uint32_t>(content.size()), 2, a.little));
  append(bytes, content);
  return bytes;
}

TEST(SpdpLease, IsPutInBothByteOrdersAndBehindInlineQos) {
  for (const bool little : {true, false}) {
    for (const bool inline_qos : {true, false}) {
      Bytes bytes = message({.lease_s = 10, .little = little, .inline_qos = inline_qos});
      put_lease(bytes, 90);
      EXPECT_EQ(bytes, message({.lease_s = 90, .little = little, .inline_qos = inline_qos}));
    }
  }
}

TEST(SpdpLease, ALastSubmessageMayLeaveItsLengthOut) {
  Bytes bytes = message({});
  bytes[34] = bytes[35] = 0;
  Bytes expected = message({.lease_s = 90});
  expected[34] = expected[35] = 0;
  put_lease(bytes, 90);
  EXPECT_EQ(bytes, expected);
}

TEST(SpdpLease, OtherMessagesStayAsTheyAre) {
  const Bytes data = message({.writer = 0x02});
  Bytes bytes = data;
  put_lease(bytes, 90);
  EXPECT_EQ(bytes, data);
  const Bytes not_rtps(200, 0x15);
  bytes = not_rtps;
  put_lease(bytes, 90);
  EXPECT_EQ(bytes, not_rtps);
}

// Under the sanitizers: nothing is read or written outside.
TEST(SpdpLease, MalformedMessagesAreHarmless) {
  const Bytes whole = message({.inline_qos = true});
  for (std::size_t size = 0; size <= whole.size(); ++size) {
    Bytes cut(whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(size));
    put_lease(cut, 90);
  }
  std::mt19937 rng(20);
  for (int i = 0; i < 20'000; ++i) {
    Bytes damaged = whole;
    for (int k = 0; k < 3; ++k) damaged[20 + rng() % (damaged.size() - 20)] = static_cast<std::uint8_t>(rng());
    put_lease(damaged, 90);
    EXPECT_EQ(damaged.size(), whole.size());
  }
}

}  // namespace
}  // namespace downrange::dds
