#pragma once
/// TCP, as far as the rotator's client and server need it: sockets that never block, and a wake-up for their loops.

#include <downrange/geo/time.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

#include "rotctl/link.hpp"

namespace downrange::rotctl {

/// Owns a file descriptor.
class Descriptor {
 public:
  Descriptor() = default;
  explicit Descriptor(int fd) : fd_(fd) {}
  ~Descriptor() { reset(); }
  Descriptor(Descriptor&& other) noexcept : fd_(std::exchange(other.fd_, -1)) {}
  Descriptor& operator=(Descriptor&& other) noexcept {
    if (this != &other) reset(std::exchange(other.fd_, -1));
    return *this;
  }

  [[nodiscard]] int get() const { return fd_; }
  [[nodiscard]] explicit operator bool() const { return fd_ >= 0; }
  void reset(int fd = -1);

 private:
  int fd_ = -1;
};

/// Another thread's call for attention, to wait for beside a socket.
class Wake {
 public:
  Wake();
  void call() const;
  [[nodiscard]] int get() const { return event_.get(); }

 private:
  Descriptor event_;
};

struct Endpoint {
  std::string host;
  int port = 4533;
};
/// "127.0.0.1:4533", "[::1]:4533"
[[nodiscard]] std::string to_string(const Endpoint& endpoint);

/// Waits at most `timeout` for each address of the host, and no longer than until `wake` is called. Nothing, and `why`:
/// not connected.
[[nodiscard]] Descriptor connect_to(const Endpoint& endpoint, Duration timeout, const Wake& wake, std::string& why);
/// Throws std::runtime_error with the endpoint and why it cannot be listened on.
[[nodiscard]] Descriptor listen_on(const Endpoint& endpoint);
/// The port that the kernel chose, where it was left to it.
[[nodiscard]] int port_of(const Descriptor& socket);

/// Reads what is there, at most some kilobytes. Nothing: the peer has closed, or the connection is broken.
[[nodiscard]] std::optional<std::string> read_some(const Descriptor& socket);
/// Writes as much of `bytes` as the peer takes now, and removes it from them. False: the connection is broken.
[[nodiscard]] bool write_some(const Descriptor& socket, std::string& bytes);
/// Closes at once: what was not sent yet is never sent.
void abort(Descriptor& socket);

struct Ready {
  bool read = false;
  bool write = false;
  bool woken = false;
};
/// What is ready within `timeout`; nothing or less: looks only. No socket, and no wake-up, where they are not there.
[[nodiscard]] Ready wait_for(const Descriptor& socket, bool write, const Wake* wake, Duration timeout);

/// Of this machine's clocks.
[[nodiscard]] Instant now();

}  // namespace downrange::rotctl
