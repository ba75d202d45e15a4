#include <time.h>

#include <charconv>
#include <cmath>
#include <downrange/stage/catalogue.hpp>
#include <iostream>
#include <numbers>
#include <thread>

#include "app/machine_clock.hpp"
#include "command.hpp"
#include "dds/inputs.hpp"
#include "dds/outputs.hpp"
#include "node_answers.hpp"

namespace downrange::app {
namespace {

using std::chrono::milliseconds;

constexpr milliseconds discovery_time{5000};
/// After the first node was met: for the others.
constexpr milliseconds settling_time{700};
constexpr milliseconds answer_time{5000};
constexpr double deg = std::numbers::pi / 180;

struct Options {
  DdsOptions dds;
  std::string who;
  std::string reason;
  std::string subject;
  std::string argument;
  double azimuth_trim_deg = 0;
  double elevation_trim_deg = 0;
  std::string mission;
  std::string label;
  std::string at = "now";
};

template <class Text = Name>
Text text_of(const std::string& option, const std::string& value) {
  const auto parsed = Text::parse(value);
  if (!parsed || parsed->empty())
    throw CLI::ValidationError(option,
                               "'" + value + "': allowed are 1 to " + std::to_string(Text::max_size) + " characters");
  return *parsed;
}

/// "now", seconds from now as "+30" or "-2.5", or UTC as "2026-11-26T06:00:00Z", with a fraction or without.
Time parse_time(const std::string& text, Time now) {
  const CLI::ValidationError wrong(
      "--at", "'" + text + "': allowed are now, +SECONDS, -SECONDS and UTC as 2026-11-26T06:00:00.000Z");
  const auto number = [&](const char* from, const char* end) {
    double value = 0;
    const auto [rest, error] = std::from_chars(from, end, value);
    if (error != std::errc() || rest != end || !std::isfinite(value) || std::abs(value) > 1e6) throw wrong;
    return value;
  };
  const char* const end = text.data() + text.size();
  if (text == "now") return now;
  if (text.starts_with('+')) return now + seconds(number(text.data() + 1, end));
  if (text.starts_with('-')) return now + seconds(number(text.data(), end));
  std::tm parts{};
  const char* rest = strptime(text.c_str(), "%Y-%m-%dT%H:%M:%S", &parts);
  if (rest == nullptr || !text.ends_with('Z')) throw wrong;
  const double fraction = rest + 1 == end ? 0 : number(rest, end - 1);
  if (!(fraction >= 0 && fraction < 1)) throw wrong;
  return Time{static_cast<std::int64_t>(timegm(&parts)) * 1'000'000'000} + seconds(fraction);
}

config::ServiceConfig load_live(const Options& o) {
  config::ServiceConfig config = o.dds.load();
  if (config.clock.mode != config::ClockMode::Wall)
    throw std::runtime_error(
        "orders are given on the wall clock; on the range clock they come from the archive or the scenario that is "
        "flown");
  return config;
}

/// Writes it and waits for what every node makes of it.
template <class Message>
int send(const config::ServiceConfig& config, Message message, Time now, bool of_antenna = false) {
  message.sequence = static_cast<std::uint64_t>(now.ns);  // nobody gives two orders in a nanosecond
  message.simulated = config.range.ingest.expect_simulated;
  constexpr std::size_t topic = input_index<Message>;
  dds::Participant participant(participant_options(config, "downrange-operator"));
  NodeAnswers answers(topic, MessageInfo<Message>::source(message), message.sequence, of_antenna);
  dds::OutputSelection statuses;
  statuses.results = statuses.health = false;
  const dds::OutputReaders readers(
      participant, statuses, {.result = {}, .status = [&](const dds::ServiceStatus& status) { answers.add(status); }});
  dds::InputWriters writers(participant);
  if (!writers.wait_for_reader(topic, discovery_time) || !answers.wait_for_nodes(discovery_time)) {
    std::cerr << "downrange: no node answers in domain " << config.dds.domain << ": nothing was ordered\n";
    return exit_failed;
  }
  std::this_thread::sleep_for(settling_time);
  if (!writers.write(message)) {
    std::cerr << "downrange: DDS did not take it: " << writers.counts().last_failure << '\n';
    return exit_failed;
  }
  static_cast<void>(answers.wait_for_all(answer_time));
  std::cout << answers.text();
  return answers.all_in_force() ? exit_ok : exit_failed;
}

/// Release may be of a source, a target or an antenna.
bool is_of_antenna(OperatorOrder what) {
  return what == OperatorOrder::PinAntennaSource || what == OperatorOrder::PinAntennaTarget ||
         what == OperatorOrder::TrimAntenna || what == OperatorOrder::StopAntenna;
}

int order(const Options& o, OperatorOrder what) {
  OperatorCommand command;
  command.operator_id = text_of("--as", o.who);
  command.order = what;
  command.subject = text_of("SUBJECT", o.subject);
  if (!o.argument.empty()) command.argument = text_of("CHAIN or TARGET", o.argument);
  command.azimuth_trim_rad = o.azimuth_trim_deg * deg;
  command.elevation_trim_rad = o.elevation_trim_deg * deg;
  command.reason = text_of<Remark>("--reason", o.reason);
  command.epoch = utc_now();
  return send(load_live(o), command, command.epoch, is_of_antenna(what));
}

int mark(const Options& o, MissionEventKind kind) {
  const Time now = utc_now();
  MissionEvent event;
  event.kind = kind;
  event.epoch = parse_time(o.at, now);
  if (!o.label.empty()) event.label = text_of("LABEL", o.label);
  const config::ServiceConfig config = load_live(o);
  event.mission = o.mission.empty() ? config.range.name : text_of("--mission", o.mission);
  return send(config, event, now);
}

using Parsed = std::shared_ptr<Options>;

CLI::App* add(CLI::App& to, const Parsed& o, const char* name, const char* what) {
  CLI::App* command = to.add_subcommand(name, what);
  command->add_option("--config", o->dds.config, "Configuration of the range")->required();
  o->dds.add_to(*command);
  return command;
}

/// An order on `subject`; with a second argument, what is ordered of it.
struct OrderCommand {
  OperatorOrder order;
  const char* name;
  const char* help;
  const char* subject;
  const char* subject_help;
  const char* argument = nullptr;
  const char* argument_help = nullptr;
};

constexpr const char* chains = "all, without-SOURCE, only-SOURCE, only-radars or only-GPS: what its track is made of";

constexpr OrderCommand order_commands[] = {
    {OperatorOrder::Inhibit, "inhibit", "A source is not used, until it is released", "SOURCE", "Source"},
    {OperatorOrder::Force, "force", "A source is used whatever integrity finds", "SOURCE", "Source"},
    {OperatorOrder::Release, "release", "A source, a target's chain or an antenna as without any order", "SUBJECT",
     "Source, target or antenna"},
    {OperatorOrder::ResetBias, "reset-bias", "The bias of a radar or tracker begins anew, with its prior", "SENSOR",
     "Radar or tracker"},
    {OperatorOrder::AcknowledgeAlarm, "acknowledge", "An alarm of a source has been seen", "SOURCE", "Source"},
    {OperatorOrder::HoldChain, "hold", "A target stays on a chain of sources, until it is released", "TARGET", "Target",
     "CHAIN", chains},
    {OperatorOrder::PinAntennaSource, "pin", "An antenna follows a chain of sources, until it is released", "ANTENNA",
     "Antenna", "CHAIN", chains},
    {OperatorOrder::PinAntennaTarget, "retarget", "An antenna follows another target, until it is released", "ANTENNA",
     "Antenna", "TARGET", "Target"},
    {OperatorOrder::TrimAntenna, "trim", "Added to an antenna's commands, until it is released", "ANTENNA", "Antenna"},
    {OperatorOrder::StopAntenna, "stop", "No commands for an antenna, until it is released", "ANTENNA", "Antenna"},
};

void add_order(CLI::App& to, Run& run, const OrderCommand& what) {
  auto o = std::make_shared<Options>();
  CLI::App* command = add(to, o, what.name, what.help);
  command->add_option(what.subject, o->subject, what.subject_help)->required();
  if (what.argument != nullptr) command->add_option(what.argument, o->argument, what.argument_help)->required();
  if (what.order == OperatorOrder::TrimAntenna) {
    command->add_option("--azimuth", o->azimuth_trim_deg, "Degrees of the azimuth axis, -5 to 5")
        ->capture_default_str();
    command->add_option("--elevation", o->elevation_trim_deg, "Degrees of the elevation axis, -5 to 5")
        ->capture_default_str();
  }
  command->add_option("--as", o->who, "Who orders it")->required();
  command->add_option("--reason", o->reason, "Why: goes into the log and the archive")->required();
  command->callback([o, what = what.order, &run] { run = [o, what] { return order(*o, what); }; });
}

void add_mark(CLI::App& to, Run& run, MissionEventKind kind, const char* name, const char* help, bool label = false) {
  auto o = std::make_shared<Options>();
  CLI::App* command = add(to, o, name, help);
  if (label) command->add_option("LABEL", o->label, "What it is called, e.g. \"second stage\"")->required();
  command->add_option("--at", o->at, "now, +SECONDS, -SECONDS or UTC as 2026-11-26T06:00:00Z")->capture_default_str();
  command->add_option("--mission", o->mission, "Which mission (default: the range's name)");
  command->callback([o, kind, &run] { run = [o, kind] { return mark(*o, kind); }; });
}

}  // namespace

void add_operator(CLI::App& app, Run& run) {
  CLI::App* command = app.add_subcommand("operator",
                                         "Order something of the running service: what it uses of which source, what "
                                         "antennas follow, what time the mission "
                                         "has");
  command->require_subcommand(1);
  command->footer(
      "Every node that is heard answers: in force, or refused and why. Orders and marks are recorded and replayed "
      "like\n"
      "data; watch, the log and downrange/health say what is in force, since when and by whom.\n"
      "Exit code 0: in force at every node, 1: refused, or not answered by one.");
  for (const OrderCommand& what : order_commands) add_order(*command, run, what);
  CLI::App* mission = command->add_subcommand("mission", "The mission clock: topic range/mission");
  mission->require_subcommand(1);
  add_mark(*mission, run, MissionEventKind::PlannedLiftoff, "planned", "Planned lift-off; ends a hold");
  add_mark(*mission, run, MissionEventKind::Liftoff, "liftoff", "Lift-off; a later one corrects it");
  add_mark(*mission, run, MissionEventKind::Hold, "hold", "The count stands still, until a new lift-off is planned");
  add_mark(*mission, run, MissionEventKind::Recycle, "recycle", "The attempt is over: the count begins anew");
  add_mark(*mission, run, MissionEventKind::Staging, "staging", "A stage was separated", true);
  add_mark(*mission, run, MissionEventKind::Mark, "mark", "Anything else worth a mark", true);
}

}  // namespace downrange::app
