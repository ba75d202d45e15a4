#pragma once
/// Which nodes of a range have acknowledged one order or mark, told from their statuses.

#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <map>
#include <mutex>
#include <optional>
#include <string>

#include "dds/service_status.hpp"

namespace downrange::app {

/// Filled by the middleware's thread.
class NodeAnswers {
 public:
  /// Of the message of this input topic (its place in Inputs), sender and sequence.
  /// `slaves`: it is about an antenna, a matter of the nodes that point antennas alone.
  NodeAnswers(std::size_t topic, const Name& sender, std::uint64_t sequence, bool slaves = false)
      : topic_(topic), sender_(sender), sequence_(sequence), slaves_(slaves) {}

  void add(const dds::ServiceStatus& status);

  /// Whether a node was heard, waiting at most `timeout`.
  [[nodiscard]] bool wait_for_nodes(std::chrono::milliseconds timeout);
  /// Whether every node heard has answered, waiting at most `timeout`.
  [[nodiscard]] bool wait_for_all(std::chrono::milliseconds timeout);

  /// Every node that it concerns has it in force, and there is one.
  [[nodiscard]] bool all_in_force() const;
  /// A line for each node.
  [[nodiscard]] std::string text() const;

 private:
  struct Node {
    bool concerned = true;
    std::optional<dds::Acknowledgement> answer{};  ///< none: it has not answered
  };

  [[nodiscard]] bool all_answered_locked() const;

  const std::size_t topic_;
  const Name sender_;
  const std::uint64_t sequence_;
  const bool slaves_;
  mutable std::mutex mutex_;
  std::condition_variable heard_;
  std::map<Name, Node> nodes_;
};

}  // namespace downrange::app
