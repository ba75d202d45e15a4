#pragma once
/// The flight recorder: what the engine consumed and made, into one archive per flight.

#include <archive/lasting_writer.hpp>
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

  void consumed(const Event& event) { archive_.writer().write(event); }
  void produced(const Result& result) {
    if (outputs_) archive_.writer().write(result);
  }
  /// Closes the account of the engine and the file; logs how that went.
  void finish(Time last_tick);

  /// "recording", or what is wrong; to be asked once a second. A file that was taken away is noticed here, and another
  /// begun. What goes wrong is logged when it is first seen.
  [[nodiscard]] std::string state();

 private:
  archive::LastingWriter archive_;
  bool outputs_;
  bool taken_away_ = false;  ///< the file, at some time
  bool failure_logged_ = false;
};

}  // namespace downrange::app
