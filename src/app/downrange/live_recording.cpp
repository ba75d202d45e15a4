#include "live_recording.hpp"

#include <filesystem>
#include <iostream>
#include <utility>

#include "flight.hpp"

namespace downrange::app {
namespace {

/// What is in the file, and what is not.
void tell(const archive::WrittenFile& file) {
  const std::string path = file.path.string();
  if (file.kept) std::cerr << file.messages_kept() << " messages in " << path << '\n';
  if (!file.kept)
    std::cerr << "downrange: " << path << " was removed or replaced: its " << file.messages_lost()
              << " messages are lost\n";
  else if (!file.status.failure.empty())
    std::cerr << "downrange: " << file.status.failure << "; " << file.messages_lost() << " messages are lost\n";
  else if (file.messages_lost() > 0)
    std::cerr << "downrange: " << path << ": " << file.messages_lost() << " messages are lost, the disk is too slow\n";
}

}  // namespace

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

RecordingEnd LiveRecording::close(const std::map<std::string, std::string>& status) {
  const std::scoped_lock lock(mutex_);
  if (!status.empty()) archive_.writer().metadata("status", status);
  RecordingEnd end;
  for (const archive::WrittenFile& file : archive_.close()) {
    tell(file);
    end.kept += file.messages_kept();
    end.lost += file.messages_lost();
    // Of those before the last, only their messages matter.
    end.code = end.lost > 0 || !file.kept || !file.status.ok() ? exit_failed : exit_ok;
  }
  return end;
}

}  // namespace downrange::app
