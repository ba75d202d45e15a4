#include <algorithm>
#include <array>
#include <functional>
#include <numbers>
#include <set>

#include "sim/faults.hpp"
#include "sim/toml_section.hpp"
#include "text/file.hpp"
#include "text/parse_toml.hpp"

namespace downrange::sim {
namespace {

constexpr double deg = std::numbers::pi / 180;
constexpr double day_s = 86'400;
constexpr Limits any{};
constexpr Limits from_zero{0};
constexpr Limits probability{0, 1};
constexpr Limits flight_time{-day_s, day_s};
constexpr Limits longer_than_zero{1e-3, day_s};
constexpr int most_radars = 64;

/// `change(window)` of every sensor: when it measures.
template <class Change>
void for_each_window(Scenario& scenario, const Change& change) {
  for_each_tracking_sensor(scenario, [&](RadarScenario& sensor) { change(sensor.track); });
  change(scenario.gps.active);
}

Eigen::Vector3d read_offset(TomlSection& toml) {
  return {toml.number("east_m", any, 0), toml.number("north_m", any, 0), toml.number("up_m", any, 0)};
}

Eigen::Vector3d read_drift(TomlSection& toml) {
  return {toml.number("drift_east_m_s", any, 0), toml.number("drift_north_m_s", any, 0),
          toml.number("drift_up_m_s", any, 0)};
}

FaultEffect read_displace(TomlSection& toml) {
  return Displace{read_offset(toml), read_drift(toml), toml.flag("velocity_too", false)};
}

FaultEffect read_distort(TomlSection& toml) {
  Distort d;
  d.factor = {toml.number("range_factor", any, 1), toml.number("azimuth_factor", any, 1),
              toml.number("elevation_factor", any, 1)};
  d.offset = {toml.number("range_offset_m", any, 0), toml.number("azimuth_offset_deg", any, 0) * deg,
              toml.number("elevation_offset_deg", any, 0) * deg};
  d.range_fold_m = toml.number("range_fold_m", from_zero, 0);
  return d;
}

FaultEffect read_clock(TomlSection& toml) {
  return Clock{toml.number("offset_s", {-day_s, day_s}, 0), toml.number("drift", {-0.1, 0.1}, 0)};
}

FaultEffect read_freeze(TomlSection& toml) {
  return Freeze{toml.flag("velocity_lives", false), toml.number("noise_m", from_zero, 0)};
}

FaultEffect read_second_receiver(TomlSection& toml) {
  const std::string name = toml.text("receiver");
  const auto receiver = Name::parse(name);
  if (!receiver) toml.fail("receiver", "must have " + std::to_string(Name::max_size) + " characters or fewer");
  return SecondReceiver{*receiver, read_offset(toml)};
}

FaultEffect read_bursts(TomlSection& toml) {
  Bursts b;
  b.every_s = toml.number("every_s", longer_than_zero, b.every_s);
  b.lasts_s = toml.number("burst_s", {1e-3, b.every_s}, std::min(b.lasts_s, b.every_s));
  b.probability = toml.number("probability", probability, b.probability);
  b.range_m = toml.number("range_m", from_zero, 0);
  b.angle_rad = toml.number("angle_deg", from_zero, 0) * deg;
  return b;
}

FaultEffect read_multipath(TomlSection& toml) {
  return Multipath{toml.number("amplitude_deg", {0, 90}) * deg, toml.number("period_deg", {1e-3, 90}) * deg,
                   toml.number("below_deg", {-90, 90}) * deg};
}

FaultEffect read_pieces(TomlSection& toml) {
  Pieces p;
  p.count = static_cast<int>(toml.number("pieces", {2, 1000}, p.count));
  p.speed_m_s = toml.number("speed_m_s", from_zero, p.speed_m_s);
  p.dwell_s = toml.number("dwell_s", longer_than_zero, p.dwell_s);
  return p;
}

FaultEffect read_recycle(TomlSection& toml) {
  Recycle r;
  r.delay_s = toml.number("delay_s", longer_than_zero, r.delay_s);
  r.hold_before_s = toml.number("hold_before_s", {0, day_s}, r.hold_before_s);
  r.hold_s = toml.number("hold_s", {0, day_s}, r.hold_s);
  return r;
}

struct Kind {
  std::string_view name;
  FaultEffect (*read)(TomlSection&);
};

constexpr std::array<Kind, 16> kinds{{
    {"silence", [](TomlSection&) -> FaultEffect { return Silence{}; }},
    {"displace", read_displace},
    {"distort", read_distort},
    {"clock", read_clock},
    {"freeze", read_freeze},
    {"dead_reckon", [](TomlSection&) -> FaultEffect { return DeadReckon{}; }},
    {"velocity_factor", [](TomlSection& t) -> FaultEffect { return VelocityFactor{t.number("factor", any)}; }},
    {"state_sigma",
     [](TomlSection& t) -> FaultEffect {
       return StateSigma{t.number("position_m", from_zero), t.number("velocity_m_s", from_zero, 0)};
     }},
    {"second_receiver", read_second_receiver},
    {"bursts", read_bursts},
    {"multipath", read_multipath},
    {"pieces", read_pieces},
    {"second_target",
     [](TomlSection& t) -> FaultEffect {
       return SecondTarget{t.text("target"), read_drift(t)};
     }},
    {"swap_targets",
     [](TomlSection& t) -> FaultEffect {
       return SwapTargets{t.text("target"), t.text("with")};
     }},
    {"swap_sensors",
     [](TomlSection& t) -> FaultEffect {
       return SwapSensors{t.text("with"), t.flag("mutual", false)};
     }},
    {"recycle", read_recycle},
}};

FaultAction read_action(TomlSection toml) {
  FaultAction action;
  action.line = toml.line();
  const std::string name = toml.text("kind");
  const auto kind = std::ranges::find(kinds, name, &Kind::name);
  if (kind == kinds.end()) {
    std::string allowed;
    for (const Kind& k : kinds) allowed += (allowed.empty() ? "" : ", ") + std::string(k.name);
    toml.fail("kind", "\"" + name + "\" is no fault; allowed: " + allowed);
  }
  action.sources = toml.texts("sources");
  const bool needs_sources = name != "recycle";
  if (action.sources.empty() == needs_sources)
    toml.fail("sources", needs_sources ? "must name a source" : "means nothing to a recycle");
  action.after_s = toml.number("after_s", {0, day_s}, 0);
  if (toml.optional("lasts_s")) action.lasts_s = toml.number("lasts_s", longer_than_zero);
  action.effect = kind->read(toml);
  toml.reject_unknown();
  return action;
}

score::FaultLimits read_limits(TomlSection& toml, std::optional<double> on_target_share) {
  score::FaultLimits limits;
  const auto number = [&toml](const char* key, std::optional<double>& out) {
    if (toml.optional(key)) out = toml.number(key, from_zero);
  };
  number("error_m", limits.error_m);
  number("recovery_s", limits.recovery_s);
  number("accusation_s", limits.accusation_s);
  limits.bound_share = toml.number("bound_share", probability, limits.bound_share);
  if (toml.optional("excursion_deg")) limits.excursion_rad = toml.number("excursion_deg", {0, 180}) * deg;
  limits.majority_lies = toml.flag("majority_lies", false);
  if (toml.optional("on_target_share")) {
    limits.on_target_share = toml.number("on_target_share", probability);
  } else if (!limits.majority_lies) {
    limits.on_target_share = on_target_share;
  }
  return limits;
}

/// What faults that say nothing else have.
struct Defaults {
  std::vector<double> begin_s{150};
  double lasts_s = 60;
  std::vector<double> radars{2};
  std::optional<double> on_target_share{};  ///< expected, but of a lying majority
};

Fault read_fault(TomlSection toml, const Defaults& defaults) {
  Fault fault;
  fault.line = toml.line();
  fault.name = toml.text("name");
  fault.what = toml.text("what");
  if (toml.optional("flight")) fault.flight = toml.text("flight");
  fault.begin_s = toml.numbers("begin_s", flight_time, defaults.begin_s);
  if (toml.flag("for_good", false)) {
    if (toml.optional("lasts_s")) toml.fail("lasts_s", "and for_good cannot both be");
  } else {
    fault.lasts_s = toml.number("lasts_s", longer_than_zero, defaults.lasts_s);
  }
  for (const double radars : toml.numbers("radars", {0, most_radars}, defaults.radars))
    fault.radars.push_back(static_cast<int>(radars));
  for (const TomlSection& action : toml.sections("do")) fault.actions.push_back(read_action(action));
  fault.liars = toml.texts("liars");
  fault.expected.on_target_share = defaults.on_target_share;
  if (toml.optional("expect")) {
    TomlSection expect = toml.section("expect");
    fault.expected = read_limits(expect, defaults.on_target_share);
    if (fault.expected.accusation_s && fault.liars.empty())
      expect.fail("accusation_s", "is of somebody who lies: name liars");
    expect.reject_unknown();
  }
  if (fault.actions.empty() && fault.flight.empty())
    toml.fail("do", "is missing: [[fault.do]], or a flight of its own");
  toml.reject_unknown();
  return fault;
}

Push read_push(TomlSection toml) {
  Push push;
  push.from_s = toml.number("from_s", flight_time);
  push.to_s = toml.number("to_s", flight_time);
  if (!(push.from_s < push.to_s)) toml.fail("to_s", "must be after from_s");
  push.forward_m_s2 = toml.number("forward_m_s2", {-1000, 1000}, 0);
  push.right_m_s2 = toml.number("right_m_s2", {-1000, 1000}, 0);
  push.up_m_s2 = toml.number("up_m_s2", {-1000, 1000}, 0);
  toml.reject_unknown();
  return push;
}

Hop read_hop(TomlSection toml) {
  Hop hop;
  hop.apogee_m = toml.number("apogee_m", {1, 1e6}, hop.apogee_m);
  hop.distance_m = toml.number("distance_m", {0, 1e5}, hop.distance_m);
  hop.up_s = toml.number("up_s", {1, 900}, hop.up_s);
  hop.down_s = toml.number("down_s", {1, 900}, hop.down_s);
  toml.reject_unknown();
  return hop;
}

FlightVariant read_flight(TomlSection toml) {
  FlightVariant flight;
  flight.name = toml.text("name");
  if (toml.optional("start_s")) flight.start_s = toml.number("start_s", {-day_s, 0});
  if (toml.optional("end_s")) flight.end_s = toml.number("end_s", {1, 900});
  if (toml.optional("cutoff_s")) flight.cutoff_s = toml.number("cutoff_s", {1, 900});
  flight.ballistic_kg_m2 = toml.number("ballistic_kg_m2", from_zero, 0);
  if (toml.optional("hop")) flight.hop = read_hop(toml.section("hop"));
  for (const TomlSection& push : toml.sections("push")) flight.pushes.push_back(read_push(push));
  for (TomlSection& track : toml.sections("track")) {
    flight.track_from_s.emplace_back(track.text("radar"), track.number("from_s", flight_time));
    track.reject_unknown();
  }
  toml.reject_unknown();
  return flight;
}

toml::table parse(const std::filesystem::path& file) {
  try {
    return text::parse_toml(text::read_file(file, text::max_toml_size));
  } catch (const text::FileError& error) {
    throw ScenarioError(file.string() + ": " + error.what());
  } catch (const text::TomlError& error) {
    throw ScenarioError(file.string() + ":" + std::to_string(error.line()) + ": " + error.what());
  }
}

}  // namespace

FaultCatalogue load_faults(const std::filesystem::path& file) {
  const toml::table table = parse(file);
  TomlSection root(table, file.string(), "");
  FaultCatalogue catalogue;
  catalogue.file = file;
  const auto path = [&](const char* key) -> std::filesystem::path {
    return root.optional(key) ? file.parent_path() / root.text(key) : std::filesystem::path();
  };
  catalogue.scenario = path("scenario");
  catalogue.range = path("range");
  Defaults defaults;
  defaults.begin_s = root.numbers("begin_s", flight_time, defaults.begin_s);
  defaults.lasts_s = root.number("lasts_s", longer_than_zero, defaults.lasts_s);
  defaults.radars = root.numbers("radars", {0, most_radars}, defaults.radars);
  if (root.optional("on_target_share")) defaults.on_target_share = root.number("on_target_share", probability);
  std::set<std::string> names;
  for (const TomlSection& toml : root.sections("flight")) {
    catalogue.flights.push_back(read_flight(toml));
    if (!names.insert("flight " + catalogue.flights.back().name).second) toml.fail("name", "is there twice");
  }
  for (const TomlSection& toml : root.sections("fault")) {
    catalogue.faults.push_back(read_fault(toml, defaults));
    const Fault& fault = catalogue.faults.back();
    if (!names.insert(fault.name).second) toml.fail("name", "\"" + fault.name + "\" is there twice");
    if (!fault.flight.empty() && !names.contains("flight " + fault.flight))
      toml.fail("flight", "\"" + fault.flight + "\" is no [[flight]] of this file");
  }
  if (catalogue.faults.empty()) root.fail("fault", "is missing: a [[fault]] for each");
  root.reject_unknown();
  return catalogue;
}

const Fault& FaultCatalogue::find(const std::string& name) const {
  std::string allowed;
  for (const Fault& fault : faults) {
    if (fault.name == name || (name.empty() && faults.size() == 1)) return fault;
    allowed += (allowed.empty() ? "" : ", ") + fault.name;
  }
  throw ScenarioError(file.string() + ": " +
                      (name.empty() ? "say which fault" : "\"" + name + "\" is none of its faults") + "; there are " +
                      allowed);
}

const FlightVariant* FaultCatalogue::flight_of(const Fault& fault) const {
  const auto found = std::ranges::find(flights, fault.flight, &FlightVariant::name);
  return found == flights.end() ? nullptr : &*found;
}

Scenario flown_as(Scenario scenario, const FlightVariant& variant, const RangeConfig& range) {
  if (variant.start_s) {
    // What was there from the start still is.
    const auto begin_earlier = [&](Window& window) {
      if (window.first == scenario.start_s) window.first = *variant.start_s;
    };
    for_each_window(scenario, begin_earlier);
    scenario.start_s = *variant.start_s;
  }
  if (variant.end_s) end_at(scenario, *variant.end_s);
  for (const auto& [word, from_s] : variant.track_from_s)
    for (const Name& name : sources_meant({word}, range, "flight " + variant.name)) {
      bool tracks = false;
      for_each_tracking_sensor(scenario, [&](RadarScenario& sensor) {
        if (sensor.id != name) return;
        sensor.track.first = from_s;
        tracks = true;
      });
      if (!tracks)
        throw ScenarioError("flight " + variant.name + ": \"" + word + "\" is no radar and no tracker of the scenario");
    }
  if (variant.cutoff_s) {
    std::erase_if(scenario.profile.burns, [&](const Burn& burn) { return burn.from_s >= *variant.cutoff_s; });
    for (Burn& burn : scenario.profile.burns) burn.to_s = std::min(burn.to_s, *variant.cutoff_s);
  }
  scenario.profile.pushes = variant.pushes;
  scenario.profile.ballistic_kg_m2 = variant.ballistic_kg_m2;
  scenario.profile.hop = variant.hop;
  return scenario;
}

void end_at(Scenario& scenario, double end_s) {
  const auto cut = [&](Window& window) {
    if (window.second == scenario.end_s || window.second > end_s) window.second = std::max(window.first, end_s);
  };
  for_each_window(scenario, cut);
  scenario.end_s = end_s;
}

}  // namespace downrange::sim
