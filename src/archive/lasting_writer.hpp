#pragma once
/// An archive whose file or folder may be taken away while it is written: it goes on in a new file.

#include <archive/writer.hpp>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace downrange::archive {

/// `wanted`, or with -2, -3 ... before its extension: the first name that no file has.
[[nodiscard]] std::filesystem::path unused_path(const std::filesystem::path& wanted);

/// What begins each file: attachments, metadata. `continues` is the file that it takes the place of, empty for the
/// first.
using Beginning = std::function<void(Writer& writer, const std::filesystem::path& continues)>;

/// One of the files, at the end.
struct WrittenFile {
  std::filesystem::path path;  ///< where it is: under its name, or where it was moved to; where it was, if it is gone
  FileId id;
  WriterStatus status;
  bool kept = true;  ///< it is there; else the messages written to it are lost as well

  [[nodiscard]] std::uint64_t messages_kept() const { return kept ? status.messages_written : 0; }
  [[nodiscard]] std::uint64_t messages_lost() const {
    return status.messages_lost + status.messages_written - messages_kept();
  }
};

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

  /// Closes the file. All files there were, in their order: every message that was written is in the account of one.
  /// One that was taken away before, and could not be replaced, has what was written since.
  [[nodiscard]] std::vector<WrittenFile> close();

 private:
  /// Closes the file in hand for good and notes what became of it.
  void leave();
  void begin(const std::filesystem::path& path, const std::filesystem::path& continues);

  const std::filesystem::path first_path_;
  const WriterOptions options_;
  const Beginning beginning_;
  std::filesystem::path path_;
  std::unique_ptr<Writer> writer_;
  std::vector<WrittenFile> left_;
  std::string told_;
};

}  // namespace downrange::archive
