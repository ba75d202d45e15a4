#include <algorithm>
#include <archive/import/file_import.hpp>
#include <archive/import/name_parts.hpp>
#include <archive/import_csv.hpp>
#include <archive/new_archive.hpp>

namespace downrange::archive {
namespace {

/// Reading takes most of the time of an import.
constexpr double reading_share = 0.8;
/// Events between two calls of the progress callback.
constexpr std::size_t progress_events = 1024;

MissionEvent liftoff_event(const ImportMapping& mapping) {
  MissionEvent event;
  event.mission = mapping.mission;
  event.label = "lift-off";
  event.kind = MissionEventKind::Liftoff;
  event.sequence = 1;
  event.epoch = mapping.liftoff;
  event.received = mapping.liftoff;
  return event;
}

bool received_before(const Event& a, const Event& b) {
  const Time received_a = received_of(a);
  const Time received_b = received_of(b);
  return received_a != received_b ? received_a < received_b : step_order_less(a, b);
}

void write_archive(const Imported& imported, const ImportMapping& mapping, const std::filesystem::path& archive,
                   const ImportOptions& options, ImportReport& report) {
  NewArchive made(archive, options.writer);
  Writer& writer = made.writer();
  writer.attach("import.toml", "application/toml", mapping.text, mapping.liftoff);
  for (std::size_t i = 0; i < report.files.size(); ++i) {
    const FileReport& file = report.files[i];
    writer.metadata("downrange.import." + std::to_string(i + 1) + '.' + file.path.filename().string(),
                    {{"rows", std::to_string(file.rows)},
                     {"imported", std::to_string(file.imported)},
                     {"filtered", std::to_string(file.passed_over.filtered)},
                     {"malformed", std::to_string(file.malformed.count)},
                     {"not_finite", std::to_string(file.not_finite.count)},
                     {"epoch_backwards", std::to_string(file.epoch_backwards.count)},
                     {"epoch_repeated", std::to_string(file.epoch_repeated.count)},
                     {"value_repeated", std::to_string(file.value_repeated.count)},
                     {"received_backwards", std::to_string(file.received_backwards.count)}});
  }
  auto truth = imported.truths.begin();
  for (std::size_t i = 0; i < imported.events.size(); ++i) {
    for (; truth != imported.truths.end() && truth->epoch <= received_of(imported.events[i]); ++truth) {
      writer.write_truth(*truth);
    }
    writer.write(imported.events[i]);
    if (options.progress && i % progress_events == 0) {
      const double written = static_cast<double>(i) / static_cast<double>(imported.events.size());
      options.progress(reading_share + (1 - reading_share) * written);
    }
  }
  for (; truth != imported.truths.end(); ++truth) writer.write_truth(*truth);
  report.archive = made.close();
  if (!report.archive.ok()) throw ArchiveError(report.archive.failure);
}

}  // namespace

ImportReport import_csv(const std::filesystem::path& mapping_file, const std::filesystem::path& archive,
                        const ImportOptions& options) {
  const ImportMapping mapping = load_mapping(mapping_file, options.folder);
  const FlightClock clock{mapping.liftoff, mapping.leap_seconds ? mapping.leap_seconds : options.leap_seconds};
  ImportReport report;
  report.liftoff = mapping.liftoff;
  Imported imported;
  imported.events.emplace_back(liftoff_event(mapping));
  std::size_t done = 0;
  for (const FileMapping& file : mapping.files) {
    const NameParts parts = parts_by_name(file);
    for (std::size_t i = 0; i < parts.files.size(); ++i) {
      const auto progress = [&](double share) {
        const double read =
            static_cast<double>(done) + (static_cast<double>(i) + share) / static_cast<double>(parts.files.size());
        if (options.progress) options.progress(reading_share * read / static_cast<double>(mapping.files.size()));
      };
      FileReport& part = report.files.emplace_back(import_file(parts.files[i], clock, imported, progress));
      if (!parts.rows[i].empty()) part.notes.push_back("rows of " + parts.rows[i]);
      if (i == 0 && parts.unnamed > 0) part.notes.push_back(std::to_string(parts.unnamed) + " rows without a name");
    }
    ++done;
  }
  std::stable_sort(imported.events.begin(), imported.events.end(), received_before);
  std::stable_sort(imported.truths.begin(), imported.truths.end(),
                   [](const Truth& a, const Truth& b) { return a.epoch < b.epoch; });
  report.events = imported.events.size();
  report.truths = imported.truths.size();
  report.first_received = received_of(imported.events.front());
  report.last_received = received_of(imported.events.back());

  write_archive(imported, mapping, archive, options, report);
  if (options.progress) options.progress(1.0);
  return report;
}

}  // namespace downrange::archive
