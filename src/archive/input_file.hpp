#pragma once
/// Sequential buffered reading of a file whose size is taken when it is opened.

#include <archive/bytes.hpp>
#include <cstdint>
#include <filesystem>

namespace downrange::archive {

class InputFile {
 public:
  /// Throws ArchiveError when the file cannot be opened or is not a regular file.
  explicit InputFile(const std::filesystem::path& path);
  ~InputFile();
  InputFile(const InputFile&) = delete;
  InputFile& operator=(const InputFile&) = delete;

  [[nodiscard]] std::uint64_t offset() const { return offset_; }
  [[nodiscard]] std::uint64_t size() const { return size_; }
  [[nodiscard]] std::uint64_t remaining() const { return size_ - offset_; }

  /// The next `size` bytes without consuming them, valid until the next call; fewer than asked where the file ends.
  /// Throws ArchiveError when the disk cannot be read.
  [[nodiscard]] ByteView peek(std::size_t size);
  /// Consumes bytes that were peeked.
  void skip(std::size_t size);
  /// Whether the file's last bytes, which need not have been peeked, are these. Throws as peek.
  [[nodiscard]] bool ends_with(ByteView bytes) const;

 private:
  std::filesystem::path path_;
  int fd_ = -1;
  std::uint64_t size_ = 0;
  std::uint64_t offset_ = 0;  ///< of the next byte to consume
  Bytes buffer_;
  std::size_t begin_ = 0;  ///< of the unconsumed bytes in the buffer
  std::size_t end_ = 0;
};

}  // namespace downrange::archive
