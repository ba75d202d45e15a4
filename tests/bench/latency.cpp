/// How long a plot takes until a consumer in another process has what was made of it, beside a bare relay of the same
/// plots. tools/bench latency runs both beside the service and the simulated radars; timings are read by people.
///
///   downrange_latency relay DOMAIN PROFILES             reads range/radar_tspi, writes bench/relay; until it is killed
///   downrange_latency observe DOMAIN PROFILES SECONDS   measures so long, prints the table. Exit status 1: nothing to
///                                                       measure
///
/// Relay and service have the same reader, with the profile of the topic. When a plot was written the observer knows
/// from its writer's own stamp (DDS source time stamp), when it had the results from its own clock: all on one machine.
/// So a scenario without delays is needed, whose plots arrive in the order of their epochs.

#include <downrangePubSubTypes.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <fastdds/dds/publisher/DataWriter.hpp>
#include <fastdds/dds/publisher/Publisher.hpp>
#include <map>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "reader.hpp"

namespace {

using namespace downrange::bench;
using namespace eprosima::fastdds::dds;
using downrange::wire::RadarTspiV2;
using downrange::wire::SlavingCommandV4;
using downrange::wire::TrajectoryV2;

constexpr const char* plots_topic = "range/radar_tspi";
constexpr const char* relay_topic = "bench/relay";

using PlotReader = Reader<RadarTspiV2, downrange::wire::RadarTspiV2PubSubType>;

void relay(DomainParticipant& participant) {
  Publisher* publisher = participant.create_publisher(PUBLISHER_QOS_DEFAULT);
  DataWriter* writer = publisher->create_datawriter_with_profile(
      topic(participant, relay_topic, TypeSupport(new downrange::wire::RadarTspiV2PubSubType)), "stream");
  if (writer == nullptr) std::exit(2);
  // The stamp, empty on the wall clock, carries when the relay had it.
  RadarTspiV2 relayed;
  const PlotReader reader(participant, plots_topic, "stream", [&](const RadarTspiV2& plot, Ns, Ns here) {
    relayed = plot;
    relayed.stamp().run_id(static_cast<std::uint64_t>(here));
    if (!writer->write(&relayed)) std::fprintf(stderr, "not relayed\n");
  });
  while (true) std::this_thread::sleep_for(std::chrono::hours(1));
}

/// What became of one plot; 0: nothing.
struct Plot {
  Ns written = 0;
  Ns at_relay = 0;
  Ns relayed = 0;
  Ns at_service = 0;
  Ns trajectory = 0;
  Ns command = 0;  ///< the first that it is the newest measurement of
};

/// The results of one run, by the plots' epochs. From any of the middleware's threads.
class Observed {
 public:
  void plot(const RadarTspiV2& plot, Ns written, Ns) { at(plot.epoch_ns()).written = written; }
  void relayed(const RadarTspiV2& plot, Ns, Ns here) {
    const std::lock_guard lock(mutex_);
    Plot& p = plots_[plot.epoch_ns()];
    p.at_relay = static_cast<Ns>(plot.stamp().run_id());
    p.relayed = here;
  }
  void trajectory(const TrajectoryV2& trajectory, Ns, Ns here) {
    const std::lock_guard lock(mutex_);
    Plot& p = plots_[trajectory.epoch_ns()];
    if (p.trajectory != 0) return;  // a fix in between: the plot is older
    p.at_service = trajectory.received_ns();
    p.trajectory = here;
  }
  void command(const SlavingCommandV4& command, Ns, Ns here) {
    const std::lock_guard lock(mutex_);
    if (antenna_.empty()) antenna_ = command.antenna_id().to_string();
    if (antenna_ != command.antenna_id().to_string()) return;
    from_tick_.push_back(here - command.tick_ns());
    Plot& p = plots_[command.data_epoch_ns()];
    if (p.command == 0) p.command = here;
  }

  [[nodiscard]] int report() const;

 private:
  Plot& at(Ns epoch) {
    const std::lock_guard lock(mutex_);
    return plots_[epoch];
  }

