#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <archive/input_file.hpp>
#include <archive/record.hpp>
#include <cerrno>
#include <system_error>
#include <text/file.hpp>

namespace downrange::archive {
namespace {

constexpr std::size_t read_ahead = 1 << 18;

ArchiveError error(const std::filesystem::path& path, const std::string& what) {
  return ArchiveError(path.string() + ": " + what);
}

}  // namespace

InputFile::InputFile(const std::filesystem::path& path) : path_(path) {
  try {
    fd_ = text::open_regular(path);
  } catch (const text::FileError& refused) {
    throw error(path, std::string("cannot open the archive: ") + refused.what());
  }
  struct stat status {};
  if (::fstat(fd_, &status) != 0) {
    const int reason = errno;
    ::close(fd_);
    throw error(path, "cannot open the archive: " + std::generic_category().message(reason));
  }
  size_ = static_cast<std::uint64_t>(status.st_size);
}

InputFile::~InputFile() { ::close(fd_); }

ByteView InputFile::peek(std::size_t size) {
  const auto wanted = static_cast<std::size_t>(std::min<std::uint64_t>(size, remaining()));
  if (end_ - begin_ < wanted) {
    std::copy(buffer_.begin() + static_cast<std::ptrdiff_t>(begin_),
              buffer_.begin() + static_cast<std::ptrdiff_t>(end_), buffer_.begin());
    end_ -= begin_;
    begin_ = 0;
    const auto ahead = static_cast<std::size_t>(std::min<std::uint64_t>(read_ahead, remaining()));
    buffer_.resize(std::max(buffer_.size(), std::max(wanted, ahead)));
    while (end_ < wanted) {
      const ssize_t got = ::read(fd_, buffer_.data() + end_, buffer_.size() - end_);
      if (got < 0 && errno == EINTR) continue;
      if (got < 0) throw error(path_, "cannot read: " + std::generic_category().message(errno));
      if (got == 0) {  // someone cut the file off since it was opened
        size_ = offset_ + end_;
        break;
      }
      end_ += static_cast<std::size_t>(got);
    }
  }
  return ByteView(buffer_).subspan(begin_, std::min(wanted, end_ - begin_));
}

void InputFile::skip(std::size_t size) {
  begin_ += size;
  offset_ += size;
}

bool InputFile::ends_with(ByteView bytes) const {
  if (size_ < bytes.size()) return false;
  Bytes end(bytes.size());
  std::size_t have = 0;
  while (have < end.size()) {
    const auto at = static_cast<off_t>(size_ - end.size() + have);
    const ssize_t got = ::pread(fd_, end.data() + have, end.size() - have, at);
    if (got < 0 && errno == EINTR) continue;
    if (got < 0) throw error(path_, "cannot read: " + std::generic_category().message(errno));
    if (got == 0) return false;
    have += static_cast<std::size_t>(got);
  }
  return std::equal(end.begin(), end.end(), bytes.begin());
}

}  // namespace downrange::archive
