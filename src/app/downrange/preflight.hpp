#pragma once
/// Go or no-go of everything that a flight needs, judged on the pad from what the range sends: live or out of an
/// archive.

#include <array>
#include <deque>
#include <downrange/stage/event.hpp>
#include <downrange/stage/range_config.hpp>
#include <downrange/stage/result.hpp>
#include <downrange/stage/source_table.hpp>
#include <limits>
#include <map>
#include <numbers>
#include <optional>
#include <string>
#include <vector>

#include "dds/service_status.hpp"
#include "stage/ingest.hpp"

namespace downrange::app {

/// What is still go.
struct PreflightLimits {
  Duration window = milliseconds(10'000);  ///< the last seconds before lift-off, or before the end, are judged
  double pad_sigmas = 4;                   ///< residual against the pad
  double pad_sigma_m = 3;       ///< how well it is known where on the pad the vehicle's antenna stands, per axis
  double latency_s = 1;         ///< mean
  double ahead_s = 0.02;        ///< received before it was true: the sender's clock is fast, or this one slow
  double rate_share = 0.5;      ///< of the nominal rate
  double rejected_share = 0.1;  ///< of what the instrument meant as a measurement
  double pointing_rad = 0.1 * std::numbers::pi / 180;  ///< of an antenna that follows our commands
  double clock_offset_s = 0.005;
};

/// One component of a sensor's residual against the pad.
struct PadComponent {
  std::string name;  ///< "range_m", "azimuth_rad", "elevation_rad"; "east_m", "north_m", "up_m"
  double mean = 0;
  double sigma = 0;  ///< what noise, bias priors and the place on the pad let expect of the mean
};

/// Of one subject: a source, an antenna, a clock.
struct PreflightLine {
  std::string name;
  std::vector<std::string> against;  ///< why it is no-go; empty: go
  std::vector<std::string> notes;    ///< what could not be judged
  [[nodiscard]] bool go() const { return against.empty(); }
};

struct SourcePreflight : PreflightLine {
  SourceKind kind = SourceKind::Radar;
  double rate_hz = 0;
  std::optional<double> nominal_hz;
  std::uint64_t messages = 0;
  std::array<std::uint64_t, reason_count> count{};  ///< by Reason
  double latency_mean_s = 0;                        ///< received - epoch; where messages > 0, the next two likewise
  double latency_min_s = 0;
  double latency_max_s = 0;
  std::optional<double> pad_sigmas;  ///< the worst component; none: not judged
  std::vector<PadComponent> pad;
};

struct AntennaPreflight : PreflightLine {
  std::uint64_t reports = 0;
  std::optional<AntennaMode> mode;       ///< of the newest report
  std::optional<double> pointing_rad;    ///< root mean square off our commands, on the sky; none: it follows none
  std::optional<double> command_loop_s;  ///< from the tick of a command to the report that follows it, mean
};

struct ClockPreflight : PreflightLine {
  dds::UtcState state;
};

struct PreflightReport {
  std::string range;
  bool heard = false;  ///< anything; else there is no window
  Time from;           ///< of the window judged
  Time to;
  std::optional<double> t_plus_s;  ///< at its end, where a lift-off is planned or known
  std::vector<SourcePreflight> sources;
  std::vector<AntennaPreflight> antennas;
  std::vector<ClockPreflight> clocks;

  [[nodiscard]] bool go() const;
};

[[nodiscard]] std::string format_text(const PreflightReport& report);
[[nodiscard]] std::string format_json(const PreflightReport& report);

class Preflight {
 public:
  Preflight(const RangeConfig& config, const PreflightLimits& limits);

  /// In order of `received`.
  void note(const Event& event);
  void note(const SlavingCommand& command);
  /// The newest of each machine counts.
  void note_clock(const std::string& whose, const dds::UtcState& state);

  [[nodiscard]] PreflightReport report() const;

 private:
  /// What came of one source within one second of `received`.
  struct Second {
    std::uint64_t messages = 0;
    std::array<std::uint64_t, reason_count> count{};
    double latency_sum_s = 0;
    double latency_min_s = std::numeric_limits<double>::infinity();
    double latency_max_s = -std::numeric_limits<double>::infinity();
    std::uint64_t on_pad = 0;  ///< measurements in the sums
    Vec<3> residual_sum = Vec<3>::Zero();
  };
  struct Antenna {
    std::deque<SlavingCommand> commands;  ///< the newest
    std::uint64_t reports = 0;
    std::optional<AntennaMode> mode;
    std::uint64_t compared = 0;
    double square_sum = 0;
    std::uint64_t looped = 0;
    double loop_sum_s = 0;
  };
  using Seconds = std::map<std::int64_t, Second>;

  void note_observation(const Observation& o);
  void note_report(const AntennaReport& report);
  /// Against the pad; none: this kind of verdict says nothing of the place.
  [[nodiscard]] std::optional<Vec<3>> pad_residual(SourceId source, const Observation& o) const;
  [[nodiscard]] Vec<3> pad_sigma(SourceId source, std::uint64_t samples) const;
  [[nodiscard]] SourcePreflight judge(SourceId source, std::int64_t from_s, std::int64_t to_s) const;
  void judge_pad(SourceId source, const Second& sum, SourcePreflight& line) const;
  [[nodiscard]] AntennaPreflight judge(const AntennaConfig& antenna) const;
  [[nodiscard]] ClockPreflight judge(const std::string& whose, const dds::UtcState& state) const;

  RangeConfig config_;
  PreflightLimits limits_;
  SourceTable sources_;
  std::vector<RadarModel> radars_;
  Ingest ingest_;
  std::vector<Seconds> seconds_;  ///< by SourceId
  std::map<Name, Antenna> antennas_;
  std::map<std::string, dds::UtcState> clocks_;
  std::optional<Time> first_;
  Time newest_;
};

}  // namespace downrange::app
