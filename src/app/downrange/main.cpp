/// downrange: the operator's and analyst's command.

#include <exception>
#include <iostream>

#include "command.hpp"
#include "text/printable.hpp"

int main(int argc, char** argv) {
  using namespace downrange::app;
  CLI::App app(
      "Launch-range tracking: check a range's configuration, simulate and replay flights, record, import, watch and\n"
      "judge them. The service itself is downranged.");
  app.require_subcommand(1);
  app.set_version_flag("--version", DOWNRANGE_VERSION);
  app.footer(
      "Exit code 0: done, 1: could not be done or a comparison failed, 2: command line or configuration, 3: done, but "
      "an\n"
      "archive read is cut off: what came before counted.\n"
      "Start here:  downrange check config/naro.toml    Every command: downrange COMMAND --help");
  Run run;
  add_check(app, run);
  add_simulate(app, run);
  add_replay(app, run);
  add_record(app, run);
  add_import(app, run);
  add_watch(app, run);
  add_operator(app, run);
  add_preflight(app, run);
  add_rotctl(app, run);
  add_rotctld(app, run);
  add_report(app, run);
  add_diff(app, run);
  add_experiment(app, run);
  add_firewall(app, run);
  try {
    app.parse(argc, argv);
    return run();
  } catch (const CLI::ParseError& e) {
    return app.exit(e) == 0 ? exit_ok : exit_usage;
  } catch (const downrange::config::ConfigError& e) {
    std::cerr << e.what() << '\n';
    return exit_usage;
  } catch (const std::exception& e) {
    std::cerr << "downrange: " << downrange::text::printable(e.what(), true, 10'000) << '\n';
    return exit_failed;
  }
}
