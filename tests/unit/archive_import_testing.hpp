#pragma once
/// What the importer's tests share: a mapping, the file it names, and what becomes of them.

#include <archive/import_csv.hpp>
#include <archive/replay.hpp>

#include "archive_testing.hpp"

namespace downrange::archive {

class ArchiveImport : public testing::Test {
 protected:
  ImportReport import(const std::string& mapping) {
    write_text(folder_ / "import.toml", mapping);
    ImportOptions options;
    options.writer.overwrite = true;
    options.progress = [this](double fraction) {
      EXPECT_GE(fraction, progress_);
      EXPECT_LE(fraction, 1.0);
      progress_ = fraction;
    };
    progress_ = 0;
    ImportReport report = import_csv(folder_ / "import.toml", folder_ / "out.mcap", options);
    EXPECT_EQ(progress_, 1.0);
    return report;
  }
  std::vector<Event> events() {
    EventSource source(folder_ / "out.mcap");
    std::vector<Event> all;
    while (auto event = source.next()) all.push_back(*event);
    return all;
  }
  std::vector<RadarTspi> radars() {
    std::vector<RadarTspi> all;
    for (const Event& event : events()) {
      if (const auto* radar = std::get_if<RadarTspi>(&event)) all.push_back(*radar);
    }
    return all;
  }
  /// What an import of this mapping is refused with.
  std::string refusal(const std::string& mapping) {
    try {
      static_cast<void>(import(mapping));
    } catch (const ImportError& error) {
      return error.what();
    }
    return "";
  }

  TemporaryFolder folder_;
  double progress_ = 0;
};

inline std::string replaced(std::string text, const std::string& from, const std::string& to) {
  const std::size_t at = text.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  return text.replace(at, from.size(), to);
}

}  // namespace downrange::archive
