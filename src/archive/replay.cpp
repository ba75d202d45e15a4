#include <algorithm>
#include <archive/replay.hpp>
#include <cstdio>

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

/// "12.3 s", "4.2 days".
std::string span(Duration d) {
  constexpr double day_s = 86'400;
  const bool days = d.seconds() > 2 * day_s;
  char text[40];
  std::snprintf(text, sizeof text, "%.*f %s", days ? 1 : 3, days ? d.seconds() / day_s : d.seconds(),
                days ? "days" : "s");
  return text;
}

}  // namespace

EventSource::EventSource(const std::filesystem::path& path, EventOrder order)
    : path_(path), order_(order), reader_(path) {}

std::optional<Event> EventSource::next() {
  auto place = order_.sort ? next_sorted() : next_in_file();
  if (place) {
    judge(place->event);
    return std::move(place->event);
  }
  // A LastTick of a node that ran no tick is far in the past.
  if (last_tick_ && newest_ && *last_tick_ > *newest_ && *last_tick_ - *newest_ > max_silence) {
    throw ArchiveError(path_.string() + ": its last tick is " + span(*last_tick_ - *newest_) + " after its last event");
  }
  return std::nullopt;
}

std::optional<EventSource::Place> EventSource::next_in_file() {
  while (const auto entry = reader_.next()) {
    if (entry->role == Role::Input) {
      if (const auto* bad = std::get_if<BadRecord>(&entry->record)) {
        throw ArchiveError(path_.string() + ": " + bad->topic + ": " + bad->what);
      }
      if (auto event = as_event(entry->record)) return Place{std::move(*event), entry->sequence};
    }
    if (const auto* last = std::get_if<LastTick>(&entry->record)) last_tick_ = last->tick;
    if (const auto* truth = std::get_if<Truth>(&entry->record)) {
      if (order_.sort) {
        truths_.push_back(*truth);
      } else if (on_truth_) {
        on_truth_(*truth);
      }
    }
  }
  reader_.raw().require_declared();
  return std::nullopt;
}

std::optional<EventSource::Place> EventSource::next_sorted() {
  if (!read_) read_sorted();
  const auto due = [&](const Truth& t) { return events_.empty() || t.epoch <= received_of(events_.back().event); };
  for (; !truths_.empty() && due(truths_.back()); truths_.pop_back()) {
    if (on_truth_) on_truth_(truths_.back());
  }
  if (events_.empty()) return std::nullopt;
  Place place = std::move(events_.back());
  events_.pop_back();
  return place;
}

void EventSource::read_sorted() {
  read_ = true;
  while (auto place = next_in_file()) events_.push_back(std::move(*place));
  std::vector<std::uint32_t> sequences;
  sequences.reserve(events_.size());
  for (const Place& place : events_) sequences.push_back(place.sequence);
  std::sort(sequences.begin(), sequences.end());
  const bool counted = std::adjacent_find(sequences.begin(), sequences.end()) == sequences.end();
  std::stable_sort(events_.begin(), events_.end(), [counted](const Place& a, const Place& b) {
    const Time received_a = received_of(a.event);
    const Time received_b = received_of(b.event);
    if (received_a != received_b) return received_a < received_b;
    return counted ? a.sequence < b.sequence : step_order_less(a.event, b.event);
  });
  std::stable_sort(truths_.begin(), truths_.end(), [](const Truth& a, const Truth& b) { return a.epoch < b.epoch; });
  std::reverse(events_.begin(), events_.end());
  std::reverse(truths_.begin(), truths_.end());
}

void EventSource::judge(const Event& event) {
  const Time received = received_of(event);
  if (newest_ && received < *newest_ && *newest_ - received >= std::max(order_.slack, Duration{1})) {
    throw OrderError(path_.string() + ": not in the order of time: an event was received " + span(*newest_ - received) +
                     " before one that stands before it");
  }
  if (newest_ && received > *newest_ && received - *newest_ > max_silence) {
    throw ArchiveError(path_.string() + ": a silence of " + span(received - *newest_) +
                       " between two events: a clock was wrong");
  }
  newest_ = std::max(newest_.value_or(received), received);
}

void require_events(const std::filesystem::path& path) {
  Reader reader(path);
  std::uint64_t others = 0;
  while (const auto entry = reader.next()) {
    if (entry->role == Role::Input) return;
    ++others;
  }
  std::string holds;
  const auto add = [&](const std::string& what) { holds += (holds.empty() ? "" : " and ") + what; };
  if (others > 0) add(std::to_string(others) + " results and truths");
  for (const auto& [channel, count] : reader.foreign_channels()) {
    add(std::to_string(count) + " messages of " + channel);
  }
  if (const std::string lost = reader.raw().undeclared_messages(); !lost.empty())
    add(lost + ", which no Channel record before them declares");
  throw ArchiveError(path.string() + ": no measurement or mission event of Downrange in it; it holds " +
                     (holds.empty() ? "no message at all" : holds));
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
