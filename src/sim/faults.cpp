#include "sim/faults.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <downrange/stage/catalogue.hpp>
#include <downrange/stage/source_table.hpp>
#include <map>
#include <numbers>

#include "sim/random_stream.hpp"

namespace downrange::sim {
namespace {

[[noreturn]] void fail(const FaultCatalogue& catalogue, int line, const std::string& what) {
  throw ScenarioError(catalogue.file.string() + ":" + std::to_string(line) + ": " + what);
}

/// The N of "target:N", counted from 1; nothing for another word.
std::optional<std::size_t> number_behind(std::string_view word, std::string_view kind) {
  if (!word.starts_with(kind)) return std::nullopt;
  const std::string_view digits = word.substr(kind.size());
  std::size_t n = 0;
  const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), n);
  if (error != std::errc() || end != digits.data() + digits.size() || n == 0) return std::nullopt;
  return n;
}

std::string_view word_of(SourceKind kind) {
  switch (kind) {
    case SourceKind::Radar:
      return "radar:";
    case SourceKind::AngleSensor:
      return "tracker:";
    case SourceKind::Telemetry:
      return "station:";
  }
  return {};
}

/// Which sources of `kind` the word means; nothing: it is no pattern.
std::optional<std::vector<Name>> meant_by_pattern(std::string_view word, const SourceTable& sources) {
  const auto names_where = [&](auto&& wanted) {
    std::vector<Name> names;
    for (const Source& source : sources)
      if (wanted(source.kind)) names.push_back(source.name);
    return names;
  };
  if (word == "all") return names_where([](SourceKind) { return true; });
  if (word == "gps") return names_where([](SourceKind kind) { return kind == SourceKind::Telemetry; });
  if (word == "radars") return names_where([](SourceKind kind) { return kind == SourceKind::Radar; });
  if (word == "trackers") return names_where([](SourceKind kind) { return kind == SourceKind::AngleSensor; });
  const std::string_view before_number = word.substr(0, word.find(':') + 1);
  const auto n = number_behind(word, before_number);
  const auto first = std::ranges::find_if(sources, [&](const Source& s) { return word_of(s.kind) == before_number; });
  if (!n || first == sources.end()) return std::nullopt;
  const std::vector<Name> names = names_where([kind = first->kind](SourceKind k) { return k == kind; });
  if (*n > names.size()) return std::vector<Name>{};
  return std::vector<Name>{names[*n - 1]};
}

/// A message in an action's hands.
struct Moment {
  double since_begin_s = 0;    ///< of the action
  const Site* site = nullptr;  ///< of the radar or tracker
};

/// The place moved by `offset` in the east-north-up axes there.
Position<Ecef> moved(const Position<Ecef>& p, const Eigen::Vector3d& offset_enu_m) {
  return p + enu_from_ecef_at(geodetic_from_ecef(p)).inverse() * Displacement<Enu>{offset_enu_m};
}

Polar moved(const Polar& plot, const Site& site, const Eigen::Vector3d& offset_enu_m) {
  return polar_from_enu(site.enu_of(moved(site.ecef_of(enu_from_polar(plot)), offset_enu_m)));
}

/// One action in the course of a flight. Each effect takes the kinds of message that it has an overload for; it says
/// whether the message is still sent, and counts what it touched.
class Player {
 public:
  Player(const FaultAction& action, const RangeConfig& range, const Injection& how, const std::string& stream,
         std::vector<Event>& added)
      : action_(action), range_(range), seed_(how.seed), stream_(stream), random_(how.seed, stream), added_(added) {}

  [[nodiscard]] std::size_t touched() const { return touched_; }

  template <class Message>
  bool play(Message& message, const Moment& moment) {
    return std::visit(
        [&](const auto& effect) {
          if constexpr (requires { this->apply(effect, message, moment); }) {
            ++touched_;
            return this->apply(effect, message, moment);
          } else {
            return true;
          }
        },
        action_.effect);
  }

  /// A fix that comes before the action begins: what a receiver knows when it freezes.
  void before(const GpsFix& fix) {
    GpsFix& newest = newest_.try_emplace(fix.receiver, fix).first->second;
    if (fix.epoch > newest.epoch) newest = fix;
  }

 private:
  template <class Message>
  bool apply(const Silence&, Message&, const Moment&) {
    return false;
  }

