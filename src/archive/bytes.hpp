#pragma once
/// Little-endian bytes as MCAP serialises them, and the CRC-32 it uses.

#include <bit>
#include <cstdint>
#include <cstring>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

namespace downrange::archive {

static_assert(std::endian::native == std::endian::little, "MCAP is little-endian; so is every machine this runs on");

using Bytes = std::vector<std::uint8_t>;
using ByteView = std::span<const std::uint8_t>;

/// CRC-32 (ISO 3309, as zlib) of `data` continued from `crc`; 0 starts one.
[[nodiscard]] std::uint32_t crc32(ByteView data, std::uint32_t crc = 0);

template <class T>
void put(Bytes& out, T value) {
  static_assert(std::is_integral_v<T>);
  const std::size_t at = out.size();
  out.resize(at + sizeof(T));
  std::memcpy(out.data() + at, &value, sizeof(T));
}
void put_bytes(Bytes& out, ByteView bytes);
/// uint32 length, then the characters.
void put_string(Bytes& out, std::string_view text);

/// Reads from the front of a view; every getter gives nothing, and consumes nothing, where the view is too short.
class ByteCursor {
 public:
  explicit ByteCursor(ByteView data) : data_(data) {}

  template <class T>
  [[nodiscard]] std::optional<T> get() {
    static_assert(std::is_integral_v<T>);
    if (data_.size() < sizeof(T)) return std::nullopt;
    T value;
    std::memcpy(&value, data_.data(), sizeof(T));
    data_ = data_.subspan(sizeof(T));
    return value;
  }
  [[nodiscard]] std::optional<ByteView> get_bytes(std::uint64_t size);
  /// uint32 length, then the characters; the view lives as long as the data.
  [[nodiscard]] std::optional<std::string_view> get_string();
  [[nodiscard]] ByteView rest() const { return data_; }
  [[nodiscard]] bool empty() const { return data_.empty(); }

 private:
  ByteView data_;
};

}  // namespace downrange::archive
