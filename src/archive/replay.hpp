#pragma once
/// An archive as a source of events: what the engine consumed, in the order it consumed it.

#include <archive/reader.hpp>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>

namespace downrange::archive {

/// Streams the events of an archive. To replay: hand each to the engine, then advance it to last_tick().
class EventSource {
 public:
  /// Throws ArchiveError when the file cannot be opened or is not MCAP.
  explicit EventSource(const std::filesystem::path& path);

  /// The next event; nothing at the end. Throws ArchiveError where the file is damaged, and for an input that is no
  /// legal record: to go on without it would not be the same flight.
  [[nodiscard]] std::optional<Event> next();

  /// Known once next() has ended, where the archive was closed in order.
  [[nodiscard]] std::optional<Time> last_tick() const { return last_tick_; }
  [[nodiscard]] const std::optional<Truncation>& truncated() const { return reader_.truncated(); }
  [[nodiscard]] Skipped skipped() const { return reader_.skipped(); }
  /// Share of the file read, 0 to 1.
  [[nodiscard]] double progress() const { return reader_.raw().progress(); }

  /// Truth records that next() passes go here.
  void on_truth(std::function<void(const Truth&)> handler) { on_truth_ = std::move(handler); }

 private:
  std::filesystem::path path_;
  Reader reader_;
  std::optional<Time> last_tick_;
  std::function<void(const Truth&)> on_truth_;
};

/// The attachment of this name, e.g. "config.toml"; nothing when the file has none. Reads only as far as needed.
[[nodiscard]] std::optional<std::string> read_attachment(const std::filesystem::path& path, std::string_view name);

}  // namespace downrange::archive
