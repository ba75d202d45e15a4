#pragma once
/// The writer's other half: a thread that compresses chunks and writes the file, fed through a bounded queue.

#include <archive/compression.hpp>
#include <archive/summary.hpp>
#include <atomic>
#include <condition_variable>
#include <cstdint>
#include <deque>
#include <filesystem>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

namespace downrange::archive {

/// How far the file has come. What is not written and not waiting is lost.
struct WriterStatus {
  std::string failure;                 ///< empty: no failure; else file and reason. Final: nothing is written after it
  std::uint64_t messages_written = 0;  ///< handed to the operating system without an error
  std::uint64_t messages_lost = 0;     ///< after a failure, or the queue was full
  std::uint64_t bytes_written = 0;
  std::uint64_t chunks_written = 0;
  std::size_t chunks_waiting = 0;

  [[nodiscard]] bool ok() const { return failure.empty() && messages_lost == 0; }
};

/// Which file it is, whatever its name.
struct FileId {
  std::uint64_t device = 0;
  std::uint64_t inode = 0;

  /// Whether `path` names it. False only where that is certain, not where the path cannot be looked at.
  [[nodiscard]] bool is_at(const std::filesystem::path& path) const;
};

/// A piece of the file, in order: the records of a chunk, or one whole Attachment or Metadata record.
struct Block {
  Op op = Op::Chunk;
  Bytes bytes;
  std::uint64_t messages = 0;
};

class FileThread {
 public:
  struct Options {
    Compression compression;
    std::size_t queue_chunks;
    bool overwrite;
  };

  /// Creates the file and writes its header; throws ArchiveError when that cannot be done.
  FileThread(const std::filesystem::path& path, const Options& options);
  /// Finishes the file if finish() was not called.
  ~FileThread();
  FileThread(const FileThread&) = delete;
  FileThread& operator=(const FileThread&) = delete;

  /// Queues a block. A full queue waits for room when `wait`, else refuses. False: refused, its messages counted lost.
  bool submit(Block block, bool wait);
  /// An empty buffer, one used before where there is one.
  [[nodiscard]] Bytes spare_buffer();
  /// Counts messages that never reached a block.
  void count_lost(std::uint64_t messages);
  /// Writes what waits, the summary and the end of the file, and closes it. Only the first call does something.
  void finish();

  /// Whether the file is still what its path names.
  [[nodiscard]] bool in_place() const { return id_.is_at(path_); }
  /// The file's path now, another where it was moved; nothing: it was removed. Before finish().
  [[nodiscard]] std::optional<std::filesystem::path> whereabouts() const;
  [[nodiscard]] const FileId& id() const { return id_; }
  [[nodiscard]] bool failed() const { return failed_.load(std::memory_order_relaxed); }
  [[nodiscard]] WriterStatus status() const;

 private:
  void run();
  void write_block(const Block& block);
  void write_chunk(ByteView records);
  void write_end();
  void write_all(ByteView bytes);
  void close_file();
  void fail(const std::string& what);

  std::filesystem::path path_;
  Options options_;
  int fd_ = -1;
  FileId id_;

  // The thread's own.
  Compressor compressor_;
  Summary summary_;
  Bytes out_;
  std::uint64_t offset_ = 0;
  std::uint32_t crc_ = 0;

  mutable std::mutex mutex_;
  std::condition_variable filled_;
  std::condition_variable emptied_;
  std::deque<Block> queue_;
  std::vector<Bytes> spares_;
  bool finishing_ = false;
  WriterStatus status_;
  std::atomic<bool> failed_ = false;
  std::thread thread_;
};

}  // namespace downrange::archive
