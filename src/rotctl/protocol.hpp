#pragma once
/// The protocol of Hamlib's rotctld, as text: lines of ASCII over TCP, angles in degrees. No sockets here.
///
/// A client asks with one line, the daemon answers in order: `P az el` and `S` with `RPRT 0`, or `RPRT -n` where it
/// refuses; `p` with azimuth and elevation, a line each; `\dump_state` with what rotator it is and its travel.
/// (The manual page rotctld(1) of Hamlib 4.5, and what that daemon answered.)

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>

namespace downrange::rotctl {

/// Hamlib's errors that are said or understood here, as RPRT has them.
inline constexpr int rprt_ok = 0;
inline constexpr int rprt_invalid = -1;         ///< the line is no command, or its arguments are wrong
inline constexpr int rprt_not_available = -11;  ///< the rotator cannot do it

/// Longest line of either side that is read.
inline constexpr std::size_t max_line = 128;

/// Lines out of a stream of bytes that comes in any pieces.
class LineReader {
 public:
  void add(std::string_view bytes) { bytes_ += bytes; }
  /// The next whole line, without its end ("\n" or "\r\n"); nothing: it has not come yet.
  [[nodiscard]] std::optional<std::string> next();
  /// A line longer than `max_line`, whole or not: the peer speaks something else.
  [[nodiscard]] bool endless() const { return endless_; }
  /// The beginning of a line is waiting for the rest.
  [[nodiscard]] bool partial() const { return !bytes_.empty(); }

 private:
  std::string bytes_;
  bool endless_ = false;
};

/// One number and nothing else, finite, of at most 1080 either way: degrees.
[[nodiscard]] std::optional<double> parse_degrees(std::string_view line);
/// The code of "RPRT -11".
[[nodiscard]] std::optional<int> parse_report(std::string_view line);
/// What the code means, in words.
[[nodiscard]] std::string_view meaning_of(int code);

[[nodiscard]] std::string report_line(int code);
/// "P 123.4567 45.6789\n"
[[nodiscard]] std::string position_line(double azimuth_rad, double elevation_rad);
/// The answer to `p`.
[[nodiscard]] std::string pointing_lines(double azimuth_rad, double elevation_rad);

/// Ends of both axes.
struct Travel {
  double azimuth_min_rad;
  double azimuth_max_rad;
  double elevation_min_rad;
  double elevation_max_rad;

  bool operator==(const Travel&) const = default;
};

/// "azimuth -180 to 450, elevation 0 to 90 deg"
[[nodiscard]] std::string to_string(const Travel& travel);
/// The answer to `\dump_state`, in the form of Hamlib 4.
[[nodiscard]] std::string state_lines(const Travel& travel);

/// The answer to `\dump_state`, line by line. Protocol 1 (Hamlib 4) names the values and ends with "done"; protocol 0
/// (Hamlib 3, and many small daemons) has six to seven bare lines and no end, or "RPRT 0".
class StateReply {
 public:
  enum class Progress { More, Enough, Done, Wrong };

  /// Enough: what protocol 0 must have is there, another line or two may come.
  [[nodiscard]] Progress add(std::string_view line);
  /// Of Hamlib's list of rotators; 1 is its dummy, 2 another rotctld.
  [[nodiscard]] int model() const { return model_; }
  /// Nothing: it did not say, or what no rotator has.
  [[nodiscard]] std::optional<Travel> travel() const;

 private:
  Progress add_named(std::string_view line);
  Progress add_bare(std::string_view line);

  int lines_ = 0;
  int protocol_ = 0;
  int model_ = 0;
  std::optional<double> end_deg_[4];  ///< azimuth lower, upper, elevation lower, upper
};

}  // namespace downrange::rotctl
