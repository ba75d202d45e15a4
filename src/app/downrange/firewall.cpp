#include <iostream>

#include "command.hpp"
#include "config/problem.hpp"

namespace downrange::app {
namespace {

/// RTPS 2.2, section 9.6.1.1: a domain's participants, of whatever vendor, listen on the ports from here ...
constexpr int first_port(int domain) { return 7400 + 250 * domain; }
/// ... to here.
constexpr int last_port(int domain) { return first_port(domain) + 249; }

bool is_v6(const std::string& network) { return network.find(':') != std::string::npos; }

void print_set(const char* name, const char* type, const std::vector<std::string>& networks) {
  std::cout << "  set " << name << " {\n    type " << type << "\n    flags interval\n    auto-merge\n";
  for (std::size_t i = 0; i < networks.size(); ++i)
    std::cout << (i == 0 ? "    elements = { " : ", ") << networks[i] << (i + 1 == networks.size() ? " }\n" : "");
  std::cout << "  }\n";
}

void print_nftables(const config::ServiceConfig& config) {
  std::vector<std::string> v4;
  std::vector<std::string> v6;
  for (const std::string& peer : config.dds.peers) (is_v6(peer) ? v6 : v4).push_back(peer);
  const std::string ports = std::to_string(first_port(config.dds.domain)) + '-' +
                            std::to_string(std::min(last_port(config.dds.domain), 65'535));
  std::cout << "# Range " << config.range.name.view() << ", DDS domain " << config.dds.domain << ", out of "
            << config.file.string()
            << ".\n"
               "# Only the range's peers reach the domain's ports on this machine; all other traffic is left alone. "
               "Once more: it "
               "replaces\n"
               "# itself.\n"
               "table inet downrange\n"
               "delete table inet downrange\n"
               "table inet downrange {\n";
  print_set("peers4", "ipv4_addr", v4);
  print_set("peers6", "ipv6_addr", v6);
  std::cout << "  chain input {\n"
               "    type filter hook input priority filter; policy accept;\n"
               "    udp dport != "
            << ports
            << " accept\n"
               "    meta l4proto != udp accept\n"
               "    iif lo accept\n"
               "    ip saddr @peers4 accept\n"
               "    ip6 saddr @peers6 accept\n"
               "    limit rate 1/second log prefix \"downrange, no peer: \"\n"
               "    counter drop\n"
               "  }\n"
               "}\n";
}

void print_systemd(const config::ServiceConfig& config) {
  std::cout
      << "# Range " << config.range.name.view() << ", out of " << config.file.string()
      << ".\n"
         "# In place of the networks that the unit allows: this machine, multicast (discovery), the range's peers.\n"
         "[Service]\n"
         "IPAddressDeny=any\n"
         "IPAddressAllow=\n"
         "IPAddressAllow=localhost multicast\n";
  for (const std::string& peer : config.dds.peers) std::cout << "IPAddressAllow=" << peer << '\n';
}

}  // namespace

void add_firewall(CLI::App& app, Run& run) {
  struct Options {
    DdsOptions dds;
    std::string format;
  };
  auto options = std::make_shared<Options>();
  CLI::App* command = app.add_subcommand("firewall", "Print rules that let only the range's peers (dds.peers) in");
  command->add_option("CONFIG", options->dds.config, "Configuration of the range")->required();
  command
      ->add_option("--for", options->format,
                   "nftables: rules for this machine's firewall; systemd: a drop-in for the service's unit")
      ->required()
      ->check(CLI::IsMember({"nftables", "systemd"}));
  options->dds.add_to(*command);
  command->callback([options, &run] {
    run = [options] {
      const config::ServiceConfig config = options->dds.load();
      config::require_dds(config);
      if (config.dds.peers.empty())
        throw config::ConfigError(
            {{config.file.string(), 0, "dds.peers",
              "none named: name the addresses or networks of the range's radars, stations, antennas, "
              "nodes and consoles"}});
      (options->format == "nftables" ? print_nftables : print_systemd)(config);
      return exit_ok;
    };
  });
}

}  // namespace downrange::app
