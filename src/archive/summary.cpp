#include <algorithm>
#include <archive/summary.hpp>

namespace downrange::archive {

ChunkContents Summary::scan(ByteView records) {
  ChunkContents contents;
  bool first = true;
  ByteCursor cursor(records);
  while (!cursor.empty()) {
    const ByteView at = cursor.rest();
    const auto op = static_cast<Op>(cursor.get<std::uint8_t>().value());
    const std::uint64_t size = cursor.get<std::uint64_t>().value();
    ByteCursor content(cursor.get_bytes(size).value());
    const auto id = content.get<std::uint16_t>().value();
    const ByteView whole = at.first(record_header_size + static_cast<std::size_t>(size));
    if (op == Op::Schema) {
      schemas_.try_emplace(id, whole.begin(), whole.end());
    } else if (op == Op::Channel) {
      channels_.try_emplace(id, whole.begin(), whole.end());
    } else {
      static_cast<void>(content.get<std::uint32_t>());  // sequence
      const std::uint64_t log_time = content.get<std::uint64_t>().value();
      contents.start_time = first ? log_time : std::min(contents.start_time, log_time);
      contents.end_time = first ? log_time : std::max(contents.end_time, log_time);
      first = false;
      contents.messages[id].emplace_back(log_time, records.size() - at.size());
    }
  }
  return contents;
}

void Summary::add_chunk(const ChunkContents& contents, const WrittenChunk& chunk) {
  Bytes content;
  put(content, contents.start_time);
  put(content, contents.end_time);
  put(content, chunk.offset);
  put(content, chunk.length);
  put(content, static_cast<std::uint32_t>(chunk.index_offsets.size() * (2 + 8)));
  for (const auto& [channel, offset] : chunk.index_offsets) {
    put(content, channel);
    put(content, offset);
  }
  put(content, chunk.index_length);
  put_string(content, chunk.compression);
  put(content, chunk.compressed_size);
  put(content, chunk.uncompressed_size);
  put_record(chunk_indexes_, Op::ChunkIndex, content);

  ++chunks_;
  if (contents.messages.empty()) return;
  start_time_ = messages_ == 0 ? contents.start_time : std::min(start_time_, contents.start_time);
  end_time_ = messages_ == 0 ? contents.end_time : std::max(end_time_, contents.end_time);
  for (const auto& [channel, messages] : contents.messages) {
    messages_ += messages.size();
    messages_by_channel_[channel] += messages.size();
  }
}

void Summary::add_attachment(std::uint64_t offset, ByteView record) {
  ByteCursor cursor(record.subspan(record_header_size));
  const auto log_time = cursor.get<std::uint64_t>().value();
  const auto create_time = cursor.get<std::uint64_t>().value();
  const auto name = cursor.get_string().value();
  const auto media_type = cursor.get_string().value();
  const auto data_size = cursor.get<std::uint64_t>().value();

  Bytes content;
  put(content, offset);
  put(content, static_cast<std::uint64_t>(record.size()));
  put(content, log_time);
  put(content, create_time);
  put(content, data_size);
  put_string(content, name);
  put_string(content, media_type);
  put_record(attachment_indexes_, Op::AttachmentIndex, content);
  ++attachments_;
}

void Summary::add_metadata(std::uint64_t offset, ByteView record) {
  Bytes content;
  put(content, offset);
  put(content, static_cast<std::uint64_t>(record.size()));
  put_string(content, ByteCursor(record.subspan(record_header_size)).get_string().value());
  put_record(metadata_indexes_, Op::MetadataIndex, content);
  ++metadata_;
}

Bytes Summary::statistics() const {
  Bytes content;
  put(content, messages_);
  put(content, static_cast<std::uint16_t>(schemas_.size()));
  put(content, static_cast<std::uint32_t>(channels_.size()));
  put(content, attachments_);
  put(content, metadata_);
  put(content, chunks_);
  put(content, start_time_);
  put(content, end_time_);
  put(content, static_cast<std::uint32_t>(messages_by_channel_.size() * (2 + 8)));
  for (const auto& [channel, count] : messages_by_channel_) {
    put(content, channel);
    put(content, count);
  }
  Bytes record;
  put_record(record, Op::Statistics, content);
  return record;
}

Bytes Summary::finish(std::uint64_t start) const {
  Bytes out;
  Bytes offsets;
  const auto group = [&](Op op, ByteView records) {
    if (records.empty()) return;
    Bytes content;
    put(content, static_cast<std::uint8_t>(op));
    put(content, start + out.size());
    put(content, static_cast<std::uint64_t>(records.size()));
    put_record(offsets, Op::SummaryOffset, content);
    put_bytes(out, records);
  };
  const auto joined = [](const std::map<std::uint16_t, Bytes>& records) {
    Bytes all;
    for (const auto& [id, record] : records) put_bytes(all, record);
    return all;
  };
  group(Op::Schema, joined(schemas_));
  group(Op::Channel, joined(channels_));
  group(Op::Statistics, statistics());
  group(Op::ChunkIndex, chunk_indexes_);
  group(Op::AttachmentIndex, attachment_indexes_);
  group(Op::MetadataIndex, metadata_indexes_);

  const std::uint64_t offset_start = start + out.size();
  put_bytes(out, offsets);
  put_record_header(out, Op::Footer, footer_size);
  put(out, start);
  put(out, offset_start);
  put(out, crc32(out));
  return out;
}

}  // namespace downrange::archive
