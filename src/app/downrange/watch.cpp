#include <iostream>
#include <string>
#include <text/printable.hpp>

#include <unistd.h>

#include "app/machine_clock.hpp"
#include "board.hpp"
#include "dds/outputs.hpp"
#include "flight.hpp"
#include "live_recording.hpp"
#include "pace.hpp"

namespace downrange::app {
namespace {

struct Options {
  DdsOptions dds;
  std::string record;
  bool plain = false;
  std::optional<double> idle_s;
  OutputFiles files;
};

/// Results into the board, and into the recording where there is one, from any thread.
class Consumer {
 public:
  Consumer(Board& board, LiveRecording* recording) : board_(board), recording_(recording) {}

  void add(const Result& result) {
    board_.add(result, Board::Clock::now());
    record(result);
  }
  void add(const SourceHealth& health, const Name& node) {
    board_.add(health, node, Board::Clock::now());
    record(Result(health));
  }

 private:
  void record(const Result& result) {
    if (recording_ != nullptr) recording_->write(result);
  }

  Board& board_;
  LiveRecording* recording_;
};

int watch(const Options& o) {
  const StopSignal stop;
  const config::ServiceConfig config = o.dds.load();
  o.files.check({o.record}, {o.dds.config});
  const dds::ParticipantOptions bus = participant_options(config, "downrange-watch");
  std::optional<LiveRecording> recording;
  if (!o.record.empty())
    recording.emplace(o.record, archive::WriterOptions{.overwrite = o.files.overwrite(o.record)}, config.text);

  dds::Participant participant(bus);
  Board board(participant.clock());
  Consumer consumer(board, recording ? &*recording : nullptr);
  const bool screen = !o.plain && isatty(STDOUT_FILENO) != 0;
  {
    const dds::OutputReaders readers(
        participant, {.lossless = recording.has_value()},
        {.result = [&](const Result& r) { consumer.add(r); },
         .status = [&](const dds::ServiceStatus& s) { board.add(s, Board::Clock::now()); },
         .health = [&](const SourceHealth& h, const Name& node) { consumer.add(h, node); }});
    const auto period = std::chrono::milliseconds(screen ? 200 : 1000);
    while (!stop.wait_for(period)) {
      if (o.idle_s && board.idle_for(*o.idle_s, Board::Clock::now())) break;
      if (recording && !recording->look_after()) break;
      if (screen) std::cout << "\033[H\033[J";
      std::cout << board.lines(Board::Clock::now(), utc_now());
      for (const std::string& mismatch : participant.mismatches())
        std::cout << "does not match: " << text::printable(mismatch) << '\n';
      std::cout << std::flush;
      if (!screen) std::cout << '\n';
    }
    const auto counts = readers.counts();
    if (counts.lost + counts.malformed + counts.incompatible > 0)
      std::cerr << counts.lost << " samples lost, " << counts.malformed << " malformed, " << counts.incompatible
                << " writers with unsuitable QoS\n";
  }
  std::cerr << board.commands() << " slaving commands received\n";
  return recording ? recording->close(board.status_metadata()).code : exit_ok;
}

}  // namespace

void add_watch(CLI::App& app, Run& run) {
  auto o = std::make_shared<Options>();
  CLI::App* command =
      app.add_subcommand("watch", "Watch tracks, slaving commands, sources and nodes, as a consumer over DDS");
  command->add_option("CONFIG", o->dds.config, "Configuration of the range")->required();
  command->add_option("--record", o->record, "Store every result received in this archive (.mcap)");
  command->add_flag("--plain", o->plain, "Lines once a second instead of a screen");
  command->add_option("--idle", o->idle_s, "End when nothing has come for this many seconds (default: Ctrl-C ends)")
      ->check(CLI::PositiveNumber);
  o->files.add_to(*command);
  o->dds.add_to(*command);
  command->callback([o, &run] { run = [o] { return watch(*o); }; });
}

}  // namespace downrange::app
