#include "recorder.hpp"

#include <spdlog/spdlog.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstring>
#include <ctime>
#include <map>
#include <stdexcept>
#include <system_error>

namespace downrange::app {
namespace {

bool is_file(const std::filesystem::path& path) { return path.extension() == ".mcap"; }

std::string utc_stamp(Time t) {
  const std::time_t seconds = t.ns / 1'000'000'000;
  std::tm utc{};
  gmtime_r(&seconds, &utc);
  std::array<char, 32> text{};
  std::strftime(text.data(), text.size(), "%Y%m%dT%H%M%SZ", &utc);
  return text.data();
}

std::filesystem::path file_of(const config::ServiceConfig& config, Time start) {
  std::filesystem::path path = config.archive.directory;
  if (is_file(path)) return path;
  return path / (std::string(config.range.name.view()) + '-' + std::string(config.node.id.view()) + '-' +
                 utc_stamp(start) + ".mcap");
}

archive::Beginning beginning(const config::ServiceConfig& config, Time start) {
  return [&config, start](archive::Writer& writer, const std::filesystem::path& continues) {
    writer.attach("config.toml", "application/toml", config.text, start);
    std::map<std::string, std::string> metadata{{"version", DOWNRANGE_VERSION},
                                                {"node", std::string(config.node.id.view())},
                                                {"configuration_hash", config.hash}};
    if (!continues.empty()) metadata["continues"] = continues.string();
    writer.metadata("downrange", metadata);
  };
}

archive::WriterOptions writer_options(const config::ServiceConfig& config) {
  archive::WriterOptions options;
  switch (config.archive.compression) {
    case config::Compression::None:
      options.compression = archive::Compression::None;
      break;
    case config::Compression::Lz4:
      options.compression = archive::Compression::Lz4;
      break;
    case config::Compression::Zstd:
      options.compression = archive::Compression::Zstd;
      break;
  }
  const bool live = config.clock.mode == config::ClockMode::Wall;
  options.backlog = live ? archive::Backlog::Drop : archive::Backlog::Wait;
  return options;
}

void log_end(const archive::WrittenFile& file) {
  const archive::WriterStatus& status = file.status;
  if (!file.kept) {
    spdlog::error("archive {} was removed or replaced: its {} messages are lost", file.path.string(),
                  file.messages_lost());
  } else if (status.ok()) {
    spdlog::info("recorded {} messages, {} bytes to {}", status.messages_written, status.bytes_written,
                 file.path.string());
  } else {
    spdlog::error("archive {} is not complete: {} messages lost{}{}", file.path.string(), status.messages_lost,
                  status.failure.empty() ? "" : ": ", status.failure);
  }
}

}  // namespace

void require_archive_folder(const config::ArchiveConfig& config) {
  const std::filesystem::path folder = is_file(config.directory) ? config.directory.parent_path() : config.directory;
  const auto fail = [&](const std::string& why) {
    throw std::runtime_error("archive.directory: archives cannot be written to " + folder.string() + ": " + why);
  };
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  if (error) fail(error.message());
  if (access(folder.c_str(), W_OK | X_OK) != 0) fail(std::strerror(errno));
}

Recorder::Recorder(const config::ServiceConfig& config, Time start)
    : archive_(archive::unused_path(file_of(config, start)), writer_options(config), beginning(config, start)),
      outputs_(config.archive.outputs) {
  spdlog::info("recording to {}", archive_.path().string());
}

void Recorder::finish(Time last_tick) {
  archive_.writer().write_last_tick(last_tick);
  for (const archive::WrittenFile& file : archive_.close()) log_end(file);
}

std::string Recorder::state() {
  if (const auto event = archive_.look()) {
    spdlog::error("archive {}", *event);
    taken_away_ = true;
  }
  const archive::WriterStatus status = archive_.writer().status();
  if (!archive_.writer().in_place()) return "failed: file was removed";
  if (status.ok()) return taken_away_ ? "recording anew: file removed" : "recording";
  if (!failure_logged_) {
    failure_logged_ = true;
    spdlog::error("archive failed, tracking goes on without it: {}",
                  status.failure.empty() ? "the disk is too slow, messages were lost" : status.failure);
  }
  return status.failure.empty() ? "recording with losses" : "failed";
}

}  // namespace downrange::app
