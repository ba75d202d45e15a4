#pragma once
/// Are two archives' records the same, bit for bit?

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace downrange::archive {

/// The first message of a topic in which two archives differ.
struct Difference {
  std::uint64_t index = 0;     ///< 0: the first message of the topic
  std::uint64_t log_time = 0;  ///< ns since 1970 UTC, of that message
  std::string what;
};

struct TopicComparison {
  std::string topic;
  std::uint64_t count_a = 0;
  std::uint64_t count_b = 0;
  std::optional<Difference> first;
};

struct CompareReport {
  std::vector<TopicComparison> topics;

  /// Nothing differs, and something was there to compare.
  [[nodiscard]] bool identical() const;
};

/// Compares log time, publish time and payload bytes of the messages of each topic, in order. The message sequence is
/// left out: it counts the events of a node, which differ where stages are split over nodes.
/// No topics: those of the engine's results. Throws ArchiveError where a file is damaged or cut off, or has messages of
/// channels that it does not declare.
[[nodiscard]] CompareReport compare(const std::filesystem::path& a, const std::filesystem::path& b,
                                    const std::vector<std::string>& topics = {});

}  // namespace downrange::archive
