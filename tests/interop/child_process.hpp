#pragma once
/// A program started by a test: its output line by line, and its end.

#include <fcntl.h>
#include <signal.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstdio>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

namespace downrange {

class ChildProcess {
 public:
  /// Standard output is read by lines(); `environment` as "NAME=value", beside the test's own.
  explicit ChildProcess(std::vector<std::string> command, const std::vector<std::string>& environment = {}) {
    int ends[2];
    if (::pipe2(ends, O_CLOEXEC) != 0) throw std::runtime_error("no pipe");
    posix_spawn_file_actions_t actions;
    ::posix_spawn_file_actions_init(&actions);
    ::posix_spawn_file_actions_adddup2(&actions, ends[1], STDOUT_FILENO);
    std::vector<char*> arguments;
    for (std::string& argument : command) arguments.push_back(argument.data());
    arguments.push_back(nullptr);
    std::vector<char*> variables;
    for (const std::string& variable : environment) variables.push_back(const_cast<char*>(variable.c_str()));
    for (char** variable = environ; *variable != nullptr; ++variable) variables.push_back(*variable);
    variables.push_back(nullptr);
    const int error = ::posix_spawn(&pid_, arguments[0], &actions, nullptr, arguments.data(), variables.data());
    ::posix_spawn_file_actions_destroy(&actions);
    ::close(ends[1]);
    output_ = ::fdopen(ends[0], "r");
    if (error != 0) throw std::runtime_error("cannot start " + command[0]);
  }
  ~ChildProcess() {
    if (pid_ > 0) kill();
    std::fclose(output_);
  }
  ChildProcess(const ChildProcess&) = delete;
  ChildProcess& operator=(const ChildProcess&) = delete;

  /// As a crash of the machine would: no clean-up.
  void kill() {
    ::kill(pid_, SIGKILL);
    static_cast<void>(wait());
  }
  /// Exit status; -1 when a signal ended it.
  [[nodiscard]] int wait() {
    int status = 0;
    ::waitpid(pid_, &status, 0);
    pid_ = -1;
    return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
  }
  /// All lines until it closes its output.
  [[nodiscard]] std::vector<std::string> lines() {
    std::vector<std::string> result;
    while (auto next = line()) result.push_back(std::move(*next));
    return result;
  }
  /// The next line, waited for; nothing at the end.
  [[nodiscard]] std::optional<std::string> line() {
    char text[1024];
    if (std::fgets(text, sizeof text, output_) == nullptr) return std::nullopt;
    std::string line = text;
    if (line.ends_with('\n')) line.pop_back();
    return line;
  }

 private:
  pid_t pid_ = -1;
  std::FILE* output_ = nullptr;
};

}  // namespace downrange
