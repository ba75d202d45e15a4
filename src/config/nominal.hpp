#pragma once
/// Nominal trajectories: a plan as a CSV file, and as rows of numbers in the configuration in force.

#include <toml++/toml.h>

#include <downrange/geo/nominal_trajectory.hpp>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace downrange::config {

/// More samples are refused: 2 hours at 1 Hz and twice that.
inline constexpr std::size_t max_nominal_samples = 20'000;

/// What a file is read by.
struct NominalFormat {
  std::vector<std::string> columns{};  ///< names of the file's columns in their order; empty: its first line has them
  std::string object{};                ///< the rows to take, where a column `object` tells several apart
};

/// A problem of the file's line; 0: of the file as a whole.
using NominalProblem = std::function<void(int line, const std::string& message)>;

/// Columns, each with its unit behind its name: t_s; x_m, y_m, z_m, or latitude_deg, longitude_deg, height_m; vx_m_s,
/// vy_m_s, vz_m_s (Earth-fixed), which may be missing; object, which may be missing; "-" for what is not read. Fields
/// stand between commas, semicolons or tabs; what starts with # is a comment. Nothing after a problem.
[[nodiscard]] std::optional<NominalTrajectory> read_nominal_csv(std::string_view text, const NominalFormat& format,
                                                                const NominalProblem& problem);

/// Names of columns with every unit, for people.
[[nodiscard]] std::string nominal_columns_help();

/// [[t, x, y, z, vx, vy, vz], ...] in SI; nothing when it is not that.
[[nodiscard]] std::optional<NominalTrajectory> nominal_from(const toml::array& rows);
[[nodiscard]] toml::array rows_of(const NominalTrajectory& nominal);

/// "481 samples, T+0 to T+480 s (5f3a...)": another trajectory has another text.
[[nodiscard]] std::string show_nominal(const NominalTrajectory& nominal);

}  // namespace downrange::config
