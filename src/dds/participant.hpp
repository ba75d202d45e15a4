#pragma once
/// One node's presence in a DDS domain, with the QoS profiles of the site.

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <set>
#include <stdexcept>
#include <string>
#include <vector>

#include <downrange/geo/name.hpp>

namespace downrange::dds {

/// Whose time the flight follows (INTERFACES: live, simulated and replayed flights).
enum class ClockMode : std::uint8_t { Wall, Range };

/// A broken environment: profiles file, domain, or an entity that DDS refuses. The text names the file, topic or
/// domain.
class DdsError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

struct ParticipantOptions {
  int domain = 0;                  ///< 0 to 232
  std::filesystem::path profiles;  ///< config/dds-qos.xml: a profile for every topic, named as the topic
  Name node;                       ///< name of the participant; acknowledgements, health and status carry it
  ClockMode clock = ClockMode::Wall;
};

/// Owns the DDS participant. Readers and writers refer to it and must be destroyed first; it must be destroyed before
/// `main` returns (the middleware's own clean-up at exit comes too late for secure participants).
class Participant {
 public:
  /// Throws DdsError: profiles missing, malformed or with an element that the middleware does not know; a topic
  /// without a profile; a domain that cannot be opened.
  explicit Participant(const ParticipantOptions& options);
  ~Participant();
  Participant(const Participant&) = delete;
  Participant& operator=(const Participant&) = delete;

  [[nodiscard]] const Name& node() const;
  [[nodiscard]] ClockMode clock() const;
  /// What the operator should know of how the domain was opened, e.g. that no network interface is up.
  [[nodiscard]] const std::vector<std::string>& notes() const;
  /// Others' readers and writers, there at this moment, that do not match this node's of the same topic; each in words:
  /// topic, whose and where from, policy or type, what is offered and what is asked.
  [[nodiscard]] std::vector<std::string> mismatches() const;

  class Impl;
  [[nodiscard]] Impl& impl() { return *impl_; }

 private:
  std::unique_ptr<Impl> impl_;
};

/// Tells each of Participant::mismatches() once for as long as it is there.
class NewMismatches {
 public:
  /// Those of `present` that were not there at the last call.
  [[nodiscard]] std::vector<std::string> among(const std::vector<std::string>& present);

 private:
  std::set<std::string> told_;
};

/// One line of the middleware's own log.
struct LogLine {
  bool error = false;  ///< else a warning: these only while entities are created
  std::string category;
  std::string text;
};

/// Where the middleware's own errors and warnings go, from a thread of the middleware; by default to standard error.
/// An empty function restores the default.
void set_log_sink(std::function<void(const LogLine&)> sink);

/// What one group of readers has seen.
struct ReadCounts {
  std::uint64_t samples = 0;       ///< handed to the callback
  std::uint64_t malformed = 0;     ///< dropped: an enumerator, size or name that the types do not allow
  std::uint64_t lost = 0;          ///< reported lost by the middleware
  std::uint64_t incompatible = 0;  ///< writers met whose QoS does not suit
  std::string last_malformed;      ///< topic and reason of the newest dropped sample
};

/// What one group of writers has done.
struct WriteCounts {
  std::uint64_t samples = 0;
  std::uint64_t failures = 0;      ///< writes refused by the middleware (history full, too many instances)
  std::uint64_t incompatible = 0;  ///< readers met whose QoS asks for more than is offered
  std::uint64_t deadlines = 0;     ///< deadlines missed
  std::string last_failure;        ///< topic and code of the newest failed write
};

}  // namespace downrange::dds
