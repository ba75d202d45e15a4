#include "flight.hpp"

#include <iostream>

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

void drive_over_dds(const config::ServiceConfig& config, const Name& driver, const DriveOptions& options,
                    const std::function<std::optional<Event>()>& next, const std::function<void(Time)>& progress,
                    std::optional<Time> last_tick) {
  if (config.clock.mode != config::ClockMode::Range)
    throw std::runtime_error(
        "flights over DDS are flown on the range clock: set clock.mode = \"range\" or --clock range");
  dds::Participant participant(participant_options(config, driver));
  dds::RangeClockDriver clock(participant, {.nodes = options.nodes});
  clock.wait_for_nodes(std::chrono::seconds(30));

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
    if (event && received_of(*event) < time) throw std::runtime_error("the events are not in order of their arrival");
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
