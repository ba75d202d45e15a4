#pragma once
/// The conversation with a rotator daemon, as values: what came and what time it is go in, bytes to send, measured
/// pointing and messages come out. No sockets, no clocks: client.hpp has them.
///
/// One question at a time, so that a slow rotator is sent fewer positions and never old ones. A stop waits for no
/// answer.

#include <cstdint>
#include <deque>
#include <downrange/stage/event.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "rotctl/protocol.hpp"
#include "rotctl/turns.hpp"
#include "stage/slave/command_book.hpp"

namespace downrange::rotctl {

/// UTC, by which commands go, and a clock that never steps, by which answers are waited for.
struct Instant {
  Time utc;
  Duration up;
};

struct LinkSettings {
  Name antenna;
  Travel travel;  ///< of the configuration: what commands keep to, and the rotator where it does not tell its own
  Duration link_delay{};  ///< from here to the rotator: a stop leaves so long before the commands end
  Duration lead{};        ///< lag of the servo: a position is that for link_delay and lead after it is sent
  double rate_hz = 5;     ///< positions a second, as many as the rotator takes
  Duration timeout = milliseconds(2000);  ///< an answer later than this: the connection is given up
  bool simulated = false;                 ///< the flag of its reports
};

/// Totals of the process, for people.
struct LinkCounts {
  std::uint64_t positions = 0;  ///< sent
  std::uint64_t refused = 0;    ///< answered by an error
  std::uint64_t stops = 0;
  std::uint64_t reports = 0;
};

class Link {
 public:
  explicit Link(const LinkSettings& settings);

  /// A connection is there: asks for the rotator's travel. What an earlier connection left moving is stopped first,
  /// unless a command is there to follow.
  void connected(const CommandBook& book, Instant now);
  /// It is gone. What was asked is not answered any more.
  void disconnected();

  void receive(std::string_view bytes, Instant now);
  /// Asks what is due: a stop, a position, where it points.
  void step(const CommandBook& book, Instant now);
  /// When step has something to do, at the latest; until then only answers matter.
  [[nodiscard]] Duration due(const CommandBook& book, Instant now) const;
  /// The process ends: stops what it moves.
  void stop(Instant now);
  /// Nothing is waited for.
  [[nodiscard]] bool quiet() const { return asked_.empty(); }
  /// The rotator may be on its way to a position of ours.
  [[nodiscard]] bool moving() const { return moving_; }
  /// The rotator has told its travel: the daemon is one.
  [[nodiscard]] bool established() const { return established_; }

  /// Why the connection is of no use any more; empty: it is.
  [[nodiscard]] const std::string& fault() const { return fault_; }
  [[nodiscard]] const LinkCounts& counts() const { return counts_; }

  // Each gives what has gathered, once.
  [[nodiscard]] std::string take_output();
  [[nodiscard]] std::vector<AntennaReport> take_reports();
  [[nodiscard]] std::vector<std::string> take_notes();

 private:
  enum class Question { State, Position, Pointing, Stop };
  struct Asked {
    Question question;
    Instant at;
    Time tick;            ///< of a position's command
    double turn_rad = 0;  ///< what was added to its azimuth
  };
  /// A message is said when it changes, not each time.
  enum Topic { StateTopic, MotionTopic, PointingTopic, HeldTopic, LateTopic, FutureTopic, topics };

  void ask(const Asked& what, const std::string& line);
  void ask_stop(Instant now);
  void ask_position(const CommandedPointing& aim, Instant now);
  void ask_pointing(Instant now);
  [[nodiscard]] bool stopping() const;
  [[nodiscard]] bool stop_due(const CommandBook& book, Instant now) const;
  void answer(const std::string& line, Instant now);
  void answer_state(const std::string& line, Instant now);
  void establish(Instant now);
  void answer_position(int code);
  void answer_stop(int code);
  void answer_pointing(const std::string& line, Instant now);
  void report(double azimuth_rad, double elevation_rad, Time epoch);
  void answered(Instant now);
  void fail(const std::string& why, std::string_view line = {});
  void fail_late();
  void note(Topic topic, const std::string& text);

  const LinkSettings settings_;
  const Duration period_;
  LineReader lines_;
  std::deque<Asked> asked_;
  Duration waiting_since_{};
  StateReply state_;
  bool state_enough_ = false;  ///< its end is that nothing more comes
  bool established_ = false;
  std::optional<Turns> turns_;
  std::optional<double> first_line_;  ///< azimuth of an answer to `p`, its elevation is to come
  Duration next_cycle_{};
  Duration next_stop_{};       ///< one that is refused is not tried again sooner
  bool pointing_due_ = false;  ///< in this cycle

  bool moving_ = false;
  bool ending_ = false;   ///< the process is
  bool follows_ = false;  ///< the last position was accepted, and not stopped since
  Time followed_tick_;
  double followed_turn_rad_ = 0;
  std::optional<double> measured_azimuth_rad_;
  std::uint64_t sequence_ = 0;

  std::string fault_;
  std::string output_;
  std::vector<AntennaReport> reports_;
  std::vector<std::string> notes_;
  std::string said_[topics];
  LinkCounts counts_;
};

}  // namespace downrange::rotctl
