#include <cmath>
#include <cstdio>
#include <ctime>
#include <nlohmann/json.hpp>
#include <numbers>
#include <text/printable.hpp>

#include "preflight.hpp"

namespace downrange::app {
namespace {

using nlohmann::ordered_json;

constexpr double deg = std::numbers::pi / 180;

template <class... Arguments>
std::string line(const char* format, Arguments... arguments) {
  char text[300];
  std::snprintf(text, sizeof text, format, arguments...);
  return text;
}

std::string utc(Time t) {
  const std::time_t whole = static_cast<std::time_t>(t.ns / 1'000'000'000);
  std::tm parts{};
  gmtime_r(&whole, &parts);
  char text[32];
  std::strftime(text, sizeof text, "%Y-%m-%dT%H:%M:%SZ", &parts);
  return text;
}

const char* word(const PreflightLine& subject) { return subject.go() ? "GO" : "NO-GO"; }

/// What is said against it and what was not judged, one under the other.
std::string remarks(const PreflightLine& subject) {
  std::string text;
  for (const std::string& against : subject.against) text += "        NO-GO: " + against + '\n';
  for (const std::string& note : subject.notes) text += "        " + note + '\n';
  return text;
}

/// Angles in degrees; "range +31.2 m (of 104.2)".
std::string component_text(const PadComponent& component) {
  const std::size_t end = component.name.rfind('_');
  const std::string what = component.name.substr(0, end);
  if (component.name.substr(end) == "_rad")
    return line("%s %+.3f deg (of %.3f)", what.c_str(), component.mean / deg, component.sigma / deg);
  return line("%s %+.1f m (of %.1f)", what.c_str(), component.mean, component.sigma);
}

std::string text_of(const SourcePreflight& source) {
  if (source.messages == 0) return line("%-6s %-18s\n", word(source), source.name.c_str()) + remarks(source);
  std::string text = line("%-6s %-18s %6.1f /s", word(source), source.name.c_str(), source.rate_hz);
  if (source.nominal_hz) text += line(" of %g", *source.nominal_hz);
  text += line("   latency %.3f s (%.3f to %.3f)   pad ", source.latency_mean_s, source.latency_min_s,
               source.latency_max_s);
  text += source.pad_sigmas ? line("%.1f sigma", *source.pad_sigmas) : std::string("-");
  std::string components;
  for (const PadComponent& component : source.pad)
    components += (components.empty() ? "" : ", ") + component_text(component);
  if (!components.empty()) text += ": " + components;
  return text + '\n' + remarks(source);
}

const char* name_of(AntennaMode mode) {
  static constexpr std::array<const char*, 4> names{"manual", "program", "slaved", "autotrack"};
  return names.at(static_cast<std::size_t>(mode));
}

std::string text_of(const AntennaPreflight& antenna) {
  std::string text = line("%-6s %-18s", word(antenna), antenna.name.c_str());
  if (antenna.mode) text += line(" %s", name_of(*antenna.mode));
  if (antenna.pointing_rad) text += line("   %.3f deg off its commands", *antenna.pointing_rad / deg);
  if (antenna.command_loop_s) text += line("   loop %.3f s", *antenna.command_loop_s);
  return text + '\n' + remarks(antenna);
}

std::string text_of(const ClockPreflight& clock) {
  std::string text = line("%-6s %-18s", word(clock), clock.name.c_str());
  if (clock.state.known)
    text += line(" %s   offset %+.6f s   error at most %.6f s", clock.state.synchronised ? "synchronised" : "FREE",
                 clock.state.offset_s, clock.state.error_s);
  return text + '\n' + remarks(clock);
}

ordered_json json_of(const PreflightLine& subject) {
  return {{"name", subject.name}, {"go", subject.go()}, {"against", subject.against}, {"notes", subject.notes}};
}

template <class Number>
ordered_json number(const std::optional<Number>& value) {
  return value ? ordered_json(*value) : ordered_json(nullptr);
}

ordered_json json_of(const SourcePreflight& source) {
  ordered_json json = json_of(static_cast<const PreflightLine&>(source));
  json["kind"] = to_string(source.kind);
  json["messages"] = source.messages;
  json["rate_hz"] = source.rate_hz;
  json["nominal_rate_hz"] = number(source.nominal_hz);
  ordered_json verdicts = ordered_json::object();
  for (std::size_t i = 0; i < reason_count; ++i)
    verdicts[std::string(to_string(static_cast<Reason>(i)))] = source.count[i];
  json["verdicts"] = verdicts;
  const bool heard = source.messages > 0;
  json["latency_mean_s"] = heard ? ordered_json(source.latency_mean_s) : ordered_json(nullptr);
  json["latency_min_s"] = heard ? ordered_json(source.latency_min_s) : ordered_json(nullptr);
  json["latency_max_s"] = heard ? ordered_json(source.latency_max_s) : ordered_json(nullptr);
  json["pad_sigmas"] = number(source.pad_sigmas);
  ordered_json pad = ordered_json::object();
  for (const PadComponent& component : source.pad)
    pad[component.name] = {{"mean", component.mean}, {"sigma", component.sigma}};
  json["pad"] = pad;
  return json;
}

ordered_json json_of(const AntennaPreflight& antenna) {
  ordered_json json = json_of(static_cast<const PreflightLine&>(antenna));
  json["reports"] = antenna.reports;
  json["mode"] = antenna.mode ? ordered_json(name_of(*antenna.mode)) : ordered_json(nullptr);
  json["pointing_rad"] = number(antenna.pointing_rad);
  json["command_loop_s"] = number(antenna.command_loop_s);
  return json;
}

ordered_json json_of(const ClockPreflight& clock) {
  ordered_json json = json_of(static_cast<const PreflightLine&>(clock));
  json["known"] = clock.state.known;
  json["synchronised"] = clock.state.synchronised;
  json["offset_s"] = clock.state.offset_s;
  json["error_s"] = clock.state.error_s;
  return json;
}

template <class Lines>
ordered_json json_list(const Lines& lines) {
  ordered_json list = ordered_json::array();
  for (const auto& subject : lines) list.push_back(json_of(subject));
  return list;
}

}  // namespace

std::string format_text(const PreflightReport& report) {
  std::string text = "Preflight of range " + report.range + ", ";
  text += report.heard ? utc(report.from) + " to " + utc(report.to) : "where nothing was heard";
  if (report.t_plus_s) text += line(" (T%+.0f s)", *report.t_plus_s);
  text += "\n\nSources\n";
  for (const SourcePreflight& source : report.sources) text += text_of(source);
  text += "Antennas\n";
  for (const AntennaPreflight& antenna : report.antennas) text += text_of(antenna);
  text += "Clocks\n";
  for (const ClockPreflight& clock : report.clocks) text += text_of(clock);
  if (report.clocks.empty()) text += "        none was told of: not judged\n";
  return text::printable(text + "\nRange " + report.range + ": " + (report.go() ? "GO" : "NO-GO") + '\n', true,
                         100'000);
}

std::string format_json(const PreflightReport& report) {
  const ordered_json json = {{"range", report.range},
                             {"go", report.go()},
                             {"from_ns", report.from.ns},
                             {"to_ns", report.to.ns},
                             {"t_plus_s", number(report.t_plus_s)},
                             {"sources", json_list(report.sources)},
                             {"antennas", json_list(report.antennas)},
                             {"clocks", json_list(report.clocks)}};
  return json.dump(2, ' ', false, nlohmann::json::error_handler_t::replace);
}

}  // namespace downrange::app