  bool apply(const Displace& d, RadarTspi& plot, const Moment& moment) {
    const Polar before = plot.measured;
    plot.measured = moved(before, *moment.site, d.offset_enu_m + moment.since_begin_s * d.drift_enu_m_s);
    if (plot.range_rate_valid) {
      const Displacement<Enu> line{enu_from_polar(plot.measured).m};
      plot.range_rate_m_s += line.m.normalized().dot(d.drift_enu_m_s);
    }
    return true;
  }
  bool apply(const Displace& d, GpsFix& fix, const Moment& moment) {
    const Rotation<Ecef, Enu> R_ecef_enu = enu_from_ecef_at(geodetic_from_ecef(fix.position)).inverse();
    fix.position = moved(fix.position, d.offset_enu_m + moment.since_begin_s * d.drift_enu_m_s);
    if (d.velocity_too) fix.velocity.m_s += (R_ecef_enu * Velocity<Enu>{d.drift_enu_m_s}).m_s;
    return true;
  }

  bool apply(const Distort& d, RadarTspi& plot, const Moment&) {
    Polar& q = plot.measured;
    q.range_m = d.factor.range_m * q.range_m + d.offset.range_m;
    if (d.range_fold_m > 0) q.range_m = std::fmod(q.range_m, d.range_fold_m);
    q.azimuth_rad = wrap_two_pi(d.factor.azimuth_rad * q.azimuth_rad + d.offset.azimuth_rad);
    q.elevation_rad = d.factor.elevation_rad * q.elevation_rad + d.offset.elevation_rad;
    return true;
  }
  bool apply(const Distort& d, AngleTspi& angles, const Moment&) {
    angles.azimuth_rad = wrap_two_pi(d.factor.azimuth_rad * angles.azimuth_rad + d.offset.azimuth_rad);
    angles.elevation_rad = d.factor.elevation_rad * angles.elevation_rad + d.offset.elevation_rad;
    return true;
  }

  template <class Message>
  bool apply(const Clock& clock, Message& message, const Moment& moment) {
    message.epoch = message.epoch + seconds(clock.offset_s + clock.drift * moment.since_begin_s);
    return true;
  }

  bool apply(const Freeze& freeze, GpsFix& fix, const Moment&) {
    const GpsFix& frozen = newest_of(fix);
    fix.position = frozen.position;
    if (!freeze.velocity_lives) fix.velocity = frozen.velocity;
    // Every station relays the same fix: its noise is drawn from its epoch.
    if (freeze.noise_m > 0) {
      RandomStream noise(seed_, stream_ + std::to_string(fix.epoch.ns));
      for (int axis = 0; axis < 3; ++axis) fix.position.m[axis] += freeze.noise_m * noise.normal();
    }
    return true;
  }
  bool apply(const DeadReckon&, GpsFix& fix, const Moment&) {
    const GpsFix& start = newest_of(fix);
    fix.position = {start.position.m + (fix.epoch - start.epoch).seconds() * start.velocity.m_s};
    fix.velocity = start.velocity;
    return true;
  }
  bool apply(const VelocityFactor& velocity, GpsFix& fix, const Moment&) {
    fix.velocity.m_s *= velocity.factor;
    return true;
  }
  bool apply(const StateSigma& sigma, GpsFix& fix, const Moment&) {
    fix.sigma_horizontal_m = fix.sigma_vertical_m = sigma.position_m;
    fix.sigma_velocity_m_s = sigma.velocity_m_s;
    return true;
  }
  bool apply(const SecondReceiver& second, GpsFix& fix, const Moment&) {
    GpsFix copy = fix;
    copy.receiver = second.receiver;
    copy.position = moved(fix.position, second.offset_enu_m);
    added_.emplace_back(copy);
    return true;
  }

