#pragma once
/// What the best estimator of the class could know: the covariance of method joint linearised along the truth.

#include <downrange/est/method/method.hpp>
#include <functional>
#include <memory>
#include <vector>

namespace downrange {

/// Position, velocity, acceleration of the target, ECEF, at an instant.
using TrueMotion = std::function<Vec<9>(Time)>;

/// The covariance recursion of method joint in which every prediction and every Jacobian is taken at the truth: no
/// estimate, no noise, no luck of a run. For kinematics cv and ca it is the bound that estimates are compared with.
class Bound {
 public:
  /// `truth` of the one target; `biases`, indexed [radar](BiasTerm), the true biases. Kinematics cv or ca; other ones
  /// throw std::invalid_argument.
  Bound(const MethodSettings& settings, TrueMotion truth,
        std::vector<Eigen::Matrix<double, bias_term_count, 1>> biases);
  ~Bound();
  Bound(Bound&&) noexcept;

  /// The initial uncertainty at `epoch` (position, velocity, acceleration).
  void start(Time epoch, const Mat<9, 9>& cov);
  /// The information of one fix or plot of range and angles; only its epoch, source and accuracies matter. In order of
  /// epoch.
  void apply(const Measurement& m);

  /// At the epoch of the newest measurement; size as TrackEstimate::size (acceleration rows zero for cv).
  [[nodiscard]] Mat<9, 9> track_covariance() const;
  /// Of one radar's terms in the order of its BiasModel::terms.
  [[nodiscard]] Eigen::MatrixXd bias_covariance(int radar) const;

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace downrange
