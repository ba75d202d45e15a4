#include <algorithm>
#include <archive/replay.hpp>

namespace downrange::archive {
namespace {

/// The record as an event, where it is of a kind that can be one.
std::optional<Event> as_event(const Record& record) {
  return std::visit(
      [](const auto& r) -> std::optional<Event> {
        if constexpr (std::is_constructible_v<Event, decltype(r)>) return r;
        return std::nullopt;
      },
      record);
}

}  // namespace

EventSource::EventSource(const std::filesystem::path& path) : path_(path), reader_(path) {}

std::optional<Event> EventSource::next() {
  while (const auto entry = reader_.next()) {
    if (entry->role == Role::Input) {
      if (const auto* bad = std::get_if<BadRecord>(&entry->record)) {
        throw ArchiveError(path_.string() + ": " + bad->topic + ": " + bad->what);
      }
      if (auto event = as_event(entry->record)) return event;
    }
    if (const auto* last = std::get_if<LastTick>(&entry->record)) last_tick_ = last->tick;
    if (const auto* truth = std::get_if<Truth>(&entry->record); truth != nullptr && on_truth_) on_truth_(*truth);
  }
  return std::nullopt;
}

std::optional<std::string> read_attachment(const std::filesystem::path& path, std::string_view name) {
  RawReader reader(path);
  for (;;) {
    const bool more = reader.next().has_value();
    const auto& all = reader.attachments();
    const auto found = std::find_if(all.begin(), all.end(), [&](const Attachment& a) { return a.name == name; });
    if (found != all.end()) return found->data;
    if (!more) return std::nullopt;
  }
}

}  // namespace downrange::archive
