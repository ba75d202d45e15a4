#include "rotctl/client.hpp"

#include <algorithm>
#include <utility>

namespace downrange::rotctl {
namespace {

constexpr Duration first_pause = milliseconds(500);
constexpr Duration longest_pause = milliseconds(8000);
/// A rotator that was served for so long is well; a daemon that talks nonsense is found out sooner.
constexpr Duration well_after = milliseconds(2000);

}  // namespace

Client::Client(Endpoint rotator, const LinkSettings& settings, ClientCallbacks callbacks)
    : rotator_(std::move(rotator)),
      settings_(settings),
      callbacks_(std::move(callbacks)),
      book_(settings.link_delay + settings.lead),
      link_(settings),
      thread_([this] { run(); }) {}

void Client::finish() {
  if (!thread_.joinable()) return;
  {
    const std::scoped_lock lock(mutex_);
    stopped_ = true;
  }
  wake_.call();
  thread_.join();
}

void Client::take(const SlavingCommand& command) {
  const std::scoped_lock lock(mutex_);
  book_.take(command, now().utc);
}

LinkCounts Client::counts() const {
  const std::scoped_lock lock(mutex_);
  return counts_;
}

bool Client::stopped() const {
  const std::scoped_lock lock(mutex_);
  return stopped_;
}

void Client::run() {
  Duration pause = first_pause;
  while (!stopped()) {
    std::string why;
    Descriptor socket = connect_to(rotator_, settings_.timeout, wake_, why);
    const bool connected = static_cast<bool>(socket);
    if (connected) why = converse(socket);
    if (stopped()) return;
    const bool served = connected && is_well();
    if (connected) fell_out_ = !served;
    link_.disconnected();
    held_.clear();
    if (served) {
      said_.clear();
      pause = first_pause;
    }
    say(why);
    static_cast<void>(wait_for({}, false, &wake_, pause));
    pause = std::min(pause + pause, longest_pause);
  }
}

std::string Client::converse(Descriptor& socket) {
  {
    const std::scoped_lock lock(mutex_);
    connected_at_ = now().up;
    link_.connected(book_, now());
  }
  std::string unsent;
  std::optional<Duration> ends;  // the process does: by then the stop is answered, or never
  while (true) {
    Duration patience = step();
    if (stopped() && !ends) {
      link_.stop(now());
      ends = now().up + settings_.timeout;
    }
    tell();
    unsent += link_.take_output();
    if (!write_some(socket, unsent)) return "the connection is broken";
    if (!link_.fault().empty()) {
      abort(socket);  // what is not sent yet would be old by the time that it arrives
      return link_.fault();
    }
    if (ends && (!link_.moving() || now().up > *ends)) return {};
    if (ends) patience = *ends - now().up;
    const Ready ready = wait_for(socket, !unsent.empty(), ends ? nullptr : &wake_, patience);
    if (!ready.read) continue;
    const std::optional<std::string> bytes = read_some(socket);
    if (!bytes) return "the connection was closed by the rotator's daemon";
    link_.receive(*bytes, now());
  }
}

Duration Client::step() {
  const std::scoped_lock lock(mutex_);
  const Instant t = now();
  if (!stopped_) link_.step(book_, t);
  counts_ = link_.counts();
  return link_.due(book_, t) - t.up;
}

bool Client::is_well() const { return link_.established() && now().up - connected_at_ >= well_after; }

void Client::tell() {
  for (const AntennaReport& report : link_.take_reports()) callbacks_.report(report);
  for (std::string& text : link_.take_notes()) held_.push_back(std::move(text));
  if (fell_out_ && !is_well() && !stopped()) return;
  for (const std::string& text : held_) callbacks_.note(text);
  held_.clear();
}

void Client::say(const std::string& why) {
  if (why == said_) return;
  said_ = why;
  callbacks_.note(to_string(rotator_) + ": " + why + "; tries again");
}

}  // namespace downrange::rotctl
