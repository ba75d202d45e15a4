#pragma once
/// What the log says of the sources: each change that an operator should hear of, once.

#include <spdlog/fmt/fmt.h>

#include <downrange/stage/result.hpp>
#include <map>
#include <string>

namespace downrange::app {

class HealthNotes {
 public:
  /// Whether the source lost or regained its qualification, whether its mismatch alarm began or ended. Empty: neither.
  /// Another reason for not being qualified is no change: it may be another one with every message.
  [[nodiscard]] std::string changes(const SourceHealth& health) {
    Told& told = told_[health.sensor];
    std::string text;
    if (health.qualified != told.qualified)
      text += health.qualified ? told.before ? "; qualified again" : "; qualified"
                               : fmt::format("; NOT qualified: {}{}{}", why_not_qualified(health),
                                             health.by.empty() ? "" : " by ", health.by.view());
    if (health.mismatch != told.mismatch)
      text += health.mismatch ? fmt::format(
                                    "; MISMATCH: {:.1f} % of its last {} NIS inside 95 %: what is configured of it "
                                    "(bias_blocks, sigmas, angle_inflation) does not fit",
                                    100 * health.nis_inside_95, health.nis_count)
                              : "; fits again: mismatch alarm over";
    told = {.qualified = health.qualified, .before = told.before || health.qualified, .mismatch = health.mismatch};
    return text.empty() ? text : fmt::format("source {}: {}", health.sensor.view(), text.substr(2));
  }

 private:
  struct Told {
    bool qualified = true;
    bool before = false;  ///< it was qualified at some time
    bool mismatch = false;
  };
  std::map<Name, Told> told_;
};

}  // namespace downrange::app
