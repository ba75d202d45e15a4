#pragma once
/// Errors of a method flown over one run of the launch scenario, and the bound's, in the same sums.

#include <array>
#include <string>
#include <vector>

#include "experiment/launch_scenario.hpp"
#include "experiment/residual_plot.hpp"
#include "score/errors.hpp"

namespace downrange::experiment::launch {

using score::Share;
using score::Squares;

inline constexpr int ripple_bins = 10;
inline constexpr int seconds_shown = static_cast<int>(end_s - tracking_from_s);

/// Position error and bias left, over one window or one second, at the instants of the plots.
struct Errors {
  Squares position;
  std::array<Squares, radars> bias_left;

  Errors& operator+=(const Errors& other);
};

struct WindowScore {
  Errors errors;
  Share nis;                                  ///< inside the 95 % region
  Share two_sigma;                            ///< of position, per axis
  Share bias_nees;                            ///< of one radar's terms, inside the 95 % region
  std::array<Squares, ripple_bins> ripple{};  ///< bias left of both radars by time since the last fix

  WindowScore& operator+=(const WindowScore& other);
};

struct Score {
  std::array<WindowScore, 3> window;
  std::vector<Errors> second = std::vector<Errors>(static_cast<std::size_t>(seconds_shown));  ///< from 100 s on

  Score& operator+=(const Score& other);
};

struct PlotResidual : Residual {
  int radar = 0;
};

struct Contestant {
  std::string label{};
  std::string_view method{};
  Case which = Case::Base;
  Kinematics kinematics = Kinematics::Ca;
  BiasModel bias{};
  bool gets_fixes = true;
  bool starts_with_plot = false;  ///< the first estimate is of the first plot, not of the first fix 20 s earlier
};

/// Flies `contestant` over one run. `residuals`, where given, gets those of the plots in the windows.
[[nodiscard]] Score fly(const Contestant& contestant, const Scene& scene, const Drawn& drawn,
                        std::vector<PlotResidual>* residuals = nullptr);

/// The covariance bound of the joint filter with constant-jerk kinematics, along the truth, with the fixes of `which`.
[[nodiscard]] Score bound_of(Case which, const BiasModel& bias, const Scene& scene);

}  // namespace downrange::experiment::launch
