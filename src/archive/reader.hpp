#pragma once
/// Reads MCAP archives from front to back, ours and others'. Indexes are not needed: a file that a crash or a full disk
/// cut off reads like a whole one up to its last complete record.

#include <archive/bytes.hpp>
#include <archive/compression.hpp>
#include <archive/input_file.hpp>
#include <archive/record.hpp>
#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace downrange::archive {

/// A Channel record as the file has it.
struct ChannelInfo {
  std::uint16_t id = 0;
  std::string topic;
  std::string schema;            ///< full name of the message type
  std::string message_encoding;  ///< "protobuf" in our files
  std::map<std::string, std::string> metadata;
};

/// A message as it stands in the file. Channel and payload live until the next read.
struct RawMessage {
  const ChannelInfo* channel = nullptr;
  std::uint32_t sequence = 0;
  std::uint64_t log_time = 0;      ///< ns since 1970 UTC
  std::uint64_t publish_time = 0;  ///< likewise
  ByteView payload;
  std::uint64_t offset = 0;  ///< in the file, of the chunk (or the message outside chunks) it came from
};

struct Attachment {
  std::string name;
  std::string media_type;
  std::uint64_t log_time = 0;
  std::string data;
};

/// Where a file stops before its end.
struct Truncation {
  std::uint64_t offset = 0;  ///< of the first byte that could not be used
  std::string what;
};

/// What a reader passed over without judging it.
struct Skipped {
  std::uint64_t unknown_records = 0;  ///< opcodes that the specification does not have
  /// Messages by the id of their channel, which no Channel record before them declares: what they are is not known.
  std::map<std::uint16_t, std::uint64_t> undeclared;
  std::uint64_t large_attachments = 0;  ///< no room to keep them
  std::uint64_t foreign_messages = 0;   ///< messages of channels that are not ours (typed reader only)
};

/// Messages of any MCAP file in file order.
class RawReader {
 public:
  /// Throws ArchiveError when the file cannot be opened or is not MCAP.
  explicit RawReader(const std::filesystem::path& path);
  ~RawReader();
  RawReader(const RawReader&) = delete;
  RawReader& operator=(const RawReader&) = delete;

  /// The next message; nothing at the end of the file or where it is cut off. Throws ArchiveError where it is damaged:
  /// each chunk's checksum is tested before its messages come out, the file's own when its end is reached.
  [[nodiscard]] std::optional<RawMessage> next();

  /// Set when next() ended before the end of a complete file.
  [[nodiscard]] const std::optional<Truncation>& truncated() const { return truncated_; }
  /// Those passed so far; all of them once next() has ended.
  [[nodiscard]] const std::vector<Attachment>& attachments() const { return attachments_; }
  [[nodiscard]] const std::map<std::string, std::map<std::string, std::string>>& metadata() const { return metadata_; }
  [[nodiscard]] const Skipped& skipped() const { return skipped_; }
  /// Those of undeclared channels in words: "3 messages of channel 7, 1 message of channel 9"; empty: none.
  [[nodiscard]] std::string undeclared_messages() const;
  /// Throws ArchiveError where there were any: to be called when next() has ended, by whoever needs all messages.
  void require_declared() const;
  /// From the Header record.
  [[nodiscard]] const std::string& library() const { return library_; }
  /// Share of the file read, 0 to 1.
  [[nodiscard]] double progress() const;

 private:
  enum class Section : std::uint8_t { Start, Data, Summary, Done };

  void read_start();
  void read_record();
  void read_data_record(std::uint8_t op, ByteView content);
  void read_summary_record(std::uint8_t op);
  void open_chunk(ByteView content);
  /// Counts a record that the specification does not have; throws as damaged() for one that does not belong there.
  void pass_over(std::uint8_t op, const char* where);
  std::optional<RawMessage> next_in_chunk();
  std::optional<RawMessage> message(ByteView content);
  void read_schema(ByteView content);
  void read_channel(ByteView content);
  void read_attachment(ByteView content);
  void read_metadata(ByteView content);
  /// Counts what stays in memory to the end of the reading; throws as damaged() where that is too much.
  void keep_name(std::uint64_t size);
  void read_data_end(ByteView content);
  void read_footer(ByteView record);
  /// Ends the reading as truncated; throws as damaged() where the file has its closing magic bytes all the same.
  void cut_off(const std::string& what);
  [[noreturn]] void damaged(const std::string& what);

  std::filesystem::path path_;
  InputFile file_;
  Section section_ = Section::Start;
  std::uint64_t record_offset_ = 0;  ///< of the record in hand
  std::uint32_t crc_ = 0;            ///< of the section so far
  std::uint64_t summary_offset_ = 0;
  Bytes chunk_;                      ///< uncompressed
  std::size_t chunk_at_ = 0;         ///< of the next record in it
  std::optional<RawMessage> loose_;  ///< a message outside chunks
  std::map<std::uint16_t, std::string> schemas_;
  std::map<std::uint16_t, ChannelInfo> channels_;
  std::vector<Attachment> attachments_;
  std::map<std::string, std::map<std::string, std::string>> metadata_;
  std::string library_;
  std::uint64_t names_size_ = 0;  ///< bytes, metadata included
  std::uint64_t attachments_size_ = 0;
  Skipped skipped_;
  std::optional<Truncation> truncated_;
};

/// A message with its meaning.
struct Entry {
  Record record;
  Role role = Role::Input;
  std::uint32_t sequence = 0;
  std::string_view topic;  ///< lives until the next read
};

/// Messages of our own channels as the structs they were.
class Reader {
 public:
  /// Throws as RawReader.
  explicit Reader(const std::filesystem::path& path);
  ~Reader();

  /// As RawReader::next. A message that is no legal record comes as BadRecord, those of other channels are counted.
  [[nodiscard]] std::optional<Entry> next();

  [[nodiscard]] const RawReader& raw() const { return raw_; }
  [[nodiscard]] const std::optional<Truncation>& truncated() const { return raw_.truncated(); }
  [[nodiscard]] Skipped skipped() const;
  /// Messages so far of the channels that are not ours, by "'topic' ('schema')"; a fixed number of channels, then
  /// "others".
  [[nodiscard]] std::map<std::string, std::uint64_t> foreign_channels() const;

 private:
  class Decoder;
  RawReader raw_;
  std::unique_ptr<Decoder> decoder_;
};

}  // namespace downrange::archive
