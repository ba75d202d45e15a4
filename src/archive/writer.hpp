#pragma once
/// Writes an MCAP archive: what the engine consumed, in the order it consumed it, and what it made of it.

#include <archive/compression.hpp>
#include <archive/file_thread.hpp>
#include <archive/record.hpp>
#include <filesystem>
#include <map>
#include <memory>
#include <string>
#include <string_view>

namespace downrange::archive {

/// What a write does when the disk has fallen behind by the whole queue.
enum class Backlog : std::uint8_t {
  Wait,  ///< replay, import, range clock: nothing is lost, the caller waits
  Drop,  ///< wall clock: the engine must not wait; the chunk is lost and counted
};

struct WriterOptions {
  Compression compression = Compression::Zstd;
  std::size_t chunk_size = 1 << 20;    ///< bytes of uncompressed records after which a chunk is closed
  Duration chunk_time = seconds(1.0);  ///< of log time, likewise: what a killed process loses at most
  std::size_t queue_chunks = 32;       ///< closed chunks that wait for the disk
  Backlog backlog = Backlog::Wait;
  bool overwrite = false;  ///< a flight is not recorded over: an existing file is an error
};

/// Encodes on the caller's thread, compresses and writes on its own. Everything but status() and failed() is for one
/// thread. A failure of the disk is a status, never an exception: what is written after it is counted as lost.
/// The message sequence is the count of events written so far: a result carries that of the last event before it.
class Writer {
 public:
  /// Creates the file. Throws ArchiveError when it exists already or cannot be created.
  explicit Writer(const std::filesystem::path& path, const WriterOptions& options = {});
  /// Closes; whoever wants to know how that went calls close() first.
  ~Writer();
  Writer(const Writer&) = delete;
  Writer& operator=(const Writer&) = delete;

  /// log_time = received, publish_time = epoch (apply_at of a slaving command).
  void write(const Event& event);
  void write(const Result& result);
  /// Closes the engine's account: where a replay advances to after the last event.
  void write_last_tick(Time tick);
  void write_truth(const Truth& truth);

  /// A file within the file, e.g. ("config.toml", "application/toml", text). `log_time` is when it held.
  void attach(std::string_view name, std::string_view media_type, std::string_view data, Time log_time = {});
  void metadata(std::string_view name, const std::map<std::string, std::string>& values);

  /// Hands the open chunk to the disk now.
  void flush();

  /// Flushes, writes indexes and the end of the file. After it, writes count as lost. status().ok() tells how it went.
  [[nodiscard]] WriterStatus close();

  [[nodiscard]] bool failed() const;
  /// False: the file was removed or replaced. What is written goes nowhere that can be found.
  [[nodiscard]] bool in_place() const;
  /// Where the file is now; nothing: it was removed. Before close().
  [[nodiscard]] std::optional<std::filesystem::path> whereabouts() const;
  [[nodiscard]] const FileId& id() const;
  [[nodiscard]] WriterStatus status() const;

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace downrange::archive
