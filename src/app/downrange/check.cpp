#include <iostream>

#include "command.hpp"

namespace downrange::app {

void add_check(CLI::App& app, Run& run) {
  struct Options {
    std::string file;
    bool keys = false;
  };
  auto options = std::make_shared<Options>();
  CLI::App* command = app.add_subcommand("check", "Check a range's configuration without starting anything");
  auto* file = command->add_option("FILE", options->file, "Configuration, e.g. config/naro.toml");
  command->add_flag("--keys", options->keys, "Print every key with its type, default and allowed values")
      ->excludes(file);
  command->callback([options, &run] {
    run = [options] {
      if (options->keys) {
        std::cout << config::key_reference();
        return exit_ok;
      }
      if (options->file.empty()) throw CLI::RequiredError("FILE");
      const auto problems = config::check(options->file);
      for (const auto& problem : problems) std::cout << problem.to_string() << '\n';
      if (!problems.empty()) {
        std::cout << options->file << ": " << problems.size() << (problems.size() == 1 ? " problem\n" : " problems\n");
        return exit_usage;
      }
      const auto c = config::load(options->file);
      for (const auto& warning : c.warnings) std::cerr << "warning: " << warning.to_string() << '\n';
      std::cout << options->file << ": valid. Range " << c.range.name.view() << ", " << c.range.radars.size()
                << " radars, " << c.range.angle_sensors.size() << " angle sensors, " << c.range.telemetry.size()
                << " telemetry stations, " << c.range.antennas.size() << " antennas; hash " << c.hash.substr(0, 16)
                << '\n';
      return exit_ok;
    };
  });
}

}  // namespace downrange::app
