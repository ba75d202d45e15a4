#pragma once
/// The MCAP container (specification: mcap.dev/spec, version 1, magic byte '0'): names and sizes both sides share.

#include <archive/bytes.hpp>
#include <array>
#include <cstdint>

namespace downrange::archive {

inline constexpr std::array<std::uint8_t, 8> mcap_magic{0x89, 'M', 'C', 'A', 'P', '0', '\r', '\n'};

enum class Op : std::uint8_t {
  Header = 0x01,
  Footer = 0x02,
  Schema = 0x03,
  Channel = 0x04,
  Message = 0x05,
  Chunk = 0x06,
  MessageIndex = 0x07,
  ChunkIndex = 0x08,
  Attachment = 0x09,
  AttachmentIndex = 0x0A,
  Statistics = 0x0B,
  Metadata = 0x0C,
  MetadataIndex = 0x0D,
  SummaryOffset = 0x0E,
  DataEnd = 0x0F,
};

/// Opcode and uint64 content length stand before every record's content.
inline constexpr std::size_t record_header_size = 9;
/// channel_id, sequence, log_time, publish_time: what stands before a Message's data.
inline constexpr std::size_t message_header_size = 2 + 4 + 8 + 8;
/// summary_start, summary_offset_start, summary_crc.
inline constexpr std::size_t footer_size = 8 + 8 + 4;

inline void put_record_header(Bytes& out, Op op, std::uint64_t size) {
  put(out, static_cast<std::uint8_t>(op));
  put(out, size);
}

inline void put_record(Bytes& out, Op op, ByteView content) {
  put_record_header(out, op, content.size());
  put_bytes(out, content);
}

}  // namespace downrange::archive
