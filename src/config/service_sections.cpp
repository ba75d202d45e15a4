#include "config/sections.hpp"

#include <arpa/inet.h>

#include <array>
#include <charconv>

#include "config/section.hpp"

namespace downrange::config {
namespace {

/// Which stages run, as a list of their names.
Key<NodeConfig> stages_key() {
  static const std::vector<std::pair<std::string, bool StageSet::*>> names{{"ingest", &StageSet::ingest},
                                                                           {"align", &StageSet::align},
                                                                           {"fuse", &StageSet::fuse},
                                                                           {"slave", &StageSet::slave}};
  return {{"stages", R"(a list out of "ingest", "align", "fuse", "slave")", optional,
           "stages this node runs; without ingest it reads the observations of other nodes"},
          [](NodeConfig& node, const toml::node& value) {
            const auto texts = read_texts(value);
            if (!texts || texts->empty()) return false;
            StageSet stages{false, false, false, false};
            for (const std::string& text : *texts) {
              const auto known = std::ranges::find(names, text, &std::pair<std::string, bool StageSet::*>::first);
              if (known == names.end()) return false;
              stages.*known->second = true;
            }
            node.stages = stages;
            return true;
          },
          [](const NodeConfig& node) {
            std::vector<std::string> texts;
            for (const auto& [text, member] : names) {
              if (node.stages.*member) texts.push_back(text);
            }
            return show_texts(texts);
          }};
}

/// An IPv4 or IPv6 address, or with "/24" behind it a network.
bool is_network(const std::string& text) {
  const std::size_t slash = text.find('/');
  const std::string address = text.substr(0, slash);
  std::array<unsigned char, sizeof(in6_addr)> bytes{};
  const bool v4 = inet_pton(AF_INET, address.c_str(), bytes.data()) == 1;
  if (!v4 && inet_pton(AF_INET6, address.c_str(), bytes.data()) != 1) return false;
  if (slash == std::string::npos) return true;
  const char* const end = text.data() + text.size();
  int prefix = 0;
  const auto [stop, error] = std::from_chars(text.data() + slash + 1, end, prefix);
  return error == std::errc() && stop == end && prefix >= 1 && prefix <= (v4 ? 32 : 128);
}

Key<DdsConfig> peers_key() {
  return {{"peers", R"(a list of IP addresses and networks, as "192.0.2.7", "192.0.2.0/24", "2001:db8::/64")", optional,
           "who takes part: `downrange firewall` makes rules of it"},
          [](DdsConfig& dds, const toml::node& value) {
            auto texts = read_texts(value);
            if (!texts || !std::ranges::all_of(*texts, is_network)) return false;
            dds.peers = std::move(*texts);
            return true;
          },
          [](const DdsConfig& dds) { return show_texts(dds.peers); }};
}

}  // namespace

Section clock_section() {
  using C = ClockConfig;
  return single<C>(
      "clock", "Where time comes from.", [](ServiceConfig& c) -> C& { return c.clock; },
      {
          choice<C, ClockMode>("mode", at(&C::mode), {{"wall", ClockMode::Wall}, {"range", ClockMode::Range}}, optional,
                               "wall: this node's UTC clock; range: topic range/clock (simulation, replay over DDS)"),
          span("step_timeout_ms", at(&C::step_timeout), {10, 600'000}, optional,
               "range clock: a step whose samples are not all there by then stops the flight"),
      });
}

Section node_section() {
  using N = NodeConfig;
  return single<N>("node", "This process among others.", [](ServiceConfig& c) -> N& { return c.node; },
                   {
                       id("id", at(&N::id), optional, "node_id on the topics; each process of a range has its own"),
                       integer("strength", at(&N::strength), {0, 1'000'000}, optional,
                               "ownership strength of the outputs: consumers hear the strongest node alive"),
                       stages_key(),
                       ids("sources", at(&N::sources), optional,
                           "radars, trackers and stations that ingest accepts here; empty: all"),
                       integer("queue", at(&N::queue), {16, 100'000}, optional,
                               "inputs of one source that may wait; more push out its oldest"),
                   });
}

Section dds_section() {
  using D = DdsConfig;
  Section section = single<D>(
      "dds", "The data bus; not needed by replay, check, report and experiment.",
      [](ServiceConfig& c) -> D& { return c.dds; },
      {
          integer("domain", at(&D::domain), {0, 232}, optional, "DDS domain"),
          path("profiles", at(&D::profiles), required, "XML file of QoS profiles, relative to this file"),
          ids("ingest_nodes", at(&D::ingest_nodes), optional, "nodes whose observations a node without ingest reads"),
          peers_key(),
      });
  section.optional = true;
  return section;
}

Section archive_section() {
  using A = ArchiveConfig;
  return single<A>(
      "archive", "The flight recorder.", [](ServiceConfig& c) -> A& { return c.archive; },
      {
          flag("enabled", at(&A::enabled), optional, "record every flight"),
          path("directory", at(&A::directory), optional,
               "folder of the archives, or one file *.mcap, relative to this file"),
          choice<A, Compression>("compression", at(&A::compression),
                                 {{"none", Compression::None}, {"lz4", Compression::Lz4}, {"zstd", Compression::Zstd}},
                                 optional, "compression of the archive's chunks"),
          flag("outputs", at(&A::outputs), optional, "record results too, not just what the engine consumed"),
      });
}

Section log_section() {
  using L = LogConfig;
  return single<L>("log", "Messages for people.", [](ServiceConfig& c) -> L& { return c.log; },
                   {
                       choice<L, LogLevel>("level", at(&L::level),
                                           {{"trace", LogLevel::Trace},
                                            {"debug", LogLevel::Debug},
                                            {"info", LogLevel::Info},
                                            {"warning", LogLevel::Warning},
                                            {"error", LogLevel::Error}},
                                           optional, "least severe messages shown"),
                       choice<L, Console>(
                           "console", at(&L::console),
                           {{"auto", Console::Auto},
                            {"plain", Console::Plain},
                            {"journal", Console::Journal},
                            {"off", Console::Off}},
                           optional, "standard error: auto is coloured on a terminal, journal adds syslog priorities"),
                       path("file", at(&L::file), optional, "log file besides, relative to this file; \"\": none"),
                   });
}

}  // namespace downrange::config
