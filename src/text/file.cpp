#include "text/file.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <system_error>

namespace downrange::text {
namespace {

class Descriptor {
 public:
  explicit Descriptor(int fd) : fd_(fd) {}
  ~Descriptor() { ::close(fd_); }
  Descriptor(const Descriptor&) = delete;
  Descriptor& operator=(const Descriptor&) = delete;
  [[nodiscard]] int get() const { return fd_; }

 private:
  int fd_;
};

std::string reason(int error) { return std::generic_category().message(error); }

const char* kind_of(mode_t mode) {
  if (S_ISDIR(mode)) return "a folder";
  if (S_ISFIFO(mode)) return "a pipe";
  if (S_ISSOCK(mode)) return "a socket";
  return "a device";
}

}  // namespace

int open_regular(const std::filesystem::path& file) {
  struct stat status {};
  // Looked at first: opening a device can do something to it.
  if (::stat(file.c_str(), &status) != 0) {
    throw FileError(errno == ENOENT ? "no such file" : "cannot be read: " + reason(errno));
  }
  const auto refuse = [](mode_t mode) { throw FileError(std::string("is ") + kind_of(mode) + ", not a file"); };
  if (!S_ISREG(status.st_mode)) refuse(status.st_mode);
  // Not blocking, for what may have become a pipe since.
  const int fd = ::open(file.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK);
  if (fd < 0) throw FileError("cannot be read: " + reason(errno));
  if (::fstat(fd, &status) != 0 || !S_ISREG(status.st_mode)) {
    ::close(fd);
    refuse(status.st_mode);
  }
  return fd;
}

std::string read_file(const std::filesystem::path& file, std::uint64_t max_size) {
  const Descriptor fd(open_regular(file));
  std::string text;
  constexpr std::size_t block = 1 << 16;
  std::size_t have = 0;
  for (;;) {
    text.resize(have + block);
    const ssize_t got = ::read(fd.get(), text.data() + have, block);
    if (got < 0 && errno == EINTR) continue;
    if (got < 0) throw FileError("cannot be read: " + reason(errno));
    have += static_cast<std::size_t>(got);
    if (have > max_size) throw FileError("is larger than " + show_size(max_size));
    if (got == 0) break;
  }
  text.resize(have);
  return text;
}

std::string show_size(std::uint64_t bytes) {
  if (bytes >= 1'000'000) return std::to_string(bytes / 1'000'000) + " MB";
  if (bytes >= 1'000) return std::to_string(bytes / 1'000) + " kB";
  return std::to_string(bytes) + " bytes";
}

}  // namespace downrange::text
