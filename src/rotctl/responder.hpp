#pragma once
/// What a rotator daemon answers who asks where an antenna points, and nothing more: it moves nothing. One per
/// connection; no sockets here.

#include <functional>
#include <optional>
#include <string>
#include <string_view>

#include "rotctl/protocol.hpp"
#include "stage/slave/command_book.hpp"

namespace downrange::rotctl {

/// What is told of the antenna.
struct Told {
  Travel travel;
  std::string info;  ///< answer to `_`: one line
  std::function<std::optional<CommandedPointing>()>
      aim;  ///< where it is commanded to point now; nothing: no command holds
};

/// Bounds of a connection.
struct Patience {
  Duration line = milliseconds(10'000);   ///< a line that was begun is whole by then
  Duration idle = milliseconds(600'000);  ///< something comes by then
};

class Responder {
 public:
  Responder(const Told& told, const Patience& patience, Duration up)
      : told_(told), patience_(patience), heard_(up), begun_(up) {}

  /// Its answers; a line each command, in order. Answers that the client does not read are its own affair: `closing`.
  [[nodiscard]] std::string receive(std::string_view bytes, Duration up);
  /// The client has said so, speaks no lines, or keeps us waiting.
  [[nodiscard]] bool closing(Duration up) const { return quit_ || up >= deadline(); }
  /// When waiting ends.
  [[nodiscard]] Duration deadline() const;

 private:
  [[nodiscard]] std::string answer(std::string_view line);

  const Told& told_;
  const Patience patience_;
  LineReader lines_;
  Duration heard_;  ///< the last whole line
  Duration begun_;  ///< the line that is not whole yet
  bool quit_ = false;
};

}  // namespace downrange::rotctl
