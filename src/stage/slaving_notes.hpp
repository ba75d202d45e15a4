#pragma once
/// What logs say of SLAVE: each change of what an antenna follows, in sentences.

#include <downrange/stage/result.hpp>
#include <map>
#include <optional>
#include <string>
#include <vector>

namespace downrange {

/// "the fused track", "GPS alone (only-GPS)", "the nominal trajectory" and so on.
[[nodiscard]] std::string followed_text(const SlavingCommand& command);

class SlavingNotes {
 public:
  /// Empty: nothing has changed. A coasting of less than a second, as between the plots of a slow radar, is not told.
  [[nodiscard]] std::string change(const SlavingCommand& command);
  /// The mount's pointing error, when it is known, and when it has changed by more than 0.05 deg since it was told.
  [[nodiscard]] std::string mount_error(const SlavingCommand& command);
  /// One sentence for each antenna that has had no command for a second.
  [[nodiscard]] std::vector<std::string> ends(Time now);

 private:
  struct Told {
    Time newest;
    bool commanded = false;
    SlavingSource source = SlavingSource::Fused;  ///< as told
    Name chain;
    Name target;
    std::optional<Time> coasts_since{};
    double mount_azimuth_rad = 0;  ///< as told
    double mount_elevation_rad = 0;
  };
  std::map<Name, Told> told_;
};

}  // namespace downrange
