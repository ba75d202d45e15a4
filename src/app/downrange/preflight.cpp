#include "preflight.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <downrange/est/model/plot_model.hpp>
#include <downrange/stage/catalogue.hpp>

#include "stage/methods.hpp"

namespace downrange::app {
namespace {

constexpr std::int64_t second_ns = 1'000'000'000;
/// An antenna's report follows one of these: some seconds of them.
constexpr std::size_t commands_kept = 256;
/// A command is good for a report this far from the instant it is for.
constexpr Duration command_reach = milliseconds(500);

std::int64_t second_of(Time t) { return t.ns >= 0 ? t.ns / second_ns : (t.ns - second_ns + 1) / second_ns; }

template <class... Arguments>
std::string text(const char* format, Arguments... arguments) {
  char line[160];
  std::snprintf(line, sizeof line, format, arguments...);
  return line;
}

/// What an instrument that works sends on purpose is no rejection: not in track, or slaved; a copy of another
/// station's.
bool counts_as_rejected(Reason reason, SourceKind kind) {
  switch (reason) {
    case Reason::Accepted:
    case Reason::NotTracking:
    case Reason::Slaved:
    case Reason::Inhibited:
      return false;
    case Reason::Duplicate:
      return kind != SourceKind::Telemetry;
    default:
      return true;
  }
}

std::uint64_t counted(const std::array<std::uint64_t, reason_count>& count, Reason reason) {
  return count[static_cast<std::size_t>(reason)];
}

}  // namespace

bool PreflightReport::go() const {
  const auto all_go = [](const auto& lines) {
    return std::ranges::all_of(lines, [](const auto& l) { return l.go(); });
  };
  return all_go(sources) && all_go(antennas) && all_go(clocks);
}

Preflight::Preflight(const RangeConfig& config, const PreflightLimits& limits)
    : config_(config),
      limits_(limits),
      sources_(config),
      radars_(radar_models(config)),
      ingest_(config),
      seconds_(sources_.size()) {}

void Preflight::note(const Event& event) {
  const Time received = received_of(event);
  if (!plausible(received)) return;
  if (!first_) first_ = received;
  newest_ = std::max(newest_, received);
  std::visit(
      [this]<class Record>(const Record& record) {
        if constexpr (std::is_same_v<Record, AntennaReport>) {
          note_report(record);
        } else if constexpr (std::is_same_v<Record, MissionEvent> || std::is_same_v<Record, OperatorCommand>) {
          ingest_.note(record);
        } else if constexpr (Measurements::contains<Record> || std::is_same_v<Record, Observation>) {
          note_observation(ingest_.judge(record));
        }  // else it says nothing of a source
      },
      event);
}

void Preflight::note_observation(const Observation& o) {
  const SourceId source = sources_.find(kind_of(o.measured), o.sensor);
  if (source == no_source) return;
  Second& second = seconds_[static_cast<std::size_t>(source)][second_of(o.received)];
  ++second.messages;
  ++second.count[static_cast<std::size_t>(o.verdict)];
  const double latency_s = (o.received - o.epoch).seconds();
  second.latency_sum_s += latency_s;
  second.latency_min_s = std::min(second.latency_min_s, latency_s);
  second.latency_max_s = std::max(second.latency_max_s, latency_s);
  if (const auto residual = pad_residual(source, o)) {
    ++second.on_pad;
    second.residual_sum += *residual;
  }
}

std::optional<Vec<3>> Preflight::pad_residual(SourceId source, const Observation& o) const {
  if (!config_.pad) return std::nullopt;
  const bool of_station = sources_[source].kind == SourceKind::Telemetry;
  const bool tells = o.verdict == Reason::Accepted ||
                     (of_station && (o.verdict == Reason::Duplicate || o.verdict == Reason::AwayFromPad));
  if (!tells) return std::nullopt;
  if (const auto* fix = std::get_if<Fix>(&o.measured)) return config_.pad->site.enu_of(fix->position).m;
  Vec<9> motion = Vec<9>::Zero();
  motion.head<3>() = config_.pad->site.ecef().m;
  const RadarModel& radar = radars_[static_cast<std::size_t>(source)];
  const PredictedPlot predicted = predict_plot(radar, motion, radar.bias.prior_mean);
  const auto* plot = std::get_if<Plot>(&o.measured);
  const auto* angles = std::get_if<Angles>(&o.measured);
  const Polar measured =
      plot != nullptr ? plot->measured : Polar{predicted.q[0], angles->azimuth_rad, angles->elevation_rad};
  return plot_residual(measured, predicted.q);
}

Vec<3> Preflight::pad_sigma(SourceId source, std::uint64_t samples) const {
  const double place = limits_.pad_sigma_m * limits_.pad_sigma_m;
  if (sources_[source].kind == SourceKind::Telemetry) {
    // A receiver's errors stay alike for longer than the window: no mean makes them smaller.
    const GpsConfig& gps = config_.gps;
    const double slow = config_.align.gps.error.sigma_m;
    const double horizontal = std::hypot(gps.sigma_horizontal_m, slow);
    const double vertical = std::hypot(gps.sigma_vertical_m, slow);
    return (Vec<3>(horizontal * horizontal, horizontal * horizontal, vertical * vertical).array() + place).sqrt();
  }
  const RadarModel& radar = radars_[static_cast<std::size_t>(source)];
  Vec<9> motion = Vec<9>::Zero();
  motion.head<3>() = config_.pad->site.ecef().m;
  const PredictedPlot predicted = predict_plot(radar, motion, radar.bias.prior_mean);
  const Plot plot{.measured = {predicted.q[0], predicted.q[1], predicted.q[2]}};
  Vec<3> variance = plot_variance(radar, plot) / static_cast<double>(samples);
  const double wander = radar.wander.sigma_rad * radar.wander.sigma_rad;
  variance += Vec<3>(0, wander, wander);
  variance += place * predicted.d_motion.leftCols<3>().rowwise().squaredNorm();
  for (const BiasTerm a : radar.bias.terms) {
    for (const BiasTerm b : radar.bias.terms) {
      const auto i = static_cast<int>(a);
      const auto k = static_cast<int>(b);
      variance += radar.bias.prior_cov(i, k) * predicted.d_bias.col(i).cwiseProduct(predicted.d_bias.col(k));
    }
  }
  return variance.cwiseSqrt();
}

void Preflight::note(const SlavingCommand& command) {
  std::deque<SlavingCommand>& commands = antennas_[command.antenna].commands;
  commands.push_back(command);
  if (commands.size() > commands_kept) commands.pop_front();
}

void Preflight::note_report(const AntennaReport& report) {
  if (report.simulated != config_.ingest.expect_simulated) return;
  Antenna& antenna = antennas_[report.antenna];
  ++antenna.reports;
  antenna.mode = report.mode;
  const bool measured = report.azimuth_valid && report.elevation_valid && std::isfinite(report.azimuth_rad) &&
                        std::isfinite(report.elevation_rad);
  if (report.mode != AntennaMode::Slaved || !measured) return;
  const auto followed = std::ranges::find(antenna.commands, report.command_tick, &SlavingCommand::tick);
  if (followed != antenna.commands.end()) {
    ++antenna.looped;
    antenna.loop_sum_s += (report.received - followed->tick).seconds();
  }
  // Where it should point at the report's epoch: by the command for the instant nearest to it.
  const SlavingCommand* nearest = nullptr;
  Duration least = command_reach;
  for (const SlavingCommand& command : antenna.commands) {
    const Duration apart = std::max(report.epoch - command.apply_at, command.apply_at - report.epoch);
    if (apart > least) continue;
    least = apart;
    nearest = &command;
  }
  if (nearest == nullptr) return;
  const double dt = (report.epoch - nearest->apply_at).seconds();
  const double azimuth = nearest->azimuth_rad + dt * nearest->azimuth_rate_rad_s;
  const double elevation = nearest->elevation_rad + dt * nearest->elevation_rate_rad_s;
  const double off_azimuth = std::remainder(report.azimuth_rad - azimuth, 2 * std::numbers::pi) * std::cos(elevation);
  const double off_elevation = report.elevation_rad - elevation;
  ++antenna.compared;
  antenna.square_sum += off_azimuth * off_azimuth + off_elevation * off_elevation;
}

void Preflight::note_clock(const std::string& whose, const dds::UtcState& state) { clocks_[whose] = state; }

PreflightReport Preflight::report() const {
  PreflightReport report;
  report.range = config_.name.view();
  // Whole seconds, none of them after lift-off.
  std::int64_t to_s = first_ ? second_of(newest_) + 1 : 0;
  const std::optional<Time>& liftoff = ingest_.mission().liftoff();
  if (liftoff) to_s = std::min(to_s, second_of(*liftoff));
  const std::int64_t window_s = std::max<std::int64_t>(limits_.window.ns / second_ns, 1);
  const std::int64_t from_s = std::max(to_s - window_s, first_ ? second_of(*first_) : 0);
  report.heard = first_.has_value();
  report.from = {from_s * second_ns};
  report.to = {to_s * second_ns};
  if (const auto t_plus = ingest_.mission().t_plus(report.to)) report.t_plus_s = t_plus->seconds();
  for (SourceId id = 0; id < static_cast<SourceId>(sources_.size()); ++id)
    report.sources.push_back(judge(id, from_s, to_s));
  for (const AntennaConfig& antenna : config_.antennas) report.antennas.push_back(judge(antenna));
  for (const auto& [whose, state] : clocks_) report.clocks.push_back(judge(whose, state));
  return report;
}

SourcePreflight Preflight::judge(SourceId id, std::int64_t from_s, std::int64_t to_s) const {
  const Source& source = sources_[id];
  SourcePreflight line;
  line.name = source.name.view();
  line.kind = source.kind;
  Second sum;
  const Seconds& seconds = seconds_[static_cast<std::size_t>(id)];
  for (auto second = seconds.lower_bound(from_s); second != seconds.end() && second->first < to_s; ++second) {
    const Second& s = second->second;
    sum.messages += s.messages;
    for (std::size_t i = 0; i < reason_count; ++i) sum.count[i] += s.count[i];
    sum.latency_sum_s += s.latency_sum_s;
    sum.latency_min_s = std::min(sum.latency_min_s, s.latency_min_s);
    sum.latency_max_s = std::max(sum.latency_max_s, s.latency_max_s);
    sum.on_pad += s.on_pad;
    sum.residual_sum += s.residual_sum;
  }
  line.messages = sum.messages;
  line.count = sum.count;
  if (source.rate_hz > 0) line.nominal_hz = source.rate_hz;
  if (const StandingOrder* order = ingest_.orders().of(id); order != nullptr) {
    const std::string who = std::string(order->by.view()) + ": " + std::string(order->reason.view());
    if (order->order == OperatorOrder::Inhibit)
      line.against.push_back("inhibited by " + who);
    else
      line.notes.push_back("forced by " + who);
  }
  if (sum.messages == 0) {
    line.against.emplace_back("nothing heard");
    return line;
  }
  line.rate_hz = static_cast<double>(sum.messages) / static_cast<double>(std::max<std::int64_t>(to_s - from_s, 1));
  line.latency_mean_s = sum.latency_sum_s / static_cast<double>(sum.messages);
  line.latency_min_s = sum.latency_min_s;
  line.latency_max_s = sum.latency_max_s;
  if (line.nominal_hz && line.rate_hz < limits_.rate_share * *line.nominal_hz)
    line.against.push_back(text("%.1f messages a second of %.1f", line.rate_hz, *line.nominal_hz));
  if (line.latency_mean_s > limits_.latency_s)
    line.against.push_back(text("late by %.2f s, or its clock is slow", line.latency_mean_s));
  if (line.latency_min_s < -limits_.ahead_s)
    line.against.push_back(
        text("stamps %.3f s ahead of reception: its clock is fast, or this one slow", -line.latency_min_s));
  std::uint64_t rejected = 0;
  std::string reasons;
  for (std::size_t i = 0; i < reason_count; ++i) {
    if (sum.count[i] == 0 || !counts_as_rejected(static_cast<Reason>(i), source.kind)) continue;
    rejected += sum.count[i];
    reasons += (reasons.empty() ? "" : ", ") + std::to_string(sum.count[i]) + " " +
               std::string(to_string(static_cast<Reason>(i)));
  }
  if (static_cast<double>(rejected) > limits_.rejected_share * static_cast<double>(sum.messages))
    line.against.push_back("rejected: " + reasons);
  judge_pad(id, sum, line);
  return line;
}

void Preflight::judge_pad(SourceId id, const Second& sum, SourcePreflight& line) const {
  if (!config_.pad) {
    line.notes.emplace_back("no [pad] in the configuration: residual not judged");
    return;
  }
  if (sum.on_pad == 0) {
    const std::uint64_t searching = counted(sum.count, Reason::NotTracking) + counted(sum.count, Reason::Slaved);
    line.notes.emplace_back(searching > 0 ? "does not track: residual not judged" : "residual not judged");
    return;
  }
  static constexpr std::array<const char*, 3> of_fix{"east_m", "north_m", "up_m"};
  static constexpr std::array<const char*, 3> of_plot{"range_m", "azimuth_rad", "elevation_rad"};
  const bool fix = line.kind == SourceKind::Telemetry;
  const Vec<3> mean = sum.residual_sum / static_cast<double>(sum.on_pad);
  const Vec<3> sigma = pad_sigma(id, sum.on_pad);
  double worst = 0;
  for (int i = line.kind == SourceKind::AngleSensor ? 1 : 0; i < 3; ++i) {
    line.pad.push_back({(fix ? of_fix : of_plot)[static_cast<std::size_t>(i)], mean[i], sigma[i]});
    worst = std::max(worst, std::abs(mean[i]) / sigma[i]);
  }
  line.pad_sigmas = worst;
  if (!(worst <= limits_.pad_sigmas)) line.against.push_back(text("%.1f sigma away from the pad", worst));
}

AntennaPreflight Preflight::judge(const AntennaConfig& config) const {
  AntennaPreflight line;
  line.name = config.id.view();
  const auto known = antennas_.find(config.id);
  if (known == antennas_.end() || known->second.reports == 0) {
    line.notes.emplace_back("does not report: loop not judged");
    return line;
  }
  const Antenna& antenna = known->second;
  line.reports = antenna.reports;
  line.mode = antenna.mode;
  if (antenna.looped > 0) line.command_loop_s = antenna.loop_sum_s / static_cast<double>(antenna.looped);
  if (antenna.compared == 0) {
    line.notes.emplace_back("follows no command: loop not judged");
    return line;
  }
  line.pointing_rad = std::sqrt(antenna.square_sum / static_cast<double>(antenna.compared));
  if (!(*line.pointing_rad <= limits_.pointing_rad))
    line.against.push_back(text("points %.3f deg away from its commands", *line.pointing_rad * 180 / std::numbers::pi));
  return line;
}

ClockPreflight Preflight::judge(const std::string& whose, const dds::UtcState& state) const {
  ClockPreflight line;
  line.name = whose;
  line.state = state;
  if (!state.known) {
    line.notes.emplace_back("the kernel does not tell");
  } else if (!state.synchronised) {
    line.against.emplace_back("not synchronised: no NTP or PTP disciplines it");
  } else if (!(std::abs(state.offset_s) <= limits_.clock_offset_s)) {
    line.against.push_back(text("off by %.4f s", state.offset_s));
  }
  return line;
}

}  // namespace downrange::app
