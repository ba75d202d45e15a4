#include "flight.hpp"

#include <spdlog/spdlog.h>

#include <utility>

namespace downrange::app {
namespace {

/// Shorter than the silence after which an engine ticks no more (700 s): a node that waits for its flight goes on to
/// tell of its sources.
constexpr Duration longest_silence = seconds(300.0);

}  // namespace

Flight::Flight(const config::ServiceConfig& config, dds::OutputWriters& outputs, std::unique_ptr<Recorder> recorder,
               std::function<Time()> utc)
    : outputs_(outputs),
      recorder_(std::move(recorder)),
      utc_(std::move(utc)),
      acknowledgements_(config.range),
      engine_(config.range, config.node.stages, *this) {}

Flight::~Flight() {
  if (recorder_) recorder_->finish(engine_.last_tick());
}

void Flight::consume(const Event& event) {
  const Event admitted = engine_.admit(event);
  if (recorder_) recorder_->consumed(admitted);
  engine_.handle(admitted);
  if (const auto note = acknowledgements_.note(admitted)) spdlog::info("{}", *note);
  newest_ = received_of(admitted);
  ++consumed_;
}

void Flight::advance(Time now) {
  if (utc_ && now - newest_ > longest_silence) consume(ClockGap{.epoch = now, .received = now});
  if (consumed_ > 0) engine_.advance_to(now);
}

bool Flight::is_expired(const Result& result) const {
  const auto* command = std::get_if<SlavingCommand>(&result);
  return command != nullptr && utc_ && command->valid_until < utc_();
}

void Flight::emit(const Result& result) {
  if (is_expired(result)) {
    ++expired_;
  } else {
    outputs_.emit(result);
  }
  if (recorder_) recorder_->produced(result);
  ++emitted_;
  if (const auto* health = std::get_if<SourceHealth>(&result)) {
    const bool good = health->qualified && !health->mismatch;
    const auto level = good ? spdlog::level::info : spdlog::level::warn;
    if (const std::string note = notes_.changes(*health); !note.empty()) spdlog::log(level, "{}", note);
    for (const std::string& note : slaving_notes_.ends(health->time)) spdlog::warn("{}", note);
  } else if (const auto* command = std::get_if<SlavingCommand>(&result)) {
    const auto level = command->source == SlavingSource::Fused ? spdlog::level::info : spdlog::level::warn;
    if (const std::string note = slaving_notes_.change(*command); !note.empty()) spdlog::log(level, "{}", note);
    if (const std::string note = slaving_notes_.mount_error(*command); !note.empty()) spdlog::info("{}", note);
  } else if (const auto* integrity = std::get_if<Integrity>(&result)) {
    for (const std::string& note : integrity_notes_.changes(*integrity)) spdlog::warn("{}", note);
  }
}

}  // namespace downrange::app