  bool apply(const Bursts& bursts, RadarTspi& plot, const Moment& moment) {
    const double in_period_s = std::fmod(moment.since_begin_s, bursts.every_s);
    const bool hit = random_.uniform() < bursts.probability && in_period_s < bursts.lasts_s;
    const auto size = [this](double most) {
      const double magnitude = most * random_.uniform(0.5, 1.5);
      return random_.uniform() < 0.5 ? -magnitude : magnitude;
    };
    const Polar error{size(bursts.range_m), size(bursts.angle_rad), size(bursts.angle_rad)};
    if (!hit) return true;
    plot.measured.range_m += error.range_m;
    plot.measured.azimuth_rad = wrap_two_pi(plot.measured.azimuth_rad + error.azimuth_rad);
    plot.measured.elevation_rad += error.elevation_rad;
    return true;
  }
  bool apply(const Multipath& path, RadarTspi& plot, const Moment&) {
    double& elevation = plot.measured.elevation_rad;
    if (elevation < path.below_rad)
      elevation += path.amplitude_rad * std::sin(2 * std::numbers::pi * elevation / path.period_rad);
    return true;
  }
  bool apply(const Pieces& pieces, RadarTspi& plot, const Moment& moment) {
    // Which piece a radar is on changes at random; where a piece goes does not depend on who sees it.
    const auto turn = static_cast<long>(moment.since_begin_s / pieces.dwell_s);
    RandomStream choice(seed_, stream_ + std::string(plot.sensor.view()) + std::to_string(turn));
    const auto piece = static_cast<int>(choice.uniform() * pieces.count);
    RandomStream direction(seed_, stream_ + "piece" + std::to_string(piece));
    Eigen::Vector3d away;
    for (double& axis : away) axis = direction.normal();
    plot.measured = moved(plot.measured, *moment.site, moment.since_begin_s * pieces.speed_m_s * away.normalized());
    return true;
  }

  bool apply(const SecondTarget& second, RadarTspi& plot, const Moment& moment) {
    RadarTspi copy = plot;
    copy.target = target_meant(second.target);
    copy.measured = moved(plot.measured, *moment.site, moment.since_begin_s * second.drift_enu_m_s);
    added_.emplace_back(copy);
    return true;
  }
  template <class Message>
  bool apply(const SwapTargets& swap, Message& message, const Moment&) {
    const Name a = target_meant(swap.target);
    const Name b = target_meant(swap.with);
    if (message.target == a)
      message.target = b;
    else if (message.target == b)
      message.target = a;
    return true;
  }

 public:
  /// Empty where the range has no such target.
  [[nodiscard]] Name target_meant(const std::string& word) const {
    const auto n = number_behind(word, "target:");
    if (n) return *n <= range_.targets.size() ? range_.targets[*n - 1].id : Name();
    const auto found = std::ranges::find(range_.targets, std::string_view(word),
                                         [](const TargetConfig& target) { return target.id.view(); });
    return found == range_.targets.end() ? Name() : found->id;
  }

 private:
  const GpsFix& newest_of(const GpsFix& fix) { return newest_.try_emplace(fix.receiver, fix).first->second; }

  const FaultAction& action_;
  const RangeConfig& range_;
  std::uint64_t seed_;
  std::string stream_;
  RandomStream random_;
  std::vector<Event>& added_;
  std::map<Name, GpsFix> newest_;  // by receiver
  std::size_t touched_ = 0;
};

void require_targets(const FaultCatalogue& catalogue, const FaultAction& action, const Player& player) {
  const auto require = [&](const std::string& word) {
    if (player.target_meant(word).empty()) fail(catalogue, action.line, "\"" + word + "\" is no target of this range");
  };
  if (const auto* second = std::get_if<SecondTarget>(&action.effect)) require(second->target);
  if (const auto* swap = std::get_if<SwapTargets>(&action.effect)) {
    require(swap->target);
    require(swap->with);
  }
}

/// Plots of `from` say `to`; where mutual, those of `to` say `from`.
std::size_t swap_sensors(const std::vector<Name>& from, const std::vector<Name>& to, bool mutual, RadarTspi& plot) {
  if (from.empty() || to.empty()) return 0;
  if (plot.sensor == from.front()) {
    plot.sensor = to.front();
  } else if (mutual && plot.sensor == to.front()) {
    plot.sensor = from.front();
  } else {
    return 0;
  }
  return 1;
}

/// The first plan is earlier; then a hold, and the plan that was kept. How many messages that touches.
std::size_t recycle(const Recycle& r, Time liftoff, std::vector<Event>& events, std::vector<Event>& added) {
  const auto is_plan = [](const Event& event) {
    const auto* mark = std::get_if<MissionEvent>(&event);
    return mark != nullptr && mark->kind == MissionEventKind::PlannedLiftoff;
  };
  const auto found = std::ranges::find_if(events, is_plan);
  if (found == events.end()) return 0;
  auto& plan = std::get<MissionEvent>(*found);
  const MissionEvent kept = plan;
  plan.epoch = plan.epoch - seconds(r.delay_s);
  const auto add = [&](MissionEventKind kind, const char* label, Time epoch, Time told) {
    MissionEvent mark = kept;
    mark.kind = kind;
    mark.label = label;
    mark.epoch = epoch;
    mark.received = std::max(told, kept.received);
    added.emplace_back(mark);
  };
  const Time hold = liftoff - seconds(r.delay_s + r.hold_before_s);
  const Time again = hold + seconds(r.hold_s);
  add(MissionEventKind::Hold, "hold", hold, hold);
  add(MissionEventKind::Recycle, "recycle", again, again);
  add(MissionEventKind::PlannedLiftoff, "planned lift-off", kept.epoch, again);
  return added.size() + 1;
}

