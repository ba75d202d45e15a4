#pragma once
/// Text files from outside: bounded, and never waited for.

#include <cstdint>
#include <filesystem>
#include <stdexcept>
#include <string>

namespace downrange::text {

/// A file that cannot be read. what() is the reason alone, e.g. "no such file": the caller knows the path.
class FileError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// Opens a regular file for reading and returns its descriptor; the caller closes it. A folder, pipe, socket or device
/// is refused without waiting for whoever may be at its other end. Throws FileError.
[[nodiscard]] int open_regular(const std::filesystem::path& file);

/// The whole of a regular file. Throws FileError, also when there are more than `max_size` bytes.
[[nodiscard]] std::string read_file(const std::filesystem::path& file, std::uint64_t max_size);

/// "4 MB", "300 kB", "12 bytes": a size for people.
[[nodiscard]] std::string show_size(std::uint64_t bytes);

}  // namespace downrange::text
