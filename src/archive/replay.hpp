#pragma once
/// An archive as a source of events: what the engine consumed, in the order it consumed it.

#include <archive/reader.hpp>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

namespace downrange::archive {

/// The events of an archive do not stand in the order in which they were received.
class OrderError : public ArchiveError {
 public:
  using ArchiveError::ArchiveError;
};

struct EventOrder {
  /// Reads the whole archive first and gives its events in the order they were received; equal times by the count of
  /// consumed events where the archive has it, else as on the range clock.
  bool sort = false;
  /// What an event may be behind the newest before it. The engine runs its ticks up to each event and admits none from
  /// before the last tick, so in an archive of its own that is less than a tick; none is longer than a second.
  Duration slack = milliseconds(1000);
};

/// Streams the events of an archive. To replay: hand each to the engine, then advance it to last_tick().
class EventSource {
 public:
  /// Throws ArchiveError when the file cannot be opened or is not MCAP.
  explicit EventSource(const std::filesystem::path& path, EventOrder order = {});

  /// The next event; nothing at the end. Throws ArchiveError where the file is damaged, for an input that is no legal
  /// record or, at the end, messages of undeclared channels (to go on without them would not be the same flight), and
  /// for a silence of more than `max_silence`; OrderError for events out of order, unless they are to be sorted.
  [[nodiscard]] std::optional<Event> next();

  /// Longer than any flight or standby: a wrong clock, and years of ticks to run.
  static constexpr Duration max_silence = Duration{std::int64_t{30} * 86'400'000'000'000};

  /// Known once next() has ended, where the archive was closed in order.
  [[nodiscard]] std::optional<Time> last_tick() const { return last_tick_; }
  [[nodiscard]] const std::optional<Truncation>& truncated() const { return reader_.truncated(); }
  [[nodiscard]] Skipped skipped() const { return reader_.skipped(); }
  /// Share of the file read, 0 to 1.
  [[nodiscard]] double progress() const { return reader_.raw().progress(); }

  /// Truth records that next() passes go here.
  void on_truth(std::function<void(const Truth&)> handler) { on_truth_ = std::move(handler); }

 private:
  struct Place {
    Event event;
    std::uint32_t sequence = 0;  ///< counts consumed events in an archive of ours
  };
  std::optional<Place> next_in_file();
  std::optional<Place> next_sorted();
  void read_sorted();
  void judge(const Event& event);

  std::filesystem::path path_;
  EventOrder order_;
  Reader reader_;
  std::optional<Time> newest_;  ///< received, of the events so far
  std::optional<Time> last_tick_;
  std::function<void(const Truth&)> on_truth_;
  // To be sorted: all of the archive, newest first.
  bool read_ = false;
  std::vector<Place> events_;
  std::vector<Truth> truths_;
};

/// Throws ArchiveError, which says what the archive holds instead, when it holds no event for the engine.
void require_events(const std::filesystem::path& path);

/// The attachment of this name, e.g. "config.toml"; nothing when the file has none. Reads only as far as needed.
[[nodiscard]] std::optional<std::string> read_attachment(const std::filesystem::path& path, std::string_view name);

}  // namespace downrange::archive
