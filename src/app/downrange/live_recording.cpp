#include "live_recording.hpp"

#include <filesystem>
#include <iostream>
#include <utility>

#include "flight.hpp"

namespace downrange::app {

LiveRecording::LiveRecording(const std::string& path, const archive::WriterOptions& options, std::string configuration)
    : archive_(path, options,
               [text = std::move(configuration)](archive::Writer& writer, const std::filesystem::path& continues) {
                 writer.attach("config.toml", "application/toml", text);
                 if (!continues.empty()) writer.metadata("downrange", {{"continues", continues.string()}});
               }) {}

bool LiveRecording::look_after() {
  const std::scoped_lock lock(mutex_);
  if (archive_.writer().failed()) return false;
  const auto now = std::chrono::steady_clock::now();
  if (now < next_look_) return true;
  next_look_ = now + std::chrono::seconds(1);
  if (const auto event = archive_.look()) std::cerr << "downrange: " << *event << '\n';
  return true;
}

int LiveRecording::close(const std::map<std::string, std::string>& status) {
  const std::scoped_lock lock(mutex_);
  const std::string path = archive_.path().string();
  if (!archive_.writer().in_place()) {
    std::cerr << "downrange: " << path << " was removed or replaced: what it held is lost\n";
    return exit_failed;
  }
  if (!status.empty()) archive_.writer().metadata("status", status);
  return close_archive(archive_.writer(), path);
}

}  // namespace downrange::app
