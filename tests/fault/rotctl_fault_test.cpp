/// Rotator daemons that are absent, killed, silent or talk nonsense, and clients that do: over TCP on this machine,
/// without DDS. Waits for what must happen, with a limit that only a failure reaches.
#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <sys/socket.h>

#include <atomic>
#include <chrono>
#include <cmath>
#include <numbers>

#include "rotctl/client.hpp"
#include "rotctl/server.hpp"

namespace downrange::rotctl {
namespace {

constexpr double deg = std::numbers::pi / 180;
constexpr Duration long_wait = milliseconds(20'000);
constexpr const char* state =
    "1\n1\nmin_az=-180.000000\nmax_az=450.000000\nmin_el=0.000000\nmax_el=90.000000\nsouth_zero=0\nrot_type="
    "AzEl\ndone\n";

/// One end of a connection, for the test: waits.
class Peer {
 public:
  explicit Peer(Descriptor socket) : socket_(std::move(socket)) {}

  /// The next line; empty: the other end has closed, or nothing came.
  std::string line() {
    while (true) {
      if (auto line = lines_.next()) return *line;
      if (!wait_for(socket_, false, nullptr, long_wait).read) return {};
      const auto bytes = read_some(socket_);
      if (!bytes) return {};
      lines_.add(*bytes);
    }
  }
  /// Whether the other end closes, whatever it says before.
  bool closed() {
    while (wait_for(socket_, false, nullptr, long_wait).read)
      if (!read_some(socket_)) return true;
    return false;
  }
  void say(std::string bytes) {
    while (!bytes.empty() && write_some(socket_, bytes)) static_cast<void>(wait_for(socket_, true, nullptr, long_wait));
  }
  /// As much as the other end takes, which is removed from `bytes`.
  void say_some(std::string& bytes) { EXPECT_TRUE(write_some(socket_, bytes)); }

 private:
  Descriptor socket_;
  LineReader lines_;
};

/// A rotator's daemon, played by the test.
class Daemon {
 public:
  explicit Daemon(int port = 0) : listener_(listen_on({"127.0.0.1", port})) {}
  Endpoint endpoint() const { return {"127.0.0.1", port_of(listener_)}; }
  Peer accept() {
    EXPECT_TRUE(wait_for(listener_, false, nullptr, long_wait).read) << "nobody connects";
    return Peer(Descriptor(accept4(listener_.get(), nullptr, nullptr, SOCK_NONBLOCK | SOCK_CLOEXEC)));
  }
  /// A connection that has told its travel. A line before that is left in `first`.
  Peer greet() {
    Peer peer = accept();
    EXPECT_EQ(peer.line(), "\\dump_state");
    peer.say(state);
    return peer;
  }

 private:
  Descriptor listener_;
};

/// 40 commands a second while it lives, on the wall clock.
template <class Taker>
class Feeder {
 public:
  explicit Feeder(Taker& taker) : thread_([this, &taker] { run(taker); }) {}
  ~Feeder() {
    stopped_ = true;
    thread_.join();
  }

 private:
  void run(Taker& taker) {
    while (!stopped_) {
      SlavingCommand c;
      c.antenna = "dish";
      c.tick = now().utc;
      c.apply_at = c.tick;
      c.valid_until = c.apply_at + milliseconds(200);
      c.azimuth_rad = 100 * deg;
      c.elevation_rad = 45 * deg;
      taker.take(c);
      std::this_thread::sleep_for(std::chrono::milliseconds(25));
    }
  }
  std::atomic<bool> stopped_{false};
  std::thread thread_;
};

class RotctlClient : public testing::Test {
 protected:
  static LinkSettings settings() {
    return {.antenna = "dish",
            .travel = {-180 * deg, 180 * deg, 0, 90 * deg},
            .rate_hz = 20,
            .timeout = milliseconds(5'000)};
  }
  ClientCallbacks callbacks() {
    return {.report =
                [this](const AntennaReport& report) {
                  const std::scoped_lock lock(mutex_);
                  reports_.push_back(report);
                },
            .note =
                [this](const std::string& text) {
                  const std::scoped_lock lock(mutex_);
                  notes_ += text + '\n';
                }};
  }
  /// Whether a person is told so, some time.
  bool told(const std::string& text) {
    for (int i = 0; i < 2'000; ++i, std::this_thread::sleep_for(std::chrono::milliseconds(10))) {
      const std::scoped_lock lock(mutex_);
      if (notes_.find(text) != std::string::npos) return true;
    }
    ADD_FAILURE() << "not told: " << text << "\ntold:\n" << notes_;
    return false;
  }
  /// Answers `p` until a position comes.
  static std::string next_position(Peer& peer) {
    for (int i = 0; i < 1'000; ++i) {
      std::string line = peer.line();
      if (line != "p") return line;
      peer.say("99.0\n44.0\n");
    }
    return "no position";
  }

  std::mutex mutex_;
  std::string notes_;
  std::vector<AntennaReport> reports_;
};

TEST_F(RotctlClient, AnAbsentDaemonIsSaidAndTriedAgain) {
  const int port = Daemon().endpoint().port;  // gone already
  Client client({"127.0.0.1", port}, settings(), callbacks());
  EXPECT_TRUE(told("127.0.0.1:" + std::to_string(port) + ": Connection refused; tries again"));
  Daemon daemon(port);
  Peer peer = daemon.greet();
  EXPECT_TRUE(told("connected, rotator model 1"));
  EXPECT_EQ(peer.line(), "p");
}

TEST_F(RotctlClient, ADaemonThatDiesIsFollowedByItsSuccessor) {
  auto daemon = std::make_unique<Daemon>();
  const int port = daemon->endpoint().port;
  Client client(daemon->endpoint(), settings(), callbacks());
  {
    const Feeder feeder(client);
    {
      Peer peer = daemon->greet();
      EXPECT_EQ(next_position(peer), "P 100.0000 45.0000");
      peer.say("RPRT 0\n");
      EXPECT_EQ(peer.line(), "p");
      peer.say("99.0\n44.0\n");
      EXPECT_EQ(peer.line(), "P 100.0000 45.0000");
    }
    daemon.reset();  // in the middle of a question
    EXPECT_TRUE(told("tries again"));
    daemon = std::make_unique<Daemon>(port);
    Peer peer = daemon->greet();
    EXPECT_EQ(next_position(peer), "P 100.0000 45.0000");
    daemon.reset();
  }
  // Commands have ended meanwhile, and the rotator may still be moving: that comes first.
  daemon = std::make_unique<Daemon>(port);
  Peer peer = daemon->accept();
  EXPECT_EQ(peer.line(), "S");
  EXPECT_EQ(peer.line(), "\\dump_state");
  const std::scoped_lock lock(mutex_);
  ASSERT_FALSE(reports_.empty());
  EXPECT_NEAR(reports_.back().azimuth_rad / deg, 99, 1e-9);
}

TEST_F(RotctlClient, NonsenseIsShownAndTheConnectionMadeAnew) {
  Daemon daemon;
  Client client(daemon.endpoint(), settings(), callbacks());
  Peer other_service = daemon.accept();
  other_service.say("SSH-2.0-OpenSSH_9.2\r\n");
  EXPECT_TRUE(told("no answer to \\dump_state: found 'SSH-2.0-OpenSSH_9.2'"));
  EXPECT_TRUE(other_service.closed());
  Peer endless = daemon.accept();
  endless.say(std::string(10'000, 'x'));
  EXPECT_TRUE(told("a line without end"));
  Peer peer = daemon.greet();
  EXPECT_EQ(peer.line(), "p");
  peer.say("nan\n0\n");
  EXPECT_TRUE(told("no answer to p: found 'nan'"));
  EXPECT_EQ(daemon.greet().line(), "p");
  const std::scoped_lock lock(mutex_);
  EXPECT_TRUE(reports_.empty());
}

TEST_F(RotctlClient, NonsenseIsSaidOnceHoweverOftenItIsConnectedTo) {
  Daemon daemon;
  Client client(daemon.endpoint(), settings(), callbacks());
  for (int i = 0; i < 3; ++i) {
    Peer peer = daemon.greet();
    EXPECT_EQ(peer.line(), "p");
    peer.say("nan\n0\n");
    EXPECT_TRUE(peer.closed());
  }
  const std::scoped_lock lock(mutex_);
  const auto times = [&](const std::string& text) {
    int found = 0;
    for (std::size_t at = notes_.find(text); at != std::string::npos; at = notes_.find(text, at + 1)) ++found;
    return found;
  };
  EXPECT_EQ(times("no answer to p: found 'nan'"), 1) << notes_;
  EXPECT_EQ(times("connected, rotator model"), 1) << notes_;
}

TEST_F(RotctlClient, ASilentDaemonHoldsNothingUpAndIsLeft) {
  Daemon daemon;
  LinkSettings quick = settings();
  quick.timeout = milliseconds(300);
  Client client(daemon.endpoint(), quick, callbacks());
  const Feeder feeder(client);  // take() returns, or the test never ends
  Peer peer = daemon.greet();
  EXPECT_EQ(next_position(peer), "P 100.0000 45.0000");
  EXPECT_EQ(peer.line(), "");  // nothing more is asked; then it is left
  EXPECT_TRUE(told("no answer to P within 0.3 s; tries again"));
  Peer again = daemon.greet();
  EXPECT_EQ(next_position(again), "P 100.0000 45.0000");
}

TEST_F(RotctlClient, ARotatorThatMovesIsStoppedWhenTheProgramEnds) {
  Daemon daemon;
  std::optional<Client> client(std::in_place, daemon.endpoint(), settings(), callbacks());
  std::optional<Feeder<Client>> feeder(std::in_place, *client);
  Peer peer = daemon.greet();
  EXPECT_EQ(next_position(peer), "P 100.0000 45.0000");
  feeder.reset();
  std::thread end([&] { client.reset(); });
  EXPECT_EQ(peer.line(), "S");
  peer.say("RPRT 0\nRPRT 0\n");
  EXPECT_TRUE(peer.closed());
  end.join();
  EXPECT_TRUE(told("stopped"));
}

class RotctlServer : public testing::Test {
 protected:
  static ServerSettings settings() {
    return {.endpoint = {"127.0.0.1", 0},
            .travel = {-270 * deg, 270 * deg, 0, 90 * deg},
            .ahead = milliseconds(100),
            .info = "Downrange"};
  }
  static Peer connect(const Server& server) {
    std::string why;
    const Wake never;
    Descriptor socket = connect_to(server.endpoint(), long_wait, never, why);
    EXPECT_TRUE(socket) << why;
    return Peer(std::move(socket));
  }
  static std::function<void(const std::string&)> quiet() {
    return [](const std::string&) {};
  }
};

TEST_F(RotctlServer, SeveralClientsWhileCommandsHoldAndNoLonger) {
  Server server(settings(), quiet());
  std::vector<Peer> clients;
  clients.reserve(10);
  for (int i = 0; i < 10; ++i) clients.push_back(connect(server));
  {
    const Feeder feeder(server);
    for (Peer& client : clients) {
      std::string first;
      do {  // until the first command is there
        client.say("p\n");
        first = client.line();
      } while (first == "RPRT -11");
      EXPECT_EQ(first, "100.0000");
      EXPECT_EQ(client.line(), "45.0000");
    }
  }
  std::this_thread::sleep_for(std::chrono::milliseconds(250));  // the last command's validity, and some
  for (Peer& client : clients) {
    client.say("p\n");
    EXPECT_EQ(client.line(), "RPRT -11");
  }
}

TEST_F(RotctlServer, EndlessAndSlowLinesEndTheirConnectionAndNoOther) {
  ServerSettings s = settings();
  s.patience.line = milliseconds(200);
  Server server(s, quiet());
  Peer good = connect(server);
  Peer endless = connect(server);
  Peer slow = connect(server);
  endless.say(std::string(1'000, 'p'));
  EXPECT_EQ(endless.line(), "RPRT -1");
  EXPECT_TRUE(endless.closed());
  slow.say("p");
  EXPECT_TRUE(slow.closed());
  good.say("_\n");
  EXPECT_EQ(good.line(), "Downrange");
}

TEST_F(RotctlServer, AClientThatReadsNothingIsNotListenedToAndLosesNothing) {
  Server server(settings(), quiet());
  Peer deaf = connect(server);
  std::string questions;
  for (int chunks = 0; questions.empty() && chunks < 1'000; ++chunks) {
    for (int i = 0; i < 10'000; ++i) questions += "\\dump_state\n";
    deaf.say_some(questions);
  }
  EXPECT_FALSE(questions.empty());  // the kernel's buffers are full, and ours do not grow
  Peer good = connect(server);
  good.say("_\n");
  EXPECT_EQ(good.line(), "Downrange");
  // Whole answers, once it reads them.
  questions += "_\n";
  std::string line;
  for (std::uint64_t n = 0; line != "Downrange"; ++n) {
    deaf.say_some(questions);
    line = deaf.line();
    if (line == "Downrange") {
      EXPECT_EQ(n % 9, 0u);
    } else {
      ASSERT_EQ(line == "done", n % 9 == 8) << n << ": " << line;
    }
    ASSERT_FALSE(line.empty());
  }
}

TEST_F(RotctlServer, MoreClientsThanThereIsRoomForAreTurnedAway) {
  ServerSettings s = settings();
  s.most_clients = 2;
  std::atomic<int> notes = 0;
  Server server(s, [&](const std::string&) { ++notes; });
  Peer one = connect(server);
  one.say("_\n");
  EXPECT_EQ(one.line(), "Downrange");
  {
    Peer two = connect(server);
    two.say("_\n");
    EXPECT_EQ(two.line(), "Downrange");
    for (int i = 0; i < 3; ++i) EXPECT_TRUE(connect(server).closed());
    EXPECT_EQ(notes, 1);
    one.say("_\n");
    EXPECT_EQ(one.line(), "Downrange");
  }
  // Room again, once the server has noticed.
  std::string line;
  for (int i = 0; i < 1'000 && line.empty(); ++i) {
    Peer three = connect(server);
    three.say("_\n");
    line = three.line();
  }
  EXPECT_EQ(line, "Downrange");
}

TEST_F(RotctlServer, APortThatIsTakenIsSaid) {
  const Server server(settings(), quiet());
  ServerSettings s = settings();
  s.endpoint = server.endpoint();
  try {
    const Server second(s, quiet());
    FAIL() << "two listen on one port";
  } catch (const std::runtime_error& error) {
    EXPECT_EQ(error.what(), to_string(s.endpoint) + ": cannot be listened on: Address already in use");
  }
}

}  // namespace
}  // namespace downrange::rotctl
