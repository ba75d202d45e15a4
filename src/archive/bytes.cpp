#include <zlib.h>
#include <archive/bytes.hpp>

namespace downrange::archive {

std::uint32_t crc32(ByteView data, std::uint32_t crc) {
  return static_cast<std::uint32_t>(::crc32_z(crc, data.data(), data.size()));
}

void put_bytes(Bytes& out, ByteView bytes) { out.insert(out.end(), bytes.begin(), bytes.end()); }

void put_string(Bytes& out, std::string_view text) {
  put(out, static_cast<std::uint32_t>(text.size()));
  out.insert(out.end(), text.begin(), text.end());
}

std::optional<ByteView> ByteCursor::get_bytes(std::uint64_t size) {
  if (size > data_.size()) return std::nullopt;
  const ByteView taken = data_.first(static_cast<std::size_t>(size));
  data_ = data_.subspan(taken.size());
  return taken;
}

std::optional<std::string_view> ByteCursor::get_string() {
  ByteCursor attempt = *this;
  const auto size = attempt.get<std::uint32_t>();
  if (!size) return std::nullopt;
  const auto text = attempt.get_bytes(*size);
  if (!text) return std::nullopt;
  *this = attempt;
  return std::string_view(reinterpret_cast<const char*>(text->data()), text->size());
}

}  // namespace downrange::archive
