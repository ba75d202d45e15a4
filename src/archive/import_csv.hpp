#pragma once
/// Imports measurements that exist as tables of text (CSV and its kin) into an archive, by a declared mapping
/// (import/mapping.hpp).

#include <archive/import/mapping.hpp>
#include <archive/import/table_reader.hpp>
#include <archive/writer.hpp>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

namespace downrange::archive {

/// How often something was wrong, and the first few places.
struct Defects {
  struct Row {
    std::uint64_t line = 0;  ///< in the file, from 1
    std::string what;
  };
  std::uint64_t count = 0;
  std::vector<Row> first;  ///< at most `shown`
  static constexpr std::size_t shown = 5;
};

struct FileReport {
  std::filesystem::path path;
  FileKind kind = FileKind::Radar;
  Name source;  ///< radar, telemetry station; for truth: the target
  std::uint64_t rows = 0;
  std::uint64_t imported = 0;

  std::vector<std::string> notes;   ///< how it was read, where the mapping does not say so
  std::string plausibility;         ///< spans of its times and values, for a person to look at
  std::vector<std::string> doubts;  ///< what can hardly be as the mapping says
  PassedOver passed_over;
  std::uint64_t left_empty = 0;  ///< optional values that rows do not have

  // Rows left out.
  Defects malformed;   ///< fields missing, not a number, no such place or time
  Defects not_finite;  ///< empty, NaN or infinite

  // Rows passed on as they are: the engine's ingest judges them.
  Defects epoch_backwards;     ///< epoch before that of the row before
  Defects epoch_repeated;      ///< the same epoch again
  Defects value_repeated;      ///< the same position or plot at a later epoch
  Defects received_backwards;  ///< received before the row before
};

struct ImportReport {
  Time liftoff;
  Time first_received;  ///< of the events; lift-off when there are none
  Time last_received;
  std::uint64_t events = 0;  ///< lift-off included
  std::uint64_t truths = 0;
  std::vector<FileReport> files;
  WriterStatus archive;
};

struct ImportOptions {
  std::optional<std::filesystem::path> folder;    ///< of the files, instead of the mapping's
  std::optional<int> leap_seconds;                ///< GPS minus UTC, where the mapping does not say
  std::function<void(double fraction)> progress;  ///< 0 to 1, called now and then
  WriterOptions writer;
};

/// Imports every file of the mapping into a new archive: events in the order they were received (ties by topic, source,
/// target, sequence), the lift-off among them, truth records beside them, the mapping as attachment "import.toml".
/// The sequence of a record is its row's number in its file, or among its sorted rows. Imported measurements are not
/// simulated. Throws ImportError for a wrong mapping, a file that does not fit it and a file that gives no record;
/// ArchiveError when the archive cannot be written. Nothing is written before all files are read.
[[nodiscard]] ImportReport import_csv(const std::filesystem::path& mapping, const std::filesystem::path& archive,
                                      const ImportOptions& options = {});

}  // namespace downrange::archive
