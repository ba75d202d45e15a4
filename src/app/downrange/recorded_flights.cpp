#include "recorded_flights.hpp"

#include <unistd.h>

#include <archive/import_csv.hpp>
#include <archive/reader.hpp>
#include <archive/replay.hpp>
#include <array>
#include <cstdlib>
#include <stdexcept>

#include "config/load.hpp"
#include "shipped_files.hpp"

namespace downrange::app {
namespace {

namespace fs = std::filesystem;

constexpr std::array known{"falcon_heavy_demo", "falcon9_crs11"};

fs::path mapping_of(const std::string& flight) { return shipped_file(fs::path("imports") / (flight + ".toml")); }
fs::path range_file() { return shipped_file("config/cape.toml"); }

/// An archive of this process's own that is gone with this object.
class TemporaryArchive {
 public:
  explicit TemporaryArchive(const std::string& name)
      : path_(fs::temp_directory_path() / ("downrange-" + name + "-" + std::to_string(getpid()) + ".mcap")) {}
  ~TemporaryArchive() {
    std::error_code ignored;
    fs::remove(path_, ignored);
  }
  TemporaryArchive(const TemporaryArchive&) = delete;
  TemporaryArchive& operator=(const TemporaryArchive&) = delete;
  [[nodiscard]] const fs::path& path() const { return path_; }

 private:
  fs::path path_;
};

}  // namespace

fs::path flights_folder(const std::string& given) {
  if (!given.empty()) return given;
  if (const char* data = std::getenv("DOWNRANGE_DATA")) return data;
  if (const char* shared = std::getenv("DOWNRANGE_SHARED")) return fs::path(shared) / "data";
  return (fs::path(DOWNRANGE_SOURCE_DIR) / ".." / "shared" / "data").lexically_normal();
}

std::vector<std::string> flights_in(const fs::path& folder) {
  std::vector<std::string> there;
  for (const char* flight : known)
    if (fs::is_directory(folder / flight)) there.emplace_back(flight);
  return there;
}

std::vector<std::string> files_of_flight(const fs::path& folder, const std::string& flight) {
  std::vector<std::string> files{range_file().string(), mapping_of(flight).string()};
  for (const auto& file : archive::load_mapping(mapping_of(flight), folder / flight).files)
    files.push_back(file.path.string());
  return files;
}

experiment::flights::RecordedFlight load_flight(const fs::path& folder, const std::string& flight) {
  experiment::flights::RecordedFlight loaded;
  loaded.name = flight;
  loaded.range = config::load(range_file()).range;
  const TemporaryArchive file(flight);
  archive::ImportOptions options;
  options.folder = folder / flight;
  options.writer.overwrite = true;
  const archive::ImportReport report = archive::import_csv(mapping_of(flight), file.path(), options);
  if (!report.archive.ok()) throw std::runtime_error(file.path().string() + ": " + report.archive.failure);
  loaded.liftoff = report.liftoff;
  archive::EventSource source(file.path());
  source.on_truth([&loaded](const archive::Truth& t) {
    loaded.target = t.target;
    loaded.truth.push_back({t.epoch, {t.position, t.velocity}});
  });
  while (const auto event = source.next()) loaded.events.push_back(*event);
  if (loaded.truth.empty()) throw std::runtime_error((folder / flight).string() + ": holds no true trajectory");
  return loaded;
}

}  // namespace downrange::app