  mutable std::mutex mutex_;
  std::map<Ns, Plot> plots_;
  std::vector<Ns> from_tick_;  ///< of the commands to one antenna
  std::string antenna_;
};

constexpr double shares[] = {0.5, 0.99, 0.999};

/// Nearest rank.
double quantile_us(const std::vector<Ns>& sorted, double share) {
  const auto rank = static_cast<std::size_t>(std::ceil(share * static_cast<double>(sorted.size())));
  return static_cast<double>(sorted[std::max<std::size_t>(rank, 1) - 1]) * 1e-3;
}

/// One line of the table; beside `base`, where there is one, the ratios to it.
void print(const char* what, std::vector<Ns>& latencies, const std::vector<Ns>* base) {
  std::sort(latencies.begin(), latencies.end());
  std::printf("%-58s %7zu", what, latencies.size());
  if (latencies.empty()) {
    std::printf("  nothing\n");
    return;
  }
  for (const double share : shares) std::printf(" %8.0f", quantile_us(latencies, share));
  std::printf(" %8.0f", static_cast<double>(latencies.back()) * 1e-3);
  if (base != nullptr && !base->empty())
    for (const double share : shares) std::printf(" %6.2f", quantile_us(latencies, share) / quantile_us(*base, share));
  std::printf("\n");
}

int Observed::report() const {
  const std::lock_guard lock(mutex_);
  std::vector<Ns> relayed, to_relay, through_relay, trajectory, to_service, through_service, later, command;
  for (const auto& [epoch, p] : plots_) {
    if (p.written == 0) continue;
    if (p.command != 0) command.push_back(p.command - p.written);
    if (p.relayed == 0 || p.trajectory == 0) continue;  // both ways of the same plots
    relayed.push_back(p.relayed - p.written);
    to_relay.push_back(p.at_relay - p.written);
    through_relay.push_back(p.relayed - p.at_relay);
    trajectory.push_back(p.trajectory - p.written);
    to_service.push_back(p.at_service - p.written);
    through_service.push_back(p.trajectory - p.at_service);
    later.push_back(p.trajectory - p.relayed);
  }
  std::vector<Ns> from_tick = from_tick_;
  std::printf("%-58s %7s %8s %8s %8s %8s %s\n", "us", "of", "p50", "p99", "p99.9", "most", "  ratio to the relay");
  print("plot written -> relay -> read", relayed, nullptr);
  print("  written -> at the relay", to_relay, nullptr);
  print("  at the relay -> read", through_relay, nullptr);
  print("plot written -> trajectory read", trajectory, &relayed);
  print("  written -> at the service", to_service, &to_relay);
  print("  at the service -> trajectory read", through_service, &through_relay);
  print("  the same plot: trajectory read after the relay's", later, nullptr);
  print("plot written -> slaving read, of the newest plot in it", command, &relayed);
  print("  tick -> slaving read, every command", from_tick, &through_relay);
  return relayed.empty() || command.empty() ? 1 : 0;
}

int observe(DomainParticipant& participant, int run_s) {
  Observed observed;
  const auto into = [&observed](auto member) {
    return [&observed, member](const auto& sample, Ns written, Ns here) { (observed.*member)(sample, written, here); };
  };
  const PlotReader plots(participant, plots_topic, "stream", into(&Observed::plot));
  const PlotReader relayed(participant, relay_topic, "stream", into(&Observed::relayed));
  const Reader<TrajectoryV2, downrange::wire::TrajectoryV2PubSubType> trajectories(
      participant, "downrange/trajectory", "owned", into(&Observed::trajectory));
  const Reader<SlavingCommandV4, downrange::wire::SlavingCommandV4PubSubType> commands(
      participant, "downrange/slaving", "slaving-client", into(&Observed::command));
  std::this_thread::sleep_for(std::chrono::seconds(run_s));
  const int status = observed.report();
  participant.delete_contained_entities();
  return status;
}

}  // namespace

int main(int argc, char** argv) {
  const std::string what = argc > 1 ? argv[1] : "";
  if (!(what == "relay" && argc == 4) && !(what == "observe" && argc == 5)) {
    std::fprintf(stderr, "usage: %s relay DOMAIN PROFILES | observe DOMAIN PROFILES SECONDS\n", argv[0]);
    return 2;
  }
  DomainParticipant& participant = participant_in(argv[2], argv[3]);
  if (what == "relay") relay(participant);
  const int status = observe(participant, std::atoi(argv[4]));
  DomainParticipantFactory::get_instance()->delete_participant(&participant);
  return status;
}
