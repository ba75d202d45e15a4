#include "rotctl/socket.hpp"

#include <fcntl.h>
#include <netdb.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <poll.h>
#include <sys/eventfd.h>
#include <sys/socket.h>
#include <time.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <memory>
#include <stdexcept>
#include <system_error>

namespace downrange::rotctl {
namespace {

std::string text_of(int error) { return std::generic_category().message(error); }

using Addresses = std::unique_ptr<addrinfo, decltype(&freeaddrinfo)>;

/// Nothing, and `why`.
Addresses resolve(const Endpoint& endpoint, int flags, std::string& why) {
  addrinfo hints{};
  hints.ai_socktype = SOCK_STREAM;
  hints.ai_flags = flags | AI_NUMERICSERV;
  addrinfo* found = nullptr;
  const int error = getaddrinfo(endpoint.host.c_str(), std::to_string(endpoint.port).c_str(), &hints, &found);
  if (error != 0) why = gai_strerror(error);
  return {error == 0 ? found : nullptr, &freeaddrinfo};
}

std::int64_t nanoseconds(clockid_t clock) {
  timespec t{};
  clock_gettime(clock, &t);
  return static_cast<std::int64_t>(t.tv_sec) * 1'000'000'000 + t.tv_nsec;
}

void set(const Descriptor& socket, int level, int option, int value) {
  // A socket without it works as well.
  static_cast<void>(setsockopt(socket.get(), level, option, &value, sizeof value));
}

/// 0, or the error.
int finish_connecting(const Descriptor& socket, Duration timeout, const Wake& wake) {
  const Ready ready = wait_for(socket, true, &wake, timeout);
  if (ready.woken) return ECANCELED;
  if (!ready.write && !ready.read) return ETIMEDOUT;
  int error = 0;
  socklen_t size = sizeof error;
  return getsockopt(socket.get(), SOL_SOCKET, SO_ERROR, &error, &size) == 0 ? error : errno;
}

}  // namespace

void Descriptor::reset(int fd) {
  if (fd_ >= 0) close(fd_);
  fd_ = fd;
}

Wake::Wake() : event_(eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK)) {
  if (!event_) throw std::system_error(errno, std::generic_category(), "eventfd");
}

void Wake::call() const {
  const std::uint64_t one = 1;
  static_cast<void>(::write(event_.get(), &one, sizeof one));  // fails only where it is called already
}

std::string to_string(const Endpoint& endpoint) {
  const bool ipv6 = endpoint.host.find(':') != std::string::npos;
  return (ipv6 ? '[' + endpoint.host + ']' : endpoint.host) + ':' + std::to_string(endpoint.port);
}

Descriptor connect_to(const Endpoint& endpoint, Duration timeout, const Wake& wake, std::string& why) {
  const Addresses addresses = resolve(endpoint, 0, why);
  for (const addrinfo* a = addresses.get(); a != nullptr; a = a->ai_next) {
    Descriptor socket(::socket(a->ai_family, a->ai_socktype | SOCK_NONBLOCK | SOCK_CLOEXEC, a->ai_protocol));
    int error = socket ? 0 : errno;
    if (socket && connect(socket.get(), a->ai_addr, a->ai_addrlen) != 0) {
      error = errno == EINPROGRESS ? finish_connecting(socket, timeout, wake) : errno;
    }
    if (error == 0) {
      set(socket, IPPROTO_TCP, TCP_NODELAY, 1);
      return socket;
    }
    why = text_of(error);
    if (error == ECANCELED) break;
  }
  return {};
}

Descriptor listen_on(const Endpoint& endpoint) {
  std::string why;
  const Addresses addresses = resolve(endpoint, AI_PASSIVE, why);
  for (const addrinfo* a = addresses.get(); a != nullptr; a = a->ai_next) {
    Descriptor socket(::socket(a->ai_family, a->ai_socktype | SOCK_NONBLOCK | SOCK_CLOEXEC, a->ai_protocol));
    if (socket) {
      set(socket, SOL_SOCKET, SO_REUSEADDR, 1);
      if (bind(socket.get(), a->ai_addr, a->ai_addrlen) == 0 && listen(socket.get(), SOMAXCONN) == 0) return socket;
    }
    why = text_of(errno);
  }
  throw std::runtime_error(to_string(endpoint) + ": cannot be listened on: " + why);
}

int port_of(const Descriptor& socket) {
  sockaddr_storage address{};
  socklen_t size = sizeof address;
  if (getsockname(socket.get(), reinterpret_cast<sockaddr*>(&address), &size) != 0) return 0;
  return ntohs(address.ss_family == AF_INET6 ? reinterpret_cast<const sockaddr_in6&>(address).sin6_port
                                             : reinterpret_cast<const sockaddr_in&>(address).sin_port);
}

std::optional<std::string> read_some(const Descriptor& socket) {
  std::array<char, 4096> bytes;
  const ssize_t size = recv(socket.get(), bytes.data(), bytes.size(), 0);
  if (size > 0) return std::string(bytes.data(), static_cast<std::size_t>(size));
  if (size < 0 && (errno == EAGAIN || errno == EINTR)) return std::string();
  return std::nullopt;
}

bool write_some(const Descriptor& socket, std::string& bytes) {
  while (!bytes.empty()) {
    const ssize_t size = send(socket.get(), bytes.data(), bytes.size(), MSG_NOSIGNAL);
    if (size < 0) return errno == EAGAIN || errno == EINTR;
    bytes.erase(0, static_cast<std::size_t>(size));
  }
  return true;
}

void abort(Descriptor& socket) {
  const linger at_once{.l_onoff = 1, .l_linger = 0};
  static_cast<void>(setsockopt(socket.get(), SOL_SOCKET, SO_LINGER, &at_once, sizeof at_once));
  socket.reset();
}

Ready wait_for(const Descriptor& socket, bool write, const Wake* wake, Duration timeout) {
  std::array<pollfd, 2> both{{{socket.get(), static_cast<short>(write ? POLLIN | POLLOUT : POLLIN), 0},  // NOLINT
                              {wake == nullptr ? -1 : wake->get(), POLLIN, 0}}};
  const std::int64_t ns = std::max<std::int64_t>(timeout.ns, 0);
  const timespec limit{.tv_sec = ns / 1'000'000'000, .tv_nsec = ns % 1'000'000'000};
  if (ppoll(both.data(), both.size(), &limit, nullptr) <= 0) return {};
  return {.read = (both[0].revents & ~POLLOUT) != 0,
          .write = (both[0].revents & POLLOUT) != 0,
          .woken = both[1].revents != 0};
}

Instant now() { return {{nanoseconds(CLOCK_REALTIME)}, {nanoseconds(CLOCK_MONOTONIC)}}; }

}  // namespace downrange::rotctl
