#pragma once
/// Answers who asks where an antenna points, over TCP: a thread of its own, several clients.

#include <functional>
#include <list>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "rotctl/responder.hpp"
#include "rotctl/socket.hpp"

namespace downrange::rotctl {

struct ServerSettings {
  Endpoint endpoint{"127.0.0.1", 4533};  ///< port 0: the kernel chooses one
  Travel travel;                         ///< of the antenna's commands
  Duration ahead;                        ///< link delay and lead: how far ahead of now they apply
  std::string info;                      ///< what it says it is
  std::size_t most_clients = 16;         ///< more are turned away
  Patience patience{};
};

class Server {
 public:
  /// Throws std::runtime_error where the endpoint cannot be listened on. `note` is called on the server's thread.
  Server(ServerSettings settings, std::function<void(const std::string&)> note);
  ~Server();
  Server(const Server&) = delete;
  Server& operator=(const Server&) = delete;

  /// From any thread; never waits for a client.
  void take(const SlavingCommand& command);
  [[nodiscard]] Endpoint endpoint() const { return {settings_.endpoint.host, port_of(listener_)}; }

 private:
  struct Connection {
    Descriptor socket;
    Responder responder;
    std::string unsent = {};
    bool broken = false;
  };

  void run();
  void accept_clients();
  /// Reads, answers, writes.
  void serve(Connection& connection, bool readable);

  const ServerSettings settings_;
  const std::function<void(const std::string&)> note_;
  const Descriptor listener_;
  std::mutex mutex_;  ///< of the next two
  CommandBook book_;
  bool stopped_ = false;
  const Told told_;
  std::list<Connection> connections_;
  bool full_ = false;
  Wake wake_;
  std::thread thread_;
};

}  // namespace downrange::rotctl
