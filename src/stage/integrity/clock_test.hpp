#pragma once
/// Clock test: are one witness's times late for another's? The biases explain what stays; a wrong clock displaces a
/// source along the path by what the target flies meanwhile, and grows with the speed. A small Kalman filter of the
/// differences of two witnesses estimates how far their clocks are apart beside both biases within their priors, and
/// what varies slowly. Of directions alone only against a receiver.

#include <downrange/geo/time.hpp>
#include <optional>

#include "coarse_test.hpp"

namespace downrange::integrity {

/// How far two clocks are apart, s; beyond what is configured of either.
struct ClocksApart {
  double by_s = 0;
  double sigma_s = 0;
};

class ClockTest {
 public:
  ClockTest() { begin(Time{}); }

  /// Of chi2, one degree of freedom.
  [[nodiscard]] static double threshold();

  /// The samples of both at one instant, ascending. Says nothing of two receivers.
  TestResult operator()(const Witness& first, const Sample& a, const Witness& second, const Sample& b,
                        const Threshold& threshold);

  /// The second's clock less the first's; nothing while that cannot be told.
  [[nodiscard]] std::optional<ClocksApart> apart() const;
  /// Since when it has been what it is.
  [[nodiscard]] Time since() const { return since_; }

 private:
  /// Clocks; the biases of both; what varies slowly, in units of its standard deviation.
  static constexpr int clocks = 0;
  static constexpr int of_second = 1;
  static constexpr int of_first = of_second + bias_term_count;
  static constexpr int slow = of_first + bias_term_count;
  static constexpr int size = slow + 3;
  using Row = Eigen::Matrix<double, 3, size>;

  void begin(Time at);
  void know(const KnownBias& first, const KnownBias& second);
  void open_clocks(Time at);
  void predict(double dt_s, double tau_s);

  Vec<size> x_;
  Mat<size, size> P_;
  Time newest_;
  Time since_;
  bool begun_ = false;
  bool wrong_ = false;
  Time misfit_since_;
  int misfits_ = 0;  ///< in a row: what no clock explains
  int fits_ = 0;     ///< in a row
};

}  // namespace downrange::integrity
