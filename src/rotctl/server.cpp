#include "rotctl/server.hpp"

#include <poll.h>
#include <sys/socket.h>

#include <algorithm>
#include <utility>

namespace downrange::rotctl {

Server::Server(ServerSettings settings, std::function<void(const std::string&)> note)
    : settings_(std::move(settings)),
      note_(std::move(note)),
      listener_(listen_on(settings_.endpoint)),
      book_(settings_.ahead),
      told_{.travel = settings_.travel,
            .info = settings_.info,
            .aim =
                [this] {
                  const std::scoped_lock lock(mutex_);
                  return book_.at(now().utc);
                }},
      thread_([this] { run(); }) {}

Server::~Server() {
  {
    const std::scoped_lock lock(mutex_);
    stopped_ = true;
  }
  wake_.call();
  thread_.join();
}

void Server::take(const SlavingCommand& command) {
  const std::scoped_lock lock(mutex_);
  book_.take(command, now().utc);
}

void Server::run() {
  std::vector<pollfd> waits;
  while (true) {
    waits.assign({{wake_.get(), POLLIN, 0}, {listener_.get(), POLLIN, 0}});
    Duration first = now().up + settings_.patience.idle;
    for (const Connection& c : connections_) {
      waits.push_back({c.socket.get(), static_cast<short>(c.unsent.empty() ? POLLIN : POLLOUT), 0});
      first = std::min(first, c.responder.deadline());
    }
    const std::int64_t ns = std::max<std::int64_t>((first - now().up).ns, 0);
    const timespec limit{.tv_sec = ns / 1'000'000'000, .tv_nsec = ns % 1'000'000'000};
    if (ppoll(waits.data(), waits.size(), &limit, nullptr) < 0) continue;
    if (waits[0].revents != 0) return;
    std::size_t i = 2;
    for (Connection& c : connections_) serve(c, waits[i++].revents != 0);
    const Duration up = now().up;
    connections_.remove_if([up](const Connection& c) {
      return c.broken || (c.responder.closing(up) && c.unsent.empty()) || up >= c.responder.deadline();
    });
    if (waits[1].revents != 0) accept_clients();
  }
}

void Server::accept_clients() {
  while (true) {
    Descriptor socket(accept4(listener_.get(), nullptr, nullptr, SOCK_NONBLOCK | SOCK_CLOEXEC));
    if (!socket) return;
    const bool full = connections_.size() >= settings_.most_clients;
    if (full && !full_) note_(std::to_string(settings_.most_clients) + " clients are there: more are turned away");
    full_ = full;
    if (!full) connections_.push_back({std::move(socket), Responder(told_, settings_.patience, now().up)});
  }
}

void Server::serve(Connection& connection, bool ready) {
  if (!ready) return;
  // A client that does not read its answers is not listened to, so that they are no more than those to one reading.
  if (connection.unsent.empty()) {
    const std::optional<std::string> bytes = read_some(connection.socket);
    connection.broken = !bytes;
    if (bytes) connection.unsent = connection.responder.receive(*bytes, now().up);
  }
  connection.broken = connection.broken || !write_some(connection.socket, connection.unsent);
}

}  // namespace downrange::rotctl
