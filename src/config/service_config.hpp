#pragma once
/// Everything a node is told at its start: the range it serves and how it runs there. Filled by config::load.

#include <cstdint>
#include <downrange/geo/name.hpp>
#include <downrange/geo/time.hpp>
#include <downrange/stage/engine.hpp>
#include <downrange/stage/range_config.hpp>
#include <filesystem>
#include <string>
#include <vector>

#include "config/problem.hpp"

namespace downrange::config {

enum class ClockMode : std::uint8_t { Wall, Range };
enum class Compression : std::uint8_t { None, Lz4, Zstd };
enum class LogLevel : std::uint8_t { Trace, Debug, Info, Warning, Error };
enum class Console : std::uint8_t { Auto, Plain, Journal, Off };

struct ClockConfig {
  ClockMode mode = ClockMode::Wall;
  Duration step_timeout = milliseconds(10'000);  ///< range clock: a step's samples must be there by then (wall time)
};

struct NodeConfig {
  Name id = "downranged";
  int strength = 10;  ///< ownership strength of the output topics; the highest one alive is heard
  StageSet stages;
  std::vector<Name> sources;  ///< ingest accepts these only; empty: all
  int queue = 1024;           ///< inputs of one source waiting for the engine
};

struct DdsConfig {
  int domain = 0;
  std::filesystem::path profiles;  ///< XML file of QoS profiles, absolute; empty: the file has no [dds]
  std::vector<Name> ingest_nodes;  ///< nodes whose observations a node without ingest reads
  std::vector<std::string> peers;  ///< addresses and networks that take part, for firewalls; empty: not told
};

struct ArchiveConfig {
  bool enabled = false;
  std::filesystem::path directory;  ///< absolute; or a file that ends in .mcap
  Compression compression = Compression::Zstd;
  bool outputs = true;  ///< results as well as what the engine consumed
};

struct LogConfig {
  LogLevel level = LogLevel::Info;
  Console console = Console::Auto;  ///< auto: colour on a terminal, priorities under journald
  std::filesystem::path file;       ///< absolute; empty: none
};

/// How the rotator daemon of one antenna is reached (`downrange rotctl`). Beside the range: the engine knows nothing of
/// it.
struct RotctlConfig {
  Name antenna;  ///< that the table belongs to
  std::string host = "127.0.0.1";
  int port = 4533;
  double rate_hz = 5;                     ///< positions a second, as many as the rotator takes
  Duration timeout = milliseconds(2000);  ///< an answer later than this: the connection is given up
};

struct ServiceConfig {
  RangeConfig range;
  std::vector<RotctlConfig> rotctl;  ///< of the antennas that have one
  ClockConfig clock;
  NodeConfig node;
  DdsConfig dds;
  ArchiveConfig archive;
  LogConfig log;

  std::string text;  ///< the configuration in force, as TOML that loads again: what an archive attaches
  std::string hash;  ///< SHA-256 of `text`, 64 hexadecimal digits

  std::filesystem::path file;         ///< that it was read from, as it was named
  std::vector<Problem> warnings;      ///< allowed, but hardly meant: for a person to look at
  std::vector<Problem> bus_problems;  ///< of [dds], for whoever talks on the bus: `require_dds`
};

}  // namespace downrange::config
