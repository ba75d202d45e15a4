/// What INTEGRITY thinks of a source, as a person says it.

#include <cmath>
#include <string>

#include "judge.hpp"

namespace downrange {
namespace {

std::string decimal(double value) {
  const auto tenths = static_cast<long>(std::lround(value * 10));
  return std::to_string(tenths / 10) + "." + std::to_string(tenths % 10);
}

std::string distance(double m) {
  if (m >= 999.5) return decimal(m / 1000) + " km";
  if (m >= 9.95) return std::to_string(std::lround(m)) + " m";
  return decimal(m) + " m";
}

std::string name_of(SourceId source, const Judgement& judgement, const SourceTable& sources) {
  if (sources[source].kind != SourceKind::Telemetry) return std::string(sources[source].name.view());
  return judgement.receiver.empty() ? "GPS" : "GPS " + std::string(judgement.receiver.view());
}

/// "goheung, jeju and GPS"; stations that relay a receiver count as `receiver`, once; each by its name where that is
/// empty.
std::string list(SourceSet set, const SourceTable& sources, std::string_view receiver, int& entries) {
  std::vector<std::string> names;
  bool gps = false;
  for (SourceId id = 0; id < static_cast<SourceId>(sources.size()); ++id) {
    if (!contains(set, id)) continue;
    if (sources[id].kind == SourceKind::Telemetry && !receiver.empty())
      gps = true;
    else
      names.emplace_back(sources[id].name.view());
  }
  if (gps) names.emplace_back(receiver);
  entries = static_cast<int>(names.size());
  std::string text;
  for (std::size_t i = 0; i < names.size(); ++i) {
    if (i > 0) text += i + 1 == names.size() ? " and " : ", ";
    text += names[i];
  }
  return text;
}

}  // namespace

std::string sentence(SourceId source, const Judgement& j, const SourceTable& sources) {
  int others = 0;
  const bool copy = j.why == Finding::DifferingCopy;
  const bool receives = sources[source].kind == SourceKind::Telemetry;
  const std::string against = list(j.against, sources, copy ? "" : receives ? "another receiver" : "GPS", others);
  const std::string subject = name_of(source, j, sources);
  switch (j.why) {
    case Finding::None:
      return "";
    case Finding::CoarsePosition:
    case Finding::FinePosition: {
      std::string text = subject + " disagrees with " + against + " by " + distance(j.apart_m);
      if (j.verdict == IntegrityVerdict::Ambiguous) return text + "; nothing tells who is right";
      if (others > 1) text += "; these agree within " + distance(j.agree_m);
      return text;
    }
    case Finding::CoarseVelocity:
    case Finding::FineVelocity:
      return subject + " does not move as its own velocity says, by " + decimal(j.apart_m) + " m/s";
    case Finding::ImplausibleBias:
      if (j.verdict == IntegrityVerdict::Ambiguous)
        return "either " + subject + " or " + against + " is wrong: what one makes of the other is beyond belief, " +
               distance(j.apart_m);
      return subject + " would have to be biased beyond what is configured, by " + distance(j.apart_m);
    case Finding::CommonBias:
      return subject + " disagrees with all radars in the same way, by " + distance(j.apart_m);
    case Finding::DifferingCopy:
      return std::string(sources[source].name.view()) + " relays another fix than " + against + ", " +
             distance(j.apart_m) + " off";
    case Finding::OffPad:
      return subject + " is " + distance(j.apart_m) + " off the pad";
    case Finding::Impossible:
      return subject + " says what no vehicle does";
  }
  return "";
}

}  // namespace downrange
