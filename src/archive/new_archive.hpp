#pragma once
/// An archive that takes its name when it is whole: a command that fails leaves nothing behind that could be taken for
/// a flight, and what stood there before as it was.

#include <archive/writer.hpp>
#include <optional>

namespace downrange::archive {

class NewArchive {
 public:
  /// Writes beside `path`, under its name with ".part" behind it; what is no regular file (a device, a pipe) is written
  /// directly. Throws ArchiveError when the file exists already, unless `options.overwrite`, or cannot be created.
  explicit NewArchive(std::filesystem::path path, const WriterOptions& options = {});
  /// Without a successful close(): what was written is removed.
  ~NewArchive();
  NewArchive(const NewArchive&) = delete;
  NewArchive& operator=(const NewArchive&) = delete;

  [[nodiscard]] Writer& writer() { return *writer_; }

  /// Closes, and gives the file its name. Where status().ok() is false there is no file, and `failure` says so.
  [[nodiscard]] WriterStatus close();

 private:
  void remove_part();

  std::filesystem::path path_;
  std::filesystem::path part_;  ///< empty: written directly, or named already
  bool overwrite_;
  std::optional<Writer> writer_;
};

}  // namespace downrange::archive
