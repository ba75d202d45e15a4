#include "logging.hpp"

#include <spdlog/async.h>
#include <spdlog/pattern_formatter.h>
#include <spdlog/sinks/basic_file_sink.h>
#include <spdlog/sinks/stdout_color_sinks.h>
#include <spdlog/sinks/stdout_sinks.h>
#include <spdlog/spdlog.h>
#include <unistd.h>

#include <cstdlib>
#include <iostream>
#include <sstream>
#include <stdexcept>
#include <string>
#include <text/printable.hpp>

namespace downrange::app {
namespace {

constexpr std::size_t queue_size = 8192;
constexpr const char* time_pattern = "%Y-%m-%dT%H:%M:%S.%eZ %^%l%$ %v";

/// The syslog priority that journald reads off the start of a line.
class Priority final : public spdlog::custom_flag_formatter {
 public:
  void format(const spdlog::details::log_msg& message, const std::tm&, spdlog::memory_buf_t& out) override {
    out.push_back(digit(message.level));
  }
  [[nodiscard]] std::unique_ptr<custom_flag_formatter> clone() const override { return std::make_unique<Priority>(); }

 private:
  static char digit(spdlog::level::level_enum level) {
    switch (level) {
      case spdlog::level::critical:
        return '2';
      case spdlog::level::err:
        return '3';
      case spdlog::level::warn:
        return '4';
      case spdlog::level::info:
        return '6';
      default:
        return '7';
    }
  }
};

/// The message, with what strangers' names could do to a terminal or a log written out.
class Message final : public spdlog::custom_flag_formatter {
 public:
  void format(const spdlog::details::log_msg& message, const std::tm&, spdlog::memory_buf_t& out) override {
    const std::string safe = text::printable({message.payload.data(), message.payload.size()});
    out.append(safe.data(), safe.data() + safe.size());
  }
  [[nodiscard]] std::unique_ptr<custom_flag_formatter> clone() const override { return std::make_unique<Message>(); }
};

bool under_journald() { return std::getenv("JOURNAL_STREAM") != nullptr && isatty(STDERR_FILENO) == 0; }

std::unique_ptr<spdlog::pattern_formatter> utc_formatter(const char* pattern) {
  auto formatter = std::make_unique<spdlog::pattern_formatter>(spdlog::pattern_time_type::utc);
  formatter->add_flag<Message>('v').set_pattern(pattern);
  return formatter;
}

spdlog::sink_ptr console_sink(config::Console console) {
  using config::Console;
  if (console == Console::Auto) {
    console = under_journald() ? Console::Journal : Console::Auto;
  }
  spdlog::sink_ptr sink;
  if (console == Console::Journal) {
    sink = std::make_shared<spdlog::sinks::stderr_sink_mt>();
    auto formatter = std::make_unique<spdlog::pattern_formatter>();
    formatter->add_flag<Priority>('*').add_flag<Message>('v').set_pattern("<%*>%v");  // journald stamps the time
    sink->set_formatter(std::move(formatter));
    return sink;
  }
  if (console == Console::Auto) {
    sink = std::make_shared<spdlog::sinks::stderr_color_sink_mt>();  // colour on a terminal only
  } else {
    sink = std::make_shared<spdlog::sinks::stderr_sink_mt>();
  }
  sink->set_formatter(utc_formatter(time_pattern));
  return sink;
}

spdlog::level::level_enum spdlog_level(config::LogLevel level) {
  switch (level) {
    case config::LogLevel::Trace:
      return spdlog::level::trace;
    case config::LogLevel::Debug:
      return spdlog::level::debug;
    case config::LogLevel::Info:
      return spdlog::level::info;
    case config::LogLevel::Warning:
      return spdlog::level::warn;
    case config::LogLevel::Error:
      return spdlog::level::err;
  }
  return spdlog::level::info;
}

}  // namespace

void print_errors(std::string_view lines) {
  std::istringstream stream{std::string(lines)};
  for (std::string line; std::getline(stream, line);)
    std::cerr << (under_journald() ? "<3>" : "") << text::printable(line) << '\n';
}

Logging::Logging(const config::LogConfig& config) {
  std::vector<spdlog::sink_ptr> sinks;
  if (config.console != config::Console::Off) sinks.push_back(console_sink(config.console));
  if (!config.file.empty()) {
    try {
      sinks.push_back(std::make_shared<spdlog::sinks::basic_file_sink_mt>(config.file.string()));
    } catch (const spdlog::spdlog_ex& error) {
      throw std::runtime_error("log.file: " + std::string(error.what()));
    }
    sinks.back()->set_formatter(utc_formatter(time_pattern));
  }
  spdlog::init_thread_pool(queue_size, 1);
  // A full queue loses its oldest line rather than hold up the engine.
  spdlog::set_default_logger(std::make_shared<spdlog::async_logger>(
      "downranged", sinks.begin(), sinks.end(), spdlog::thread_pool(), spdlog::async_overflow_policy::overrun_oldest));
  spdlog::flush_on(spdlog::level::info);
  set_level(config.level);
}

Logging::~Logging() { spdlog::shutdown(); }

void Logging::set_level(config::LogLevel level) { spdlog::set_level(spdlog_level(level)); }

}  // namespace downrange::app
