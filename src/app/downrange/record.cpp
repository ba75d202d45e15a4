#include <iostream>
#include <mutex>
#include <text/printable.hpp>

#include "dds/inputs.hpp"
#include "dds/outputs.hpp"
#include "flight.hpp"
#include "live_recording.hpp"
#include "pace.hpp"

namespace downrange::app {
namespace {

struct Options {
  DdsOptions dds;
  std::string out;
  std::optional<double> duration_s;
};

int record(const Options& o) {
  const StopSignal stop;
  const config::ServiceConfig config = o.dds.load();
  if (config.clock.mode != config::ClockMode::Wall)
    throw std::runtime_error(
        "record writes what arrives live, on the wall clock; a run on the range clock is recorded by "
        "its nodes ([archive]) and by watch --record");
  const dds::ParticipantOptions bus = participant_options(config, "downrange-record");
  LiveRecording recording(o.out, {}, config.text);
  std::mutex mutex;  // the middleware calls back from several threads
  std::uint64_t events = 0;
  Time newest{};

  dds::Participant participant(bus);
  std::optional<dds::InputReader> reader;
  reader.emplace(participant, dds::InputSelection{}, [&](const Event& arrived, const dds::RangeStamp&, const Name&) {
    const std::scoped_lock lock(mutex);
    Event event = arrived;
    // An archive is in order of `received`; callbacks of two topics may come out of order by microseconds.
    if (received_of(event) < newest) set_received(event, newest);
    newest = received_of(event);
    recording.write(event);
    ++events;
  });
  std::cerr << "recording domain " << config.dds.domain << " to " << o.out << "; Ctrl-C ends\n";
  const auto started = std::chrono::steady_clock::now();
  const auto over = [&] {
    return o.duration_s &&
           std::chrono::duration<double>(std::chrono::steady_clock::now() - started).count() >= *o.duration_s;
  };
  dds::NewMismatches mismatches;
  while (!over() && !stop.wait_for(std::chrono::milliseconds(200)) && recording.look_after()) {
    for (const std::string& mismatch : mismatches.among(participant.mismatches()))
      std::cerr << "does not match: " << text::printable(mismatch) << '\n';
  }
  const auto counts = reader->counts();
  reader.reset();
  const RecordingEnd end = recording.close();
  if (end.kept != events) std::cerr << end.kept << " of ";
  std::cerr << events << " messages recorded";
  if (counts.lost + counts.malformed > 0)
    std::cerr << ", " << counts.lost << " lost, " << counts.malformed << " malformed";
  std::cerr << '\n';
  return end.code;
}

}  // namespace

void add_record(CLI::App& app, Run& run) {
  auto o = std::make_shared<Options>();
  CLI::App* command =
      app.add_subcommand("record", "Record the range's inputs (radars, telemetry, mission) as they arrive");
  command->add_option("CONFIG", o->dds.config, "Configuration of the range")->required();
  command->add_option("--out", o->out, "Archive to write (.mcap); must not exist")->required();
  command->add_option("--duration", o->duration_s, "Seconds to record (default: until Ctrl-C)")
      ->check(CLI::PositiveNumber);
  o->dds.add_to(*command);
  command->callback([o, &run] { run = [o] { return record(*o); }; });
}

}  // namespace downrange::app
