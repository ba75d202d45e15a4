#include "progress.hpp"

#include <unistd.h>

#include <algorithm>
#include <cstdio>

namespace downrange::app {

Progress::Progress(std::string what) : what_(std::move(what)), terminal_(isatty(STDERR_FILENO) != 0) {}

Progress::~Progress() { done(); }

void Progress::show(double fraction, const std::string& note) {
  fraction = std::clamp(fraction, 0.0, 1.0);
  if (!terminal_) {
    const int tenth = static_cast<int>(fraction * 10);
    if (tenth == last_tenth_) return;
    last_tenth_ = tenth;
    std::fprintf(stderr, "%s %3d %% %s\n", what_.c_str(), tenth * 10, note.c_str());
    return;
  }
  const auto now = std::chrono::steady_clock::now();
  if (open_ && fraction < 1 && now - drawn_ < std::chrono::milliseconds(100)) return;
  drawn_ = now;
  draw(fraction, note);
}

void Progress::draw(double fraction, const std::string& note) {
  constexpr int width = 40;
  const int filled = static_cast<int>(fraction * width);
  const std::string bar =
      std::string(static_cast<std::size_t>(filled), '#') + std::string(static_cast<std::size_t>(width - filled), '.');
  std::fprintf(stderr, "\r%s [%s] %3d %% %-24s", what_.c_str(), bar.c_str(), static_cast<int>(fraction * 100),
               note.c_str());
  std::fflush(stderr);
  open_ = true;
}

void Progress::done() {
  if (open_) std::fprintf(stderr, "\n");
  open_ = false;
}

}  // namespace downrange::app
