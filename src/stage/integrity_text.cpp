#include "integrity_text.hpp"

#include <array>
#include <cmath>
#include <string>
#include <vector>

#include "stage/decimal.hpp"

namespace downrange {
namespace {

std::string text_of(const Name& name) { return std::string(name.view()); }

/// "a", "a and b", "a, b and c".
std::string list(const std::vector<std::string>& names) {
  std::string text;
  for (std::size_t i = 0; i < names.size(); ++i) {
    if (i > 0) text += i + 1 == names.size() ? " and " : ", ";
    text += names[i];
  }
  return text;
}

std::string text_of(double value, int decimals) { return std::string(decimal(value, decimals).view()); }

std::string two_digits(std::int64_t n) { return (n < 10 ? "0" : "") + std::to_string(n); }

/// What speaks against it, behind its name; empty: nothing.
std::string accusation_of(const Integrity& record, std::size_t source) {
  const SourceIntegrity& s = record.sources[source];
  std::vector<std::string> names;
  for (std::size_t i = 0; i < record.sources.size(); ++i) {
    if (i != source && (s.against >> i & 1U) != 0) names.push_back(text_of(record.sources[i].sensor));
  }
  const std::string others = list(names);
  const bool known = s.apart_m > 0;
  const std::string by_how_much = known ? " by " + distance_text(s.apart_m) : "";
  switch (s.why) {
    case Finding::CoarseVelocity:
      return " does not move as its own velocity says" + (known ? ", by " + text_of(s.apart_m, 1) + " m/s" : "");
    case Finding::Clock:
      if (others.empty()) return "";
      return " disagrees with " + others + " as by a clock that is " + (known ? text_of(s.apart_m, 2) + " s " : "") +
             "off";
    case Finding::Impossible:
      if (known) return " leapt, and is " + distance_text(s.apart_m) + " off its own path";
      return " repeats one position in flight, to the bit,";
    case Finding::OffPad:
      return known ? " is " + distance_text(s.apart_m) + " off the pad" : "";
    case Finding::DifferingCopy:
      if (others.empty()) return "";
      return " relays another fix than " + others + (known ? ", " + distance_text(s.apart_m) + " off," : "");
    case Finding::CommonBias:
      return " disagrees with all radars in the same way" + by_how_much;
    case Finding::ImplausibleBias:
      if (others.empty()) return known ? " would be biased beyond what is configured" + by_how_much : "";
      break;
    default:
      break;
  }
  const bool with_itself = (s.against >> source & 1U) != 0;
  if (others.empty()) return with_itself ? " relays two receivers that differ" + by_how_much : "";
  return " disagrees with " + others + by_how_much;
}

std::string by(const Name& who) { return who.empty() ? "" : " by " + text_of(who); }

}  // namespace

std::string_view to_string(IntegrityVerdict verdict) {
  static constexpr std::array<std::string_view, 4> names{"agrees", "suspect", "excluded", "ambiguous"};
  return names.at(static_cast<std::size_t>(verdict));
}

std::string_view to_string(Finding finding) {
  static constexpr std::array<std::string_view, 10> names{
      "none",        "coarse position", "coarse velocity", "fine position", "clock", "implausible bias",
      "common bias", "differing copy",  "off the pad",     "impossible"};
  return names.at(static_cast<std::size_t>(finding));
}

std::string mission_time(Time t, std::optional<Time> liftoff) {
  if (liftoff) {
    const double s = (t - *liftoff).seconds();
    return (s < 0 ? "T-" : "T+") + text_of(std::abs(s), 1);
  }
  const std::int64_t day_s = (t.ns / 1'000'000'000) % 86'400;
  return two_digits(day_s / 3600) + ":" + two_digits(day_s / 60 % 60) + ":" + two_digits(day_s % 60);
}

std::string distance_text(double m) {
  if (!(std::abs(m) < 1e15)) return "very far";
  const std::string sign = m < 0 ? "-" : "";
  if (std::abs(m) < 10) return sign + text_of(std::abs(m), 1) + " m";
  if (std::abs(m) < 1000) return sign + std::to_string(std::llround(std::abs(m))) + " m";
  return sign + text_of(std::abs(m) / 1000, 1) + " km";
}

std::string sentence(const Integrity& record, std::size_t source) {
  const SourceIntegrity& s = record.sources.at(source);
  const std::optional<Time> liftoff = record.liftoff_valid ? std::optional(record.liftoff) : std::nullopt;
  const std::string accusation = accusation_of(record, source);
  std::string text = text_of(s.sensor);
  if (!accusation.empty()) {
    text += accusation;
    if (s.onset.ns != 0) text += " since " + mission_time(s.onset, liftoff);
    if ((s.against & (s.against - 1)) != 0 && s.agree_m > 0) text += "; these agree within " + distance_text(s.agree_m);
    text += ";";
  }
  switch (s.verdict) {
    case IntegrityVerdict::Agrees:
      text += accusation.empty() ? " agrees" : " used";
      break;
    case IntegrityVerdict::Suspect:
      text += " suspect, used";
      break;
    case IntegrityVerdict::Excluded:
      text += " excluded" + by(s.by);
      break;
    case IntegrityVerdict::Ambiguous:
      text += " which of them is right cannot be told";
      break;
  }
  if (s.since.ns != 0) text += " since " + mission_time(s.since, liftoff);
  if (s.why != Finding::None) text += " (" + std::string(to_string(s.why)) + ")";
  return text;
}

std::string selection(const Integrity& record) {
  std::string text =
      text_of(record.target) + " follows " + (record.chain.empty() ? "all sources" : "chain " + text_of(record.chain));
  if (!record.held_by.empty()) text += ", held there by " + text_of(record.held_by);
  return text + (record.bound_valid ? ", bound " + distance_text(record.bound_m) : ", UNBOUNDED");
}

}  // namespace downrange
