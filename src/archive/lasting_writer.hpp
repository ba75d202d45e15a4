#pragma once
/// An archive whose file or folder may be taken away while it is written: it goes on in a new file.

#include <archive/writer.hpp>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>

namespace downrange::archive {

/// `wanted`, or with -2, -3 ... before its extension: the first name that no file has.
[[nodiscard]] std::filesystem::path unused_path(const std::filesystem::path& wanted);

/// What begins each file: attachments, metadata. `continues` is the file that it takes the place of, empty for the
/// first.
using Beginning = std::function<void(Writer& writer, const std::filesystem::path& continues)>;

class LastingWriter {
 public:
  /// Throws ArchiveError where the first file cannot be created.
  LastingWriter(std::filesystem::path path, const WriterOptions& options, Beginning beginning);

  [[nodiscard]] Writer& writer() { return *writer_; }
  /// Of the file that is written now.
  [[nodiscard]] const std::filesystem::path& path() const { return path_; }

  /// To be called once a second or so, by the thread that writes. What waits is handed to the file: where nothing more
  /// comes, no record is lost with the process. Where the file is no more in its place, another is begun beside
  /// it, the folder made anew if need be; no file is written over. What was done, or why it could not be, in words:
  /// each once. A later call tries again.
  [[nodiscard]] std::optional<std::string> look();

 private:
  void begin(const std::filesystem::path& path, const std::filesystem::path& continues);

  const std::filesystem::path first_path_;
  const WriterOptions options_;
  const Beginning beginning_;
  std::filesystem::path path_;
  std::unique_ptr<Writer> writer_;
  std::string told_;
};

}  // namespace downrange::archive
