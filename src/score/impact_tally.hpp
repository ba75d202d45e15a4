#pragma once
/// What is collected of a flight's impact points on the way.

#include <downrange/stage/range_config.hpp>
#include <downrange/stage/result.hpp>
#include <map>
#include <optional>
#include <vector>

#include "score/errors.hpp"
#include "score/summary.hpp"
#include "score/truth.hpp"

namespace downrange::score {

/// How far an impact point is from where the true state falls.
struct ImpactError {
  Eigen::Vector2d off_m = Eigen::Vector2d::Zero();  ///< told - true, east and north
  double nees = 0;                                  ///< by the covariance told; chi2(2) where that is right
};
/// Nothing where one of them does not come down.
[[nodiscard]] std::optional<ImpactError> impact_error(const ImpactPoint& told, const TrueState& truth,
                                                      const FallSettings& fall);

class ImpactTally {
 public:
  /// `liftoff`: what its times are counted from.
  ImpactTally(const FallSettings& fall, Time liftoff) : fall_(fall), liftoff_(liftoff) {}

  /// `truth`: at its epoch, where it is known.
  void add(const ImpactPoint& point, const std::optional<TrueState>& truth);

  /// The selected chain first.
  [[nodiscard]] std::vector<ImpactScore> chains() const;
  /// By the selected chain.
  [[nodiscard]] std::vector<BoundaryScore> boundaries() const { return boundaries_; }

 private:
  struct Chain {
    ImpactScore score;
    std::vector<double> errors_m{};
    Share inside{};
  };

  void add_boundaries(const ImpactPoint& point);

  FallSettings fall_;
  Time liftoff_;
  std::map<Name, Chain> chains_;
  std::vector<BoundaryScore> boundaries_;
};

}  // namespace downrange::score
