#pragma once
/// Drives one antenna through its rotator daemon: a thread of its own, that connects, asks, and connects again.

#include <functional>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "rotctl/socket.hpp"

namespace downrange::rotctl {

/// Called on the client's thread.
struct ClientCallbacks {
  std::function<void(const AntennaReport&)> report;
  std::function<void(const std::string&)> note;  ///< what a person should know, once each
};

class Client {
 public:
  Client(Endpoint rotator, const LinkSettings& settings, ClientCallbacks callbacks);
  ~Client() { finish(); }
  Client(const Client&) = delete;
  Client& operator=(const Client&) = delete;

  /// From any thread; never waits for the rotator.
  void take(const SlavingCommand& command);
  [[nodiscard]] LinkCounts counts() const;
  /// The rotator is told to stop where it is on its way, and is waited for as long as for any answer. Nothing more is
  /// done after that.
  void finish();

 private:
  void run();
  [[nodiscard]] bool stopped() const;
  /// The rotator is served, and has been for a while.
  [[nodiscard]] bool is_well() const;
  /// Why it ended.
  [[nodiscard]] std::string converse(Descriptor& socket);
  /// Asks what is due. How long nothing else will be.
  [[nodiscard]] Duration step();
  /// What the link has to tell.
  void tell();
  void say(const std::string& why);

  const Endpoint rotator_;
  const LinkSettings settings_;
  const ClientCallbacks callbacks_;
  mutable std::mutex mutex_;  ///< of the next three
  CommandBook book_;
  LinkCounts counts_;
  bool stopped_ = false;
  Link link_;
  std::string said_;               ///< of connections that failed, since one did not
  Duration connected_at_{};        ///< by the clock that no one steps
  bool fell_out_ = false;          ///< of the last connection: soon, over what was said
  std::vector<std::string> held_;  ///< notes of a connection that may fall out as the last one
  Wake wake_;
  std::thread thread_;
};

}  // namespace downrange::rotctl
