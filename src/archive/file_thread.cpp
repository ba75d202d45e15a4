#include <fcntl.h>
#include <pthread.h>
#include <signal.h>
#include <sys/stat.h>
#include <unistd.h>

#include <archive/file_thread.hpp>
#include <archive/record.hpp>
#include <cerrno>
#include <system_error>

namespace downrange::archive {
namespace {

std::string error_text(int error) { return std::generic_category().message(error); }

/// Signals belong to main. With SIGXFSZ blocked too, a file size limit is an error of write() instead of the end.
class BlockedSignals {
 public:
  BlockedSignals() {
    sigset_t all;
    sigfillset(&all);
    pthread_sigmask(SIG_SETMASK, &all, &before_);
  }
  ~BlockedSignals() { pthread_sigmask(SIG_SETMASK, &before_, nullptr); }
  BlockedSignals(const BlockedSignals&) = delete;
  BlockedSignals& operator=(const BlockedSignals&) = delete;

 private:
  sigset_t before_{};
};

}  // namespace

bool FileId::is_at(const std::filesystem::path& path) const {
  struct stat named {};
  if (::stat(path.c_str(), &named) != 0) return errno != ENOENT && errno != ENOTDIR;
  return named.st_dev == device && named.st_ino == inode;
}

FileThread::FileThread(const std::filesystem::path& path, const Options& options)
    : path_(path), options_(options), compressor_(options.compression) {
  fd_ = ::open(path.c_str(), O_WRONLY | O_CREAT | O_CLOEXEC | (options.overwrite ? O_TRUNC : O_EXCL), 0644);
  if (fd_ < 0) throw ArchiveError(path.string() + ": cannot create the archive: " + error_text(errno));

  struct stat file {};
  if (::fstat(fd_, &file) == 0) {
    id_ = {.device = file.st_dev, .inode = file.st_ino};
  }

  Bytes header;
  put_string(header, "");  // profile
  put_string(header, "downrange " DOWNRANGE_VERSION);
  put_bytes(out_, mcap_magic);
  put_record(out_, Op::Header, header);

  const BlockedSignals blocked;  // the thread inherits the mask
  write_all(out_);
  if (failed()) {
    ::close(fd_);
    throw ArchiveError(status_.failure);
  }
  thread_ = std::thread([this] { run(); });
}

FileThread::~FileThread() { finish(); }

bool FileThread::submit(Block block, bool wait) {
  std::unique_lock lock(mutex_);
  const auto has_room = [this] { return queue_.size() < options_.queue_chunks || finishing_; };
  if (wait) emptied_.wait(lock, has_room);
  if (failed() || finishing_ || !has_room()) {
    status_.messages_lost += block.messages;
    return false;
  }
  queue_.push_back(std::move(block));
  filled_.notify_one();
  return true;
}

Bytes FileThread::spare_buffer() {
  const std::lock_guard lock(mutex_);
  if (spares_.empty()) return {};
  Bytes buffer = std::move(spares_.back());
  spares_.pop_back();
  return buffer;
}

void FileThread::count_lost(std::uint64_t messages) {
  const std::lock_guard lock(mutex_);
  status_.messages_lost += messages;
}

std::optional<std::filesystem::path> FileThread::whereabouts() const {
  if (in_place()) return path_;
  struct stat file {};
  if (::fstat(fd_, &file) != 0 || file.st_nlink == 0) return std::nullopt;
  std::error_code unknown;
  auto path = std::filesystem::read_symlink("/proc/self/fd/" + std::to_string(fd_), unknown);
  return unknown ? std::nullopt : std::optional(std::move(path));
}

void FileThread::finish() {
  {
    const std::lock_guard lock(mutex_);
    finishing_ = true;
  }
  filled_.notify_one();
  emptied_.notify_all();
  if (thread_.joinable()) thread_.join();
}

WriterStatus FileThread::status() const {
  const std::lock_guard lock(mutex_);
  WriterStatus status = status_;
  status.chunks_waiting = queue_.size();
  return status;
}

void FileThread::run() {
  for (;;) {
    Block block;
    {
      std::unique_lock lock(mutex_);
      filled_.wait(lock, [this] { return !queue_.empty() || finishing_; });
      if (queue_.empty()) break;
      block = std::move(queue_.front());
      queue_.pop_front();
    }
    emptied_.notify_one();
    if (!failed()) write_block(block);

    const std::lock_guard lock(mutex_);
    (failed() ? status_.messages_lost : status_.messages_written) += block.messages;
    block.bytes.clear();
    spares_.push_back(std::move(block.bytes));
  }
  if (!failed()) write_end();
  close_file();
}

void FileThread::write_block(const Block& block) {
  try {
    if (block.op == Op::Chunk) {
      write_chunk(block.bytes);
      return;
    }
    if (block.op == Op::Attachment) summary_.add_attachment(offset_, block.bytes);
    if (block.op == Op::Metadata) summary_.add_metadata(offset_, block.bytes);
    write_all(block.bytes);
  } catch (const std::exception& error) {
    fail(error.what());
  }
}

void FileThread::write_chunk(ByteView records) {
  const ChunkContents contents = summary_.scan(records);
  const std::string_view compression = to_string(options_.compression);

  out_.clear();
  put_record_header(out_, Op::Chunk, 0);  // its length follows once known
  put(out_, contents.start_time);
  put(out_, contents.end_time);
  put(out_, static_cast<std::uint64_t>(records.size()));
  put(out_, crc32(records));
  put_string(out_, compression);
  const std::size_t size_at = out_.size();
  put(out_, std::uint64_t{0});
  compressor_.compress(records, out_);

  const std::uint64_t compressed_size = out_.size() - size_at - 8;
  const std::uint64_t content_size = out_.size() - record_header_size;
  std::memcpy(out_.data() + size_at, &compressed_size, 8);
  std::memcpy(out_.data() + 1, &content_size, 8);
  Summary::WrittenChunk chunk{offset_, out_.size(), {}, 0, compression, compressed_size, records.size()};

  for (const auto& [channel, messages] : contents.messages) {
    chunk.index_offsets[channel] = offset_ + out_.size();
    const auto array_size = static_cast<std::uint32_t>(messages.size() * (8 + 8));
    put_record_header(out_, Op::MessageIndex, 2 + 4 + array_size);
    put(out_, channel);
    put(out_, array_size);
    for (const auto& [log_time, offset] : messages) {
      put(out_, log_time);
      put(out_, offset);
    }
  }
  chunk.index_length = out_.size() - chunk.length;

  write_all(out_);
  if (failed()) return;
  summary_.add_chunk(contents, chunk);
  const std::lock_guard lock(mutex_);
  ++status_.chunks_written;
}

void FileThread::write_end() {
  out_.clear();
  put_record_header(out_, Op::DataEnd, 4);
  put(out_, crc_);
  put_bytes(out_, summary_.finish(offset_ + out_.size()));
  put_bytes(out_, mcap_magic);
  write_all(out_);
}

void FileThread::write_all(ByteView bytes) {
  crc_ = crc32(bytes, crc_);
  while (!bytes.empty()) {
    const ssize_t written = ::write(fd_, bytes.data(), bytes.size());
    if (written < 0 && errno == EINTR) continue;
    if (written <= 0) {
      fail(written < 0 ? error_text(errno) : "nothing more can be written");
      return;
    }
    offset_ += static_cast<std::uint64_t>(written);
    bytes = bytes.subspan(static_cast<std::size_t>(written));
    const std::lock_guard lock(mutex_);
    status_.bytes_written = offset_;
  }
}

void FileThread::close_file() {
  // Some file systems report a full disk only here. Devices and pipes cannot be synchronised, and need not be.
  if (::fsync(fd_) != 0 && errno != EINVAL && errno != EROFS && errno != ENOTSUP) fail(error_text(errno));
  if (::close(fd_) != 0) fail(error_text(errno));
  fd_ = -1;
}

void FileThread::fail(const std::string& what) {
  const std::lock_guard lock(mutex_);
  if (!status_.failure.empty()) return;
  status_.failure =
      path_.string() + ": writing the archive failed after " + std::to_string(offset_) + " bytes: " + what;
  failed_ = true;
}

}  // namespace downrange::archive
