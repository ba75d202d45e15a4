#include <archive/compare.hpp>
#include <iomanip>
#include <iostream>
#include <text/printable.hpp>

#include "command.hpp"

namespace downrange::app {

void add_diff(CLI::App& app, Run& run) {
  struct Options {
    std::string a;
    std::string b;
    std::vector<std::string> topics;
  };
  auto options = std::make_shared<Options>();
  CLI::App* command = app.add_subcommand("diff", "Are the results in two archives the same, bit for bit?");
  command->add_option("A", options->a, "Archive (.mcap)")->required();
  command->add_option("B", options->b, "Archive (.mcap)")->required();
  command->add_option("--topic", options->topics, "Compare these topics only (repeatable); default: all results");
  command->footer("Exit code 0: identical, 1: not. Compared are times and payload bytes, message by message.");
  command->callback([options, &run] {
    run = [options] {
      const auto report = archive::compare(options->a, options->b, options->topics);
      for (const auto& topic : report.topics) {
        std::cout << std::left << std::setw(24) << text::printable(topic.topic) << std::right << std::setw(9)
                  << topic.count_a << std::setw(9) << topic.count_b << "  ";
        if (topic.first)
          std::cout << "differs at message " << topic.first->index << ": " << topic.first->what << '\n';
        else
          std::cout << "same\n";
      }
      std::cout << (report.identical() ? "identical\n" : "NOT identical\n");
      return report.identical() ? exit_ok : exit_failed;
    };
  });
}

}  // namespace downrange::app
