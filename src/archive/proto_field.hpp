#pragma once
/// Inside src/archive: conversions of single fields, for inputs_proto.cpp and outputs_proto.cpp.

#include <algorithm>
#include <archive/record_catalogue.hpp>
#include <limits>
#include <string>
#include <string_view>

namespace downrange::archive {

/// Bytes of the well-formed UTF-8 character at the front of `text` (RFC 3629, section 4), 0 when there is none.
inline std::size_t utf8_size(std::string_view text) {
  const auto byte = [&](std::size_t i) { return i < text.size() ? static_cast<unsigned char>(text[i]) : 0U; };
  const auto in = [&](std::size_t i, unsigned low, unsigned high) { return byte(i) >= low && byte(i) <= high; };
  const unsigned first = byte(0);
  if (first < 0x80) return 1;
  if (in(0, 0xC2, 0xDF)) return in(1, 0x80, 0xBF) ? 2 : 0;
  if (in(0, 0xE0, 0xEF)) {
    const bool second = in(1, first == 0xE0 ? 0xA0 : 0x80, first == 0xED ? 0x9F : 0xBF);
    return second && in(2, 0x80, 0xBF) ? 3 : 0;
  }
  if (in(0, 0xF0, 0xF4)) {
    const bool second = in(1, first == 0xF0 ? 0x90 : 0x80, first == 0xF4 ? 0x8F : 0xBF);
    return second && in(2, 0x80, 0xBF) && in(3, 0x80, 0xBF) ? 4 : 0;
  }
  return 0;
}

template <std::size_t MaxSize>
void put(const FixedText<MaxSize>& name, std::string* out) {
  const std::string_view text = name.view();
  out->assign(text);
  if (std::all_of(text.begin(), text.end(), [](char c) { return static_cast<unsigned char>(c) < 0x80; })) return;
  for (std::size_t i = 0; i < out->size();) {
    const std::size_t size = utf8_size(std::string_view(*out).substr(i));
    if (size == 0) (*out)[i] = '?';
    i += std::max<std::size_t>(size, 1);
  }
}

template <class Message>
void put(const Position<Ecef>& p, Message& out) {
  out.set_position_x_m(p.m.x());
  out.set_position_y_m(p.m.y());
  out.set_position_z_m(p.m.z());
}

template <class Message>
void put(const Velocity<Ecef>& v, Message& out) {
  out.set_velocity_x_m_s(v.m_s.x());
  out.set_velocity_y_m_s(v.m_s.y());
  out.set_velocity_z_m_s(v.m_s.z());
}

template <class Message>
void put(const Polar& q, Message& out) {
  out.set_range_m(q.range_m);
  out.set_azimuth_rad(q.azimuth_rad);
  out.set_elevation_rad(q.elevation_rad);
}

/// The first `count` of a fixed array.
template <class Array, class Field>
void put_first(const Array& in, int count, Field* out) {
  out->Clear();
  for (std::size_t i = 0; i < static_cast<std::size_t>(count); ++i)
    out->Add(static_cast<typename Field::value_type>(in[i]));
}

template <class Wire, class Enum>
Wire wire(Enum value) {
  return static_cast<Wire>(static_cast<int>(value));
}

inline void fault(Defect& defect, std::string what) {
  if (defect.what.empty()) defect.what = std::move(what);
}

template <class Text = Name>
Text name(const std::string& text, const char* field, Defect& defect) {
  const auto parsed = Text::parse(text);
  if (!parsed) {
    fault(defect,
          std::string(field) + ": longer than " + std::to_string(Text::max_size) + " characters or holding a NUL");
  }
  return parsed.value_or(Text());
}

/// `last` is the highest enumerator.
template <class Enum>
Enum enumerator(int value, Enum last, const char* field, Defect& defect) {
  if (value >= 0 && value <= static_cast<int>(last)) return static_cast<Enum>(value);
  fault(defect, std::string(field) + ": no enumerator has the number " + std::to_string(value));
  return Enum{};
}

inline std::uint8_t byte(std::uint32_t value, const char* field, Defect& defect) {
  if (value > std::numeric_limits<std::uint8_t>::max()) fault(defect, std::string(field) + ": above 255");
  return static_cast<std::uint8_t>(value);
}

/// Copies a repeated field of exactly `size` numbers to the front of a fixed array.
template <class Field, class Array>
void copy_array(const Field& in, int size, Array& out, const char* field, Defect& defect) {
  if (in.size() != size || in.size() > static_cast<int>(out.size())) {
    fault(defect, std::string(field) + ": " + std::to_string(in.size()) + " entries instead of " +
                      std::to_string(size) + " (at most " + std::to_string(out.size()) + ")");
    return;
  }
  std::copy(in.begin(), in.end(), out.begin());
}

template <class Message>
Position<Ecef> position(const Message& in) {
  return {{in.position_x_m(), in.position_y_m(), in.position_z_m()}};
}

template <class Message>
Velocity<Ecef> velocity(const Message& in) {
  return {{in.velocity_x_m_s(), in.velocity_y_m_s(), in.velocity_z_m_s()}};
}

template <class Message>
Polar polar(const Message& in) {
  return {in.range_m(), in.azimuth_rad(), in.elevation_rad()};
}

}  // namespace downrange::archive
