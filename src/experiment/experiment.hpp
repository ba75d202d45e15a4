#pragma once
/// The experiments of the five papers, each repeated by one command: what one is asked and what it answers.

#include <cstdint>
#include <functional>
#include <limits>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace downrange::experiment {

struct ExperimentOptions {
  int runs = 0;  ///< Monte Carlo runs; 0: as many as the figures are stated for
  std::uint64_t seed = 1;
  int jobs = 1;                      ///< threads; results do not depend on it
  std::vector<std::string> methods;  ///< only these; empty: all that the experiment compares
  /// Called as work is finished, fraction 0 to 1, from any of the threads but never from two at once.
  std::function<void(double)> progress = [](double) {};
};

/// One line of the table: a figure to reach (est/THEORY.md section 10) and what was measured.
struct Figure {
  std::string what;
  double measured = 0;
  std::string reach;  ///< "<= 1.10", "0.90 .. 1.10"; empty: for information
  bool reached = true;
};

/// `measured` against "at most", "at least" or "within".
[[nodiscard]] Figure at_most(std::string what, double measured, double limit);
[[nodiscard]] Figure at_least(std::string what, double measured, double limit);
[[nodiscard]] Figure within(std::string what, double measured, double low, double high);
[[nodiscard]] Figure shown(std::string what, double measured);

/// `value` with `digits` significant ones, zeros at the end included: "1.10", "0.0357"; "1e-9" outside 0.001 .. 99999;
/// "-" of what is no number.
[[nodiscard]] std::string number_text(double value, int digits);

/// Where `x` or `y` is not finite the curve has a gap.
struct Curve {
  std::string label{};  ///< empty: belongs to the curve before it (the lower edge of a band) and looks like it
  std::vector<double> x{};
  std::vector<double> y{};
  bool dashed = false;  ///< bounds and bands
  bool points = false;  ///< single residuals instead of a line
};

struct Plot {
  std::string title;
  std::string x_label;
  std::string y_label;
  bool log_y = false;
  std::vector<Curve> curves{};
  /// Greater magnitudes of y are drawn on the edge: a few wild ones do not flatten the rest.
  double y_most = std::numeric_limits<double>::infinity();
  std::string row{};  ///< neighbours of the same one stand side by side, with the same axes; empty: alone
};

/// A cell of a table: a number where it is one, shown as `text`.
struct Cell {
  std::string text;
  double number = std::numeric_limits<double>::quiet_NaN();
};

struct Table {
  std::string caption;
  std::vector<std::string> columns;
  std::vector<std::vector<Cell>> rows;  ///< each as wide as `columns`; the first cell names it
};

struct ExperimentResult {
  std::string name;
  std::string title;  ///< with the paper
  int runs = 0;       ///< 0: of recorded data, nothing is drawn
  std::uint64_t seed = 0;
  std::vector<std::pair<std::string, std::string>> settings;  ///< what a reader needs to repeat it
  std::vector<Figure> figures;
  std::vector<Table> tables;
  std::vector<Plot> plots;
  std::vector<std::string> notes;
};

struct Experiment {
  std::string_view name;
  std::string_view help;
  int runs;  ///< that the figures are stated for; 0: of recorded data, nothing is drawn
  std::vector<std::string> methods;
  std::function<ExperimentResult(const ExperimentOptions& options)> run;
};

/// Whether every figure is reached.
[[nodiscard]] bool all_reached(const ExperimentResult& result);

/// The methods asked for, in the order of `compared`; all of these when none is asked for. Throws
/// std::invalid_argument that names the allowed ones.
[[nodiscard]] std::vector<std::string> chosen_methods(const std::vector<std::string>& asked,
                                                      const std::vector<std::string>& compared);

/// "300 runs, seed 1".
[[nodiscard]] std::string runs_text(const ExperimentResult& result);

/// Those of the papers, in the order of est/THEORY.md: launch, kim2011, federated, spatial, alphabeta, noise.
[[nodiscard]] const std::vector<Experiment>& experiments();

/// Each in a file of its own name. Throws std::invalid_argument for a method that it does not compare.
[[nodiscard]] ExperimentResult run_launch(const ExperimentOptions& options);
[[nodiscard]] ExperimentResult run_kim2011(const ExperimentOptions& options);
[[nodiscard]] ExperimentResult run_federated(const ExperimentOptions& options);
[[nodiscard]] ExperimentResult run_spatial(const ExperimentOptions& options);
[[nodiscard]] ExperimentResult run_alphabeta(const ExperimentOptions& options);
[[nodiscard]] ExperimentResult run_noise(const ExperimentOptions& options);

}  // namespace downrange::experiment
