#pragma once
/// The flight recorder: what the engine consumed and made, into one archive per flight.

#include <archive/writer.hpp>
#include <filesystem>
#include <string>

#include "config/service_config.hpp"

namespace downrange::app {

/// Throws std::runtime_error naming the folder when archives could not be written there; makes the folder.
void require_archive_folder(const config::ArchiveConfig& config);

class Recorder {
 public:
  /// Opens the archive named after range, node and `start`, configuration attached. Throws archive::ArchiveError.
  Recorder(const config::ServiceConfig& config, Time start);

  void consumed(const Event& event) { writer_.write(event); }
  void produced(const Result& result) {
    if (outputs_) writer_.write(result);
  }
  /// Closes the account of the engine and the file; logs how that went.
  void finish(Time last_tick);

  /// "recording", or what is wrong. A failure is logged when it is first seen.
  [[nodiscard]] std::string state();

 private:
  std::filesystem::path path_;
  bool outputs_;
  archive::Writer writer_;
  bool failure_logged_ = false;
};

}  // namespace downrange::app
