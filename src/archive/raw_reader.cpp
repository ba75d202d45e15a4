#include <algorithm>
#include <archive/mcap.hpp>
#include <archive/reader.hpp>
#include <array>
#include <text/file.hpp>
#include <utility>

namespace downrange::archive {
namespace {

/// Larger chunks, attachments and other records are refused: no writer makes them, and a damaged length must not
/// take all memory.
constexpr std::uint64_t max_record_size = std::uint64_t{256} << 20;

/// A compressed chunk may state this much whatever it has, and this many times what it has (lz4 reaches 255, zstd on
/// measurements some ten): a few bytes must not take memory and minutes.
constexpr std::uint64_t free_chunk_size = std::uint64_t{8} << 20;
constexpr std::uint64_t max_expansion = 512;

/// Names of channels and schemas, kept as long as the file is read. Ours have fewer than 40 characters.
constexpr std::size_t max_name_size = 4096;

/// What is kept of the file beside its chunk in hand. Names and metadata may come out of compressed chunks, and take
/// several times their size; attachments stand in the file as they are.
constexpr std::uint64_t max_names = std::uint64_t{16} << 20;
constexpr std::uint64_t max_attachments = std::uint64_t{64} << 20;

/// Byte-length-prefixed pairs of strings; nothing where they do not fit.
std::optional<std::map<std::string, std::string>> string_map(ByteCursor& cursor) {
  const auto size = cursor.get<std::uint32_t>();
  const auto bytes = size ? cursor.get_bytes(*size) : std::nullopt;
  if (!bytes) return std::nullopt;
  std::map<std::string, std::string> map;
  ByteCursor pairs(*bytes);
  while (!pairs.empty()) {
    const auto key = pairs.get_string();
    const auto value = key ? pairs.get_string() : std::nullopt;
    if (!value) return std::nullopt;
    map.emplace(*key, *value);
  }
  return map;
}

/// Of a record that the specification has; else nothing.
const char* name_of(std::uint8_t op) {
  constexpr std::array names{"Header",     "Footer",       "Schema",        "Channel",       "Message",
                             "Chunk",      "MessageIndex", "ChunkIndex",    "Attachment",    "AttachmentIndex",
                             "Statistics", "Metadata",     "MetadataIndex", "SummaryOffset", "DataEnd"};
  return op >= 1 && op <= names.size() ? names[op - 1U] : nullptr;
}

}  // namespace

RawReader::RawReader(const std::filesystem::path& path) : path_(path), file_(path) { read_start(); }
RawReader::~RawReader() = default;

double RawReader::progress() const {
  return file_.size() == 0 ? 1.0 : static_cast<double>(file_.offset()) / static_cast<double>(file_.size());
}

std::optional<RawMessage> RawReader::next() {
  for (;;) {
    if (auto found = next_in_chunk()) return found;
    if (section_ == Section::Done) return std::nullopt;
    read_record();
    if (loose_) return std::exchange(loose_, std::nullopt);
  }
}

void RawReader::read_start() {
  const ByteView start = file_.peek(mcap_magic.size());
  if (!std::equal(start.begin(), start.end(), mcap_magic.begin())) damaged("not an MCAP file of version 0");
  if (start.size() < mcap_magic.size()) return cut_off("within the magic bytes");
  crc_ = crc32(start);
  file_.skip(start.size());
}

void RawReader::read_record() {
  record_offset_ = file_.offset();
  const ByteView header = file_.peek(record_header_size);
  if (header.size() < record_header_size) return cut_off("the file ends without an end mark");
  ByteCursor cursor(header);
  const auto op = cursor.get<std::uint8_t>().value();
  const auto size = cursor.get<std::uint64_t>().value();
  // What a power failure leaves where file system blocks were promised but never written.
  if (op == 0) return cut_off("zeros where a record should start");
  if (size > file_.remaining() - record_header_size) {
    return cut_off("a record of " + std::to_string(size) + " bytes is cut off");
  }
  if (size > max_record_size) damaged("a record of " + std::to_string(size) + " bytes, more than any writer makes");

  const ByteView record = file_.peek(record_header_size + static_cast<std::size_t>(size));
  if (record.size() < record_header_size + size) return cut_off("the file shrinks while it is read");
  if (section_ == Section::Start && op != static_cast<std::uint8_t>(Op::Header)) damaged("no Header at the start");
  const ByteView content = record.subspan(record_header_size);
  if (op == static_cast<std::uint8_t>(Op::Footer)) {
    read_footer(record);
    return;
  }
  if (section_ != Section::Summary) {
    read_data_record(op, content);
    // The checksum covers the records before DataEnd, then those after it.
    crc_ = section_ == Section::Summary ? 0 : crc32(record, crc_);
  } else {
    read_summary_record(op);
    crc_ = crc32(record, crc_);
  }
  file_.skip(record.size());
  if (section_ == Section::Summary && summary_offset_ == 0) summary_offset_ = file_.offset();
}

void RawReader::read_data_record(std::uint8_t op, ByteView content) {
  switch (static_cast<Op>(op)) {
    case Op::Header: {
      ByteCursor cursor(content);
      const auto profile = cursor.get_string();
      const auto library = profile ? cursor.get_string() : std::nullopt;
      if (!library) damaged("Header record too short");
      library_ = *library;
      section_ = Section::Data;
      return;
    }
    case Op::Schema:
      return read_schema(content);
    case Op::Channel:
      return read_channel(content);
    case Op::Message:
      loose_ = message(content);
      return;
    case Op::Chunk:
      return open_chunk(content);
    case Op::Attachment:
      return read_attachment(content);
    case Op::Metadata:
      return read_metadata(content);
    case Op::DataEnd:
      return read_data_end(content);
    case Op::MessageIndex:  // for those who jump
      return;
    default:
      ++skipped_.unknown_records;
  }
}

void RawReader::read_summary_record(std::uint8_t op) {
  switch (static_cast<Op>(op)) {
    case Op::Schema:  // again, for those who jump
    case Op::Channel:
    case Op::Statistics:
    case Op::MessageIndex:
    case Op::ChunkIndex:
    case Op::AttachmentIndex:
    case Op::MetadataIndex:
    case Op::SummaryOffset:
      return;
    default:
      pass_over(op, "behind the end of the data, allowed there: the summary");
  }
}

void RawReader::open_chunk(ByteView content) {
  ByteCursor cursor(content);
  const auto start_time = cursor.get<std::uint64_t>();
  const auto end_time = cursor.get<std::uint64_t>();
  const auto size = cursor.get<std::uint64_t>();
  const auto crc = cursor.get<std::uint32_t>();
  const auto name = cursor.get_string();
  const auto stored_size = name ? cursor.get<std::uint64_t>() : std::nullopt;
  const auto stored = stored_size ? cursor.get_bytes(*stored_size) : std::nullopt;
  if (!start_time || !end_time || !size || !crc || !stored) damaged("Chunk record too short");
  const auto compression = compression_named(*name);
  if (!compression) damaged("chunk compressed with '" + std::string(*name) + "'; known are zstd, lz4 and none");
  if (*size > max_record_size) damaged("chunk of " + std::to_string(*size) + " bytes, more than any writer makes");
  if (*compression != Compression::None && *size > free_chunk_size + max_expansion * stored->size()) {
    damaged("chunk of " + std::to_string(*size) + " bytes made of " + std::to_string(stored->size()) +
            ": no measurements compress like this");
  }

  chunk_.resize(static_cast<std::size_t>(*size));
  if (const auto wrong = decompress(*compression, *stored, chunk_)) damaged("chunk does not decompress: " + *wrong);
  if (*crc != 0 && crc32(chunk_) != *crc) damaged("chunk checksum (CRC-32) is wrong");
  chunk_at_ = 0;
}

std::optional<RawMessage> RawReader::next_in_chunk() {
  while (chunk_at_ < chunk_.size()) {
    ByteCursor cursor(ByteView(chunk_).subspan(chunk_at_));
    const auto op = cursor.get<std::uint8_t>();
    const auto size = op ? cursor.get<std::uint64_t>() : std::nullopt;
    const auto content = size ? cursor.get_bytes(*size) : std::nullopt;
    if (!content) damaged("a record runs over the end of its chunk");
    chunk_at_ = chunk_.size() - cursor.rest().size();
    switch (static_cast<Op>(*op)) {
      case Op::Schema:
        read_schema(*content);
        break;
      case Op::Channel:
        read_channel(*content);
        break;
      case Op::Message:
        if (auto found = message(*content)) return found;
        break;
      default:
        pass_over(*op, "inside a chunk, allowed there: schemas, channels and messages");
    }
  }
  return std::nullopt;
}

void RawReader::pass_over(std::uint8_t op, const char* where) {
  if (const char* name = name_of(op)) damaged(std::string("found a ") + name + " record " + where);
  ++skipped_.unknown_records;
}

std::optional<RawMessage> RawReader::message(ByteView content) {
  ByteCursor cursor(content);
  const auto channel = cursor.get<std::uint16_t>();
  const auto sequence = cursor.get<std::uint32_t>();
  const auto log_time = cursor.get<std::uint64_t>();
  const auto publish_time = cursor.get<std::uint64_t>();
  if (!channel || !sequence || !log_time || !publish_time) damaged("Message record too short");
  const auto found = channels_.find(*channel);
  if (found == channels_.end()) {
    ++skipped_.undeclared[*channel];
    return std::nullopt;
  }
  return RawMessage{&found->second, *sequence, *log_time, *publish_time, cursor.rest(), record_offset_};
}

std::string RawReader::undeclared_messages() const {
  constexpr std::size_t named = 5;
  std::string text;
  std::size_t channels = 0;
  std::uint64_t others = 0;
  for (const auto& [channel, count] : skipped_.undeclared) {
    if (channels++ >= named) {
      others += count;
      continue;
    }
    text += (text.empty() ? "" : ", ") + std::to_string(count) + (count == 1 ? " message" : " messages") +
            " of channel " + std::to_string(channel);
  }
  return others == 0 ? text : text + ", " + std::to_string(others) + " of other channels";
}

void RawReader::require_declared() const {
  if (skipped_.undeclared.empty()) return;
  throw ArchiveError(path_.string() + ": found " + undeclared_messages() +
                     " that no Channel record before them declares, so what they hold cannot be read; expected: none");
}

void RawReader::read_schema(ByteView content) {
  ByteCursor cursor(content);
  const auto id = cursor.get<std::uint16_t>();
  const auto name = id ? cursor.get_string() : std::nullopt;
  if (!name) damaged("Schema record too short");
  if (schemas_.contains(*id)) return;
  if (name->size() > max_name_size) damaged("a schema's name of " + std::to_string(name->size()) + " bytes");
  keep_name(name->size());
  schemas_.emplace(*id, *name);
}

void RawReader::read_channel(ByteView content) {
  ByteCursor cursor(content);
  const auto id = cursor.get<std::uint16_t>();
  const auto schema = cursor.get<std::uint16_t>();
  const auto topic = cursor.get_string();
  const auto encoding = topic ? cursor.get_string() : std::nullopt;
  if (!id || !schema || !encoding) damaged("Channel record too short");
  if (channels_.contains(*id)) return;
  if (topic->size() > max_name_size) damaged("a channel's name of " + std::to_string(topic->size()) + " bytes");
  keep_name(content.size());
  auto metadata = string_map(cursor);
  if (!metadata) damaged("Channel record too short");
  const auto schema_found = schemas_.find(*schema);
  ChannelInfo info{*id, std::string(*topic), schema_found == schemas_.end() ? "" : schema_found->second,
                   std::string(*encoding), std::move(*metadata)};
  channels_.try_emplace(*id, std::move(info));
}

void RawReader::keep_name(std::uint64_t size) {
  names_size_ += size;
  if (names_size_ > max_names) damaged("names and metadata of more than " + text::show_size(max_names));
}

void RawReader::read_attachment(ByteView content) {
  ByteCursor cursor(content);
  const auto log_time = cursor.get<std::uint64_t>();
  const auto create_time = cursor.get<std::uint64_t>();
  const auto name = cursor.get_string();
  const auto media_type = name ? cursor.get_string() : std::nullopt;
  const auto size = media_type ? cursor.get<std::uint64_t>() : std::nullopt;
  const auto data = size ? cursor.get_bytes(*size) : std::nullopt;
  const std::size_t covered = content.size() - cursor.rest().size();
  const auto crc = data ? cursor.get<std::uint32_t>() : std::nullopt;
  if (!log_time || !create_time || !data || !crc) damaged("Attachment record too short");
  if (*crc != 0 && crc32(content.first(covered)) != *crc) damaged("attachment checksum (CRC-32) is wrong");
  if (attachments_size_ + content.size() > max_attachments) {
    ++skipped_.large_attachments;
    return;
  }
  attachments_size_ += content.size();
  attachments_.push_back({std::string(*name), std::string(*media_type), *log_time, {data->begin(), data->end()}});
}

void RawReader::read_metadata(ByteView content) {
  keep_name(content.size());
  ByteCursor cursor(content);
  const auto name = cursor.get_string();
  auto values = name ? string_map(cursor) : std::nullopt;
  if (!values) damaged("Metadata record too short");
  metadata_[std::string(*name)] = std::move(*values);
}

void RawReader::read_data_end(ByteView content) {
  const auto crc = ByteCursor(content).get<std::uint32_t>();
  if (!crc) damaged("DataEnd record too short");
  if (*crc != 0 && *crc != crc_) damaged("checksum (CRC-32) over the file's data is wrong");
  section_ = Section::Summary;
}

void RawReader::read_footer(ByteView record) {
  ByteCursor cursor(record.subspan(record_header_size));
  const auto summary_start = cursor.get<std::uint64_t>();
  const auto offset_start = cursor.get<std::uint64_t>();
  const auto crc = cursor.get<std::uint32_t>();
  if (!summary_start || !offset_start || !crc || !cursor.empty()) damaged("Footer record of a wrong size");
  if (section_ != Section::Summary) damaged("Footer without a DataEnd before it");
  if (*summary_start != 0 && *summary_start != summary_offset_) damaged("Footer does not point at the summary");
  if (*crc != 0 && crc32(record.first(record.size() - 4), crc_) != *crc) {
    damaged("checksum (CRC-32) over the summary is wrong");
  }
  file_.skip(record.size());
  record_offset_ = file_.offset();
  const ByteView end = file_.peek(mcap_magic.size() + 1);
  if (end.size() < mcap_magic.size() && std::equal(end.begin(), end.end(), mcap_magic.begin())) {
    return cut_off("within the closing magic bytes");
  }
  if (!std::equal(end.begin(), end.end(), mcap_magic.begin(), mcap_magic.end())) {
    damaged("closing magic bytes are wrong or not the end of the file");
  }
  file_.skip(end.size());
  section_ = Section::Done;
}

void RawReader::cut_off(const std::string& what) {
  // A file that was closed in order lacks nothing: there it is a length or an opcode in the middle that is wrong.
  if (file_.size() >= 2 * mcap_magic.size() && file_.ends_with(mcap_magic))
    damaged(what + ", yet the file has its end");
  truncated_ = Truncation{file_.offset(), what};
  section_ = Section::Done;
}

void RawReader::damaged(const std::string& what) {
  section_ = Section::Done;
  chunk_.clear();
  throw ArchiveError(path_.string() + ": damaged at byte " + std::to_string(record_offset_) + ": " + what);
}

}  // namespace downrange::archive
