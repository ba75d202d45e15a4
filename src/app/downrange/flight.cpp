#include "flight.hpp"

#include <iostream>

#include "app/machine_clock.hpp"
#include "dds/inputs.hpp"
#include "dds/range_clock.hpp"
#include "pace.hpp"

namespace downrange::app {

void replay_in_process(archive::EventSource& source, const RangeConfig& range, const StageSet& stages, ResultSink& sink,
                       const std::function<void(const Event&)>& before) {
  Engine engine(range, stages, sink);
  while (const auto event = source.next()) {
    const Event admitted = engine.admit(*event);
    before(admitted);
    engine.handle(admitted);
  }
  if (const auto tick = source.last_tick()) engine.advance_to(*tick);
}

void replay_in_process(std::span<const Event> events, std::optional<Time> last_tick, const RangeConfig& range,
                       const StageSet& stages, ResultSink& sink, const std::function<void(const Event&)>& before) {
  Engine engine(range, stages, sink);
  for (const Event& event : events) {
    const Event admitted = engine.admit(event);
    before(admitted);
    engine.handle(admitted);
  }
  if (last_tick) engine.advance_to(*last_tick);
}

namespace {

constexpr std::chrono::seconds patience{30};
/// From the meeting of readers to the first message, so that every reader has met every writer.
constexpr Duration lead = milliseconds(1000);

constexpr const char* out_of_order = "the events are not in order of their arrival";

void drive_on_wall_clock(const config::ServiceConfig& config, dds::Participant& participant,
                         const std::function<std::optional<Event>()>& next, const std::function<void(Time)>& progress) {
  dds::InputWriters writers(participant);
  if (!writers.wait_for_matched(1, patience))
    throw std::runtime_error("nobody reads range/... in domain " + std::to_string(config.dds.domain) + " within " +
                             std::to_string(patience.count()) + " s: is downranged running there on the wall clock?");
  std::optional<Duration> moved;
  Time time{};
  std::uint64_t refused = 0;
  Pace pace(1);
  while (std::optional<Event> event = next()) {
    if (std::holds_alternative<ClockGap>(*event)) continue;
    const Time received = received_of(*event);
    if (!moved) {
      moved = utc_now() + lead - received;
      pace.wait_until(received - lead);
    } else if (received < time) {
      throw std::runtime_error(out_of_order);
    }
    time = received;
    std::visit(
        [&]<class Record>(Record& record) {
          if constexpr (Inputs::contains<Record>) {
            record.epoch = record.epoch + *moved;
            record.simulated = true;
          }
        },
        *event);
    pace.wait_until(time);
    if (!writers.write(*event)) ++refused;
    progress(time);
  }
  if (refused > 0) throw std::runtime_error(std::to_string(refused) + " messages could not be written");
}

}  // namespace

void drive_over_dds(const config::ServiceConfig& config, const Name& driver, const DriveOptions& options,
                    const std::function<std::optional<Event>()>& next, const std::function<void(Time)>& progress,
                    std::optional<Time> last_tick) {
  const bool wall = config.clock.mode == config::ClockMode::Wall;
  if (wall && options.rate != 1)
    throw std::runtime_error("on the wall clock a second of flight takes one: --rate 1, or --clock range");
  dds::Participant participant(participant_options(config, driver));
  if (wall) return drive_on_wall_clock(config, participant, next, progress);
  dds::RangeClockDriver clock(participant, {.nodes = options.nodes});
  clock.wait_for_nodes(patience);

  Pace pace(options.rate);
  // A gap of the wall clock is none of the range clock, whose ticks are all run.
  const auto next_input = [&] {
    std::optional<Event> event = next();
    while (event && std::holds_alternative<ClockGap>(*event)) event = next();
    return event;
  };
  std::vector<Event> step;
  std::optional<Event> event = next_input();
  Time time{};
  while (event) {
    step.clear();
    time = received_of(*event);
    while (event && received_of(*event) == time) {
      step.push_back(*event);
      event = next_input();
    }
    if (event && received_of(*event) < time) throw std::runtime_error(out_of_order);
    pace.wait_until(time);
    clock.step(time, step);
    progress(time);
  }
  if (last_tick && *last_tick > time) clock.step(*last_tick, {});
  clock.finish();
}

namespace {

int judge_close(const archive::WriterStatus& status, const std::string& path) {
  if (status.ok()) return exit_ok;
  std::cerr << "downrange: " << path << ": " << status.failure << '\n';
  return exit_failed;
}

}  // namespace

int close_archive(archive::Writer& writer, const std::string& path) { return judge_close(writer.close(), path); }
int close_archive(archive::NewArchive& archive, const std::string& path) { return judge_close(archive.close(), path); }

}  // namespace downrange::app
