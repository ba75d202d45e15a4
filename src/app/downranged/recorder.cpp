#include "recorder.hpp"

#include <spdlog/spdlog.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstring>
#include <ctime>
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

/// A name that no file has yet: flights are never recorded over.
std::filesystem::path free_path(const config::ServiceConfig& config, Time start) {
  std::filesystem::path base = config.archive.directory;
  if (is_file(base)) {
    base.replace_extension();
  } else {
    base /= std::string(config.range.name.view()) + '-' + std::string(config.node.id.view()) + '-' + utc_stamp(start);
  }
  std::filesystem::path path = base.string() + ".mcap";
  std::error_code unreadable;  // then the file cannot be made either, and the writer says why
  for (int n = 2; std::filesystem::exists(path, unreadable); ++n) {
    path = base.string() + '-' + std::to_string(n) + ".mcap";
  }
  return path;
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
    : path_(free_path(config, start)), outputs_(config.archive.outputs), writer_(path_, writer_options(config)) {
  writer_.attach("config.toml", "application/toml", config.text, start);
  writer_.metadata("downrange", {{"version", DOWNRANGE_VERSION},
                                 {"node", std::string(config.node.id.view())},
                                 {"configuration_hash", config.hash}});
  writer_.flush();
  spdlog::info("recording to {}", path_.string());
}

void Recorder::finish(Time last_tick) {
  writer_.write_last_tick(last_tick);
  const archive::WriterStatus status = writer_.close();
  if (status.ok()) {
    spdlog::info("recorded {} messages, {} bytes to {}", status.messages_written, status.bytes_written, path_.string());
  } else {
    spdlog::error("archive {} is not complete: {} messages lost{}{}", path_.string(), status.messages_lost,
                  status.failure.empty() ? "" : ": ", status.failure);
  }
}

std::string Recorder::state() {
  const archive::WriterStatus status = writer_.status();
  if (status.ok()) return "recording";
  if (!failure_logged_) {
    failure_logged_ = true;
    spdlog::error("archive failed, tracking goes on without it: {}",
                  status.failure.empty() ? "the disk is too slow, messages were lost" : status.failure);
  }
  return status.failure.empty() ? "recording with losses" : "failed";
}

}  // namespace downrange::app
