#pragma once
/// An archive of what arrives live, for `record` and `watch --record`: written from the middleware's threads.

#include <archive/lasting_writer.hpp>
#include <chrono>
#include <cstdint>
#include <map>
#include <mutex>
#include <string>

namespace downrange::app {

/// How a recording ended.
struct RecordingEnd {
  int code = 0;            ///< the exit code: failed where messages are lost or the last file is not there
  std::uint64_t kept = 0;  ///< messages in files that are there
  std::uint64_t lost = 0;
};

class LiveRecording {
 public:
  /// `configuration`: attached to each file. Throws archive::ArchiveError where the first file cannot be created.
  LiveRecording(const std::string& path, const archive::WriterOptions& options, std::string configuration);

  /// An event or a result, from any thread.
  template <class Record>
  void write(const Record& record) {
    const std::scoped_lock lock(mutex_);
    archive_.writer().write(record);
  }

  /// To be called a few times a second: looks after the file once a second and says on stderr when it was taken away.
  /// False: it can be written no more.
  [[nodiscard]] bool look_after();

  /// Closes the file; `status`: its metadata of that name, none where empty. Says on stderr how many messages are in
  /// which file, and how many were lost with which.
  [[nodiscard]] RecordingEnd close(const std::map<std::string, std::string>& status = {});

 private:
  std::mutex mutex_;
  archive::LastingWriter archive_;
  std::chrono::steady_clock::time_point next_look_{};
};

}  // namespace downrange::app
