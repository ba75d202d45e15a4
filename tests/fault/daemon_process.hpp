#pragma once
/// downranged as a child process, with the service manager's side of its notify socket.

#include <fcntl.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <chrono>
#include <csignal>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <functional>
#include <optional>
#include <source_dir.hpp>
#include <sstream>
#include <stdexcept>
#include <string>
#include <thread>
#include <utility>
#include <vector>

namespace downrange::test {

inline const std::filesystem::path source_dir = DOWNRANGE_SOURCE_DIR;
inline const std::filesystem::path naro = source_dir / "config/naro.toml";

/// Generous: only a fault lets a test wait that long.
inline constexpr std::chrono::seconds patience{60};

/// Whether `condition` came true before patience ended.
inline bool eventually(const std::function<bool()>& condition) {
  const auto end = std::chrono::steady_clock::now() + patience;
  while (!condition()) {
    if (std::chrono::steady_clock::now() > end) return false;
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
  }
  return true;
}

inline std::string read_text(const std::filesystem::path& file) {
  std::ostringstream text;
  text << std::ifstream(file, std::ios::binary).rdbuf();
  return text.str();
}

/// A folder of its own, removed at the end.
class Folder {
 public:
  Folder() {
    std::string name = (std::filesystem::temp_directory_path() / "downrange-daemon-XXXXXX").string();
    if (mkdtemp(name.data()) == nullptr) throw std::runtime_error("mkdtemp failed");
    path_ = name;
  }
  ~Folder() { std::filesystem::remove_all(path_); }
  Folder(const Folder&) = delete;
  Folder& operator=(const Folder&) = delete;
  [[nodiscard]] const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
};

/// The service manager's end of NOTIFY_SOCKET.
class NotifySocket {
 public:
  explicit NotifySocket(const std::filesystem::path& path) : path_(path.string()) {
    fd_ = socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    std::strncpy(address.sun_path, path_.c_str(), sizeof(address.sun_path) - 1);
    if (fd_ < 0 || bind(fd_, reinterpret_cast<sockaddr*>(&address), sizeof(address)) != 0) {
      throw std::runtime_error("notify socket: " + std::string(std::strerror(errno)));
    }
  }
  ~NotifySocket() { close(fd_); }
  NotifySocket(const NotifySocket&) = delete;
  NotifySocket& operator=(const NotifySocket&) = delete;

  [[nodiscard]] const std::string& path() const { return path_; }
  /// How often a line has been received so far.
  [[nodiscard]] int count(const std::string& line) {
    std::array<char, 4096> message{};
    ssize_t size = 0;
    while ((size = recv(fd_, message.data(), message.size(), 0)) > 0) {
      std::istringstream lines(std::string(message.data(), static_cast<std::size_t>(size)));
      for (std::string l; std::getline(lines, l);) lines_.push_back(l);
    }
    return static_cast<int>(std::count(lines_.begin(), lines_.end(), line));
  }

 private:
  std::string path_;
  int fd_ = -1;
  std::vector<std::string> lines_;
};

class Daemon {
 public:
  struct Setup {
    std::vector<std::pair<std::string, std::string>> environment;
    std::optional<std::pair<int, rlim_t>> limit;  ///< resource and its limit
  };

  Daemon(const std::filesystem::path& folder, const std::vector<std::string>& arguments, const Setup& setup = {})
      : log_(folder / "daemon.log") {
    std::vector<std::string> words{DOWNRANGED};
    words.insert(words.end(), arguments.begin(), arguments.end());
    std::vector<char*> argv;
    for (std::string& word : words) argv.push_back(word.data());
    argv.push_back(nullptr);
    pid_ = fork();
    if (pid_ < 0) throw std::runtime_error("fork failed");
    if (pid_ > 0) return;
    const int log = open(log_.c_str(), O_CREAT | O_WRONLY | O_APPEND, 0600);
    dup2(log, STDOUT_FILENO);
    dup2(log, STDERR_FILENO);
    unsetenv("JOURNAL_STREAM");
    unsetenv("NOTIFY_SOCKET");
    for (const auto& [name, value] : setup.environment) setenv(name.c_str(), value.c_str(), 1);
    if (setup.limit) {
      const rlimit limit{setup.limit->second, setup.limit->second};
      setrlimit(static_cast<__rlimit_resource>(setup.limit->first), &limit);
    }
    execv(argv[0], argv.data());
    _exit(127);
  }
  ~Daemon() {
    if (pid_ <= 0) return;
    kill(pid_, SIGKILL);
    waitpid(pid_, nullptr, 0);
  }
  Daemon(const Daemon&) = delete;
  Daemon& operator=(const Daemon&) = delete;

  /// Nothing once it has ended: a process id of -1 would mean every process.
  void signal(int number) const {
    if (pid_ > 0) kill(pid_, number);
  }
  [[nodiscard]] bool running() {
    poll();
    return pid_ > 0;
  }
  /// Exit code, or minus the signal that killed it; nothing while it runs after all patience.
  [[nodiscard]] std::optional<int> wait() {
    if (!eventually([this] { return !running(); })) return std::nullopt;
    return result_;
  }
  [[nodiscard]] std::string log() const { return read_text(log_); }
  [[nodiscard]] bool logs(const std::string& text) const {
    return eventually([&] { return log().find(text) != std::string::npos; });
  }

 private:
  void poll() {
    int status = 0;
    if (pid_ <= 0 || waitpid(pid_, &status, WNOHANG) != pid_) return;
    result_ = WIFEXITED(status) ? WEXITSTATUS(status) : -WTERMSIG(status);
    pid_ = -1;
  }

  std::filesystem::path log_;
  pid_t pid_ = -1;
  int result_ = 0;
};

}  // namespace downrange::test