/// The mission clock counts its messages as they are sent.
void renumber_mission(std::vector<Event>& events) {
  std::uint64_t sequence = 0;
  for (Event& event : events)
    if (auto* mark = std::get_if<MissionEvent>(&event)) mark->sequence = ++sequence;
}

}  // namespace

std::vector<Name> sources_meant(const std::vector<std::string>& words, const RangeConfig& range,
                                const std::string& where) {
  const SourceTable sources(range);
  std::vector<Name> names;
  for (const std::string& word : words) {
    if (const auto meant = meant_by_pattern(word, sources)) {
      names.insert(names.end(), meant->begin(), meant->end());
      continue;
    }
    const auto name = Name::parse(word);
    if (!name || sources.find(*name) == no_source)
      throw ScenarioError(std::string(where).append(": \"").append(word).append(
          "\" is no source of this range; allowed: its names, radar:N, tracker:N, station:N, radars, trackers, gps, "
          "all"));
    names.push_back(*name);
  }
  return names;
}

Injected inject(const FaultCatalogue& catalogue, const Fault& fault, const Injection& how, std::vector<Event> events) {
  const SourceTable table(how.range);
  Injected out;
  int number = 0;
  for (const FaultAction& action : fault.actions) {
    const std::string where = catalogue.file.string() + ":" + std::to_string(action.line);
    const std::vector<Name> names = sources_meant(action.sources, how.range, where);
    const double begin_s = how.begin_s + action.after_s;
    const std::optional<double> lasts_s = action.lasts_s ? action.lasts_s : fault.lasts_s;
    std::vector<Event> added;
    Player player(action, how.range, how, fault.name + "/" + std::to_string(++number), added);
    require_targets(catalogue, action, player);
    std::vector<Name> swapped_with;
    const auto* swap = std::get_if<SwapSensors>(&action.effect);
    if (swap != nullptr) swapped_with = sources_meant({swap->with}, how.range, where);
    const auto* countdown = std::get_if<Recycle>(&action.effect);
    if (countdown != nullptr) out.touched += recycle(*countdown, how.liftoff, events, added);

    const auto is_sent = [&](auto& message) {
      using Message = std::remove_cvref_t<decltype(message)>;
      constexpr bool measures =
          std::is_same_v<Message, RadarTspi> || std::is_same_v<Message, AngleTspi> || std::is_same_v<Message, GpsFix>;
      if constexpr (measures) {
        const double since_s = (message.epoch - how.liftoff).seconds() - begin_s;
        const Name name = MessageInfo<Message>::source(message);
        const bool is_over = lasts_s && since_s >= *lasts_s;
        if (is_over) return true;
        if constexpr (std::is_same_v<Message, RadarTspi>) {
          if (swap != nullptr && since_s >= 0) {
            out.touched += swap_sensors(names, swapped_with, swap->mutual, message);
            return true;
          }
        }
        if (std::ranges::find(names, name) == names.end()) return true;
        if (since_s < 0) {
          if constexpr (std::is_same_v<Message, GpsFix>) player.before(message);
          return true;
        }
        const SourceId id = table.find(name);
        return player.play(message, {.since_begin_s = since_s, .site = &table[id].site});
      } else {
        return true;
      }
    };
    std::vector<Event> sent;
    sent.reserve(events.size());
    for (Event& event : events)
      if (std::visit(is_sent, event)) sent.push_back(std::move(event));
    events = std::move(sent);
    out.touched += player.touched();
    if (!added.empty()) {
      events.insert(events.end(), added.begin(), added.end());
      std::ranges::stable_sort(events, {}, [](const Event& event) { return received_of(event); });
    }
    if (countdown != nullptr) renumber_mission(events);
  }
  out.events = std::move(events);
  return out;
}

}  // namespace downrange::sim
