#pragma once
/// The summary section of an MCAP file: what lets a viewer open it without reading it through.

#include <archive/mcap.hpp>
#include <cstdint>
#include <map>
#include <string>
#include <vector>

namespace downrange::archive {

/// Where messages of one channel stand in an uncompressed chunk: (log_time, offset), in file order.
using MessageOffsets = std::vector<std::pair<std::uint64_t, std::uint64_t>>;

/// What a chunk's uncompressed records hold.
struct ChunkContents {
  std::uint64_t start_time = 0;  ///< of its messages' log times; 0 without messages
  std::uint64_t end_time = 0;
  std::map<std::uint16_t, MessageOffsets> messages;  ///< by channel
};

/// Collects, as the file is written, what its summary says.
class Summary {
 public:
  /// Walks records that the writer made, notes schemas and channels seen for the first time.
  [[nodiscard]] ChunkContents scan(ByteView records);

  struct WrittenChunk {
    std::uint64_t offset;  ///< of the Chunk record in the file
    std::uint64_t length;  ///< of the Chunk record, its header included
    std::map<std::uint16_t, std::uint64_t> index_offsets;
    std::uint64_t index_length;
    std::string_view compression;
    std::uint64_t compressed_size;
    std::uint64_t uncompressed_size;
  };
  void add_chunk(const ChunkContents& contents, const WrittenChunk& chunk);
  void add_attachment(std::uint64_t offset, ByteView record);
  void add_metadata(std::uint64_t offset, ByteView record);

  /// Summary section, summary offset section and Footer, for a summary that starts at file offset `start`.
  [[nodiscard]] Bytes finish(std::uint64_t start) const;

 private:
  [[nodiscard]] Bytes statistics() const;

  std::map<std::uint16_t, Bytes> schemas_;  ///< whole records, by id
  std::map<std::uint16_t, Bytes> channels_;
  Bytes chunk_indexes_;
  Bytes attachment_indexes_;
  Bytes metadata_indexes_;
  std::uint32_t chunks_ = 0;
  std::uint32_t attachments_ = 0;
  std::uint32_t metadata_ = 0;
  std::uint64_t messages_ = 0;
  std::uint64_t start_time_ = 0;
  std::uint64_t end_time_ = 0;
  std::map<std::uint16_t, std::uint64_t> messages_by_channel_;
};

}  // namespace downrange::archive
