#include <archive/import_csv.hpp>
#include <cstdio>
#include <iostream>
#include <text/printable.hpp>

#include "command.hpp"
#include "progress.hpp"

namespace downrange::app {
namespace {

struct Options {
  std::string mapping;
  std::string out;
  std::string folder;
  std::string config;
  bool keys = false;
  OutputFiles files;
};

/// What the import reads: the mapping and the files it names.
std::vector<std::string> inputs_of(const std::string& mapping, const archive::ImportOptions& options) {
  std::vector<std::string> inputs{mapping};
  for (const auto& file : archive::load_mapping(mapping, options.folder).files) inputs.push_back(file.path.string());
  return inputs;
}

void print(const char* what, const archive::Defects& defects) {
  if (defects.count == 0) return;
  std::printf("    %-22s %llu", what, static_cast<unsigned long long>(defects.count));
  const char* separator = ": line ";
  for (const auto& row : defects.first) {
    std::printf("%s%llu%s%s%s", separator, static_cast<unsigned long long>(row.line), row.what.empty() ? "" : " (",
                text::printable(row.what).c_str(), row.what.empty() ? "" : ")");
    separator = ", ";
  }
  std::printf("%s\n", defects.count > defects.first.size() ? ", ..." : "");
}

void print(const archive::FileReport& file) {
  std::printf("%s -> %s: %llu of %llu rows imported\n", text::printable(file.path.string()).c_str(),
              file.source.c_str(), static_cast<unsigned long long>(file.imported),
              static_cast<unsigned long long>(file.rows));
  const char* separator = "    read as                ";
  for (const std::string& note : file.notes) {
    std::printf("%s%s", separator, text::printable(note).c_str());
    separator = ", ";
  }
  if (!file.notes.empty()) std::printf("\n");
  std::printf("    plausible?             %s\n", file.plausibility.c_str());
  for (const std::string& doubt : file.doubts) std::printf("    DOUBTFUL               %s\n", doubt.c_str());
  print("left out, malformed", file.malformed);
  print("left out, no value", file.not_finite);
  print("time steps backwards", file.epoch_backwards);
  print("same time again", file.epoch_repeated);
  print("same value again", file.value_repeated);
  print("received out of order", file.received_backwards);
}

int import(const Options& o) {
  Progress progress("importing");
  archive::ImportOptions options;
  if (!o.folder.empty()) options.folder = o.folder;
  if (!o.config.empty()) options.leap_seconds = config::load(o.config).range.leap_seconds;
  options.progress = [&](double fraction) { progress.show(fraction); };
  o.files.check({o.out}, inputs_of(o.mapping, options));
  options.writer.overwrite = o.files.overwrite(o.out);
  const archive::ImportReport report = archive::import_csv(o.mapping, o.out, options);
  progress.done();
  for (const auto& file : report.files) print(file);
  std::printf("%s: %llu events, %llu truth records\n", o.out.c_str(), static_cast<unsigned long long>(report.events),
              static_cast<unsigned long long>(report.truths));
  if (report.archive.ok()) return exit_ok;
  std::cerr << "downrange: " << o.out << ": " << report.archive.failure << '\n';
  return exit_failed;
}

}  // namespace

void add_import(CLI::App& app, Run& run) {
  auto o = std::make_shared<Options>();
  CLI::App* command = app.add_subcommand(
      "import", "Import tables of radar plots, tracker angles and GPS fixes (CSV and its kin), by a declared mapping");
  command->add_option("MAPPING", o->mapping, "Which column means what, e.g. tools/imports/falcon9_crs11.toml");
  command->add_option("--out", o->out, "Archive to write (.mcap)");
  command->add_option("--folder", o->folder, "Folder of the files (default: the mapping's)");
  command->add_option("--config", o->config, "Configuration of the range, for its leap_seconds");
  command->add_flag("--keys", o->keys, "Print every key of a mapping, the fields and the units");
  o->files.add_to(*command);
  command->footer(
      "Rows that cannot be read are left out and listed. Rows that can are passed on as they are, defects of\n"
      "their clocks included: the service's ingest judges them when the archive is replayed. Look at the line of\n"
      "each file's times, ranges and angles: a wrong unit shows there.\n"
      "Exit code 1: a file does not fit its mapping, gives no row, or cannot be what the mapping says.");
  command->callback([o, &run] {
    run = [o] {
      if (o->keys) {
        std::fputs(archive::mapping_reference().c_str(), stdout);
        return exit_ok;
      }
      if (o->mapping.empty()) throw CLI::RequiredError("MAPPING");
      if (o->out.empty()) throw CLI::RequiredError("--out");
      return import(*o);
    };
  });
}

}  // namespace downrange::app
