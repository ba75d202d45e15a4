#include "rotctl/responder.hpp"

#include <algorithm>
#include <array>

namespace downrange::rotctl {
namespace {

enum class Request { Pointing, Position, Stop, Park, Reset, Move, Info, State, Quit, None };

struct Command {
  std::string_view letter;
  std::string_view name;
  int arguments;
  Request request;
};

constexpr std::array commands{
    Command{"p", "\\get_pos", 0, Request::Pointing}, Command{"P", "\\set_pos", 2, Request::Position},
    Command{"S", "\\stop", 0, Request::Stop},        Command{"K", "\\park", 0, Request::Park},
    Command{"R", "\\reset", 1, Request::Reset},      Command{"M", "\\move", 2, Request::Move},
    Command{"_", "\\get_info", 0, Request::Info},    Command{"", "\\dump_state", 0, Request::State},
    Command{"q", "\\quit", 0, Request::Quit},        Command{"Q", "", 0, Request::Quit},
};

/// The first word, and the rest.
std::string_view take_word(std::string_view& line) {
  line.remove_prefix(std::min(line.find_first_not_of(" \t"), line.size()));
  const std::size_t end = std::min(line.find_first_of(" \t"), line.size());
  const std::string_view word = line.substr(0, end);
  line.remove_prefix(end);
  return word;
}

/// None: no command, or its arguments are not the numbers that it takes.
Request parse(std::string_view line) {
  const std::string_view word = take_word(line);
  const auto known = std::ranges::find_if(
      commands, [&](const Command& c) { return !word.empty() && (word == c.letter || word == c.name); });
  if (known == commands.end()) return Request::None;
  for (int i = 0; i < known->arguments; ++i)
    if (!parse_degrees(take_word(line))) return Request::None;
  return take_word(line).empty() ? known->request : Request::None;
}

}  // namespace

std::string Responder::receive(std::string_view bytes, Duration up) {
  std::string answers;
  if (!lines_.partial()) begun_ = up;
  lines_.add(bytes);
  while (!quit_) {
    const std::optional<std::string> line = lines_.next();
    if (lines_.endless()) {
      quit_ = true;
      return answers + report_line(rprt_invalid);
    }
    if (!line) break;
    heard_ = begun_ = up;
    answers += answer(*line);
  }
  return answers;
}

Duration Responder::deadline() const {
  const Duration idle = heard_ + patience_.idle;
  return lines_.partial() ? std::min(idle, begun_ + patience_.line) : idle;
}

std::string Responder::answer(std::string_view line) {
  if (line.find_first_not_of(" \t") == std::string_view::npos) return {};
  switch (parse(line)) {
    case Request::Pointing:
      if (const std::optional<CommandedPointing> aim = told_.aim())
        return pointing_lines(aim->azimuth_rad, aim->elevation_rad);
      return report_line(rprt_not_available);
    case Request::State:
      return state_lines(told_.travel);
    case Request::Info:
      return told_.info + '\n';
    case Request::Quit:
      quit_ = true;
      return {};
    case Request::Position:
    case Request::Stop:
    case Request::Park:
    case Request::Reset:
    case Request::Move:
      return report_line(rprt_not_available);
    case Request::None:
      break;
  }
  return report_line(rprt_invalid);
}

}  // namespace downrange::rotctl
