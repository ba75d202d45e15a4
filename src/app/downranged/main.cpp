/// downranged: the tracking service.

#include <spdlog/spdlog.h>

#include <string>

#include "config/load.hpp"
#include "logging.hpp"
#include "notify.hpp"
#include "options.hpp"
#include "service.hpp"
#include "signals.hpp"

namespace downrange::app {
namespace {

void announce(const config::ServiceConfig& config) {
  spdlog::info("downranged {}: node {} of range {}, DDS domain {}, configuration {}", DOWNRANGE_VERSION,
               config.node.id.view(), config.range.name.view(), config.dds.domain, config.hash.substr(0, 12));
  const std::string status = std::string("range ") + config.range.name.c_str() + ", node " + config.node.id.c_str();
  notify_ready(status);
}

/// Applies the keys that may change in flight, and names those that need a restart.
void reload(const Options& options, config::ServiceConfig& running, Logging& logging) {
  notify_reloading();
  try {
    const config::ServiceConfig wanted = config::load(options.config, options.overrides);
    config::require_dds(wanted);
    running.log.level = wanted.log.level;
    logging.set_level(wanted.log.level);
    const std::vector<std::string> need_restart = config::differences(running, wanted);
    for (const std::string& key : need_restart) spdlog::warn("reload: {} changes only with a restart", key);
    spdlog::info("reload: done, {} changed keys need a restart", need_restart.size());
  } catch (const config::ConfigError& error) {
    for (const config::Problem& problem : error.problems()) spdlog::error("reload: {}", problem.to_string());
    spdlog::error("reload: refused, the running configuration stays");
  }
  announce(running);
}

int run(const Signals& signals, const Options& options) {
  config::ServiceConfig config = config::load(options.config, options.overrides);
  config::require_dds(config);
  if (options.check) return 0;
  Logging logging(config.log);
  for (const config::Problem& warning : config.warnings) spdlog::warn("configuration: {}", warning.to_string());
  Service service(config, [&signals] { signals.service_failed(); });
  const Watchdog watchdog(service.progress());
  announce(config);

  Wake wake = signals.wait();
  for (; wake == Wake::Reload; wake = signals.wait()) reload(options, config, logging);

  notify_stopping();
  service.stop();
  if (service.failure()) throw std::runtime_error(*service.failure());
  spdlog::info("stopped");
  return 0;
}

}  // namespace
}  // namespace downrange::app

int main(int argc, char** argv) {
  using namespace downrange;
  const app::Signals signals;  // before any thread starts
  app::Options options;
  if (const auto code = app::parse_command_line(argc, argv, options)) return *code;
  try {
    return app::run(signals, options);
  } catch (const config::ConfigError& error) {
    app::print_errors(error.what());
    return app::exit_misconfigured;
  } catch (const std::exception& error) {
    app::print_errors(std::string("downranged: ") + error.what());
    return app::exit_failed;
  }
}
