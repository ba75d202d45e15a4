#pragma once
/// Progress of long work: a bar on a terminal, a line every tenth elsewhere.

#include <chrono>
#include <string>

namespace downrange::app {

class Progress {
 public:
  explicit Progress(std::string what);
  ~Progress();
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;

  /// `fraction` 0 to 1; `note` e.g. "T+123 s". Cheap to call often.
  void show(double fraction, const std::string& note = {});
  /// Ends the bar's line.
  void done();

 private:
  void draw(double fraction, const std::string& note);

  std::string what_;
  bool terminal_;
  bool open_ = false;
  int last_tenth_ = -1;
  std::chrono::steady_clock::time_point drawn_{};
};

}  // namespace downrange::app
