#include <boost/math/distributions/chi_squared.hpp>
#include <downrange/est/consistency.hpp>
#include <limits>

namespace downrange {

double chi2_quantile(double probability, int dof) {
  if (probability >= 1) return std::numeric_limits<double>::infinity();
  return boost::math::quantile(boost::math::chi_squared(dof), probability);
}

void RunningResidual::add(double normalised, double square, double nis_over_dof) {
  constexpr double weight = 1.0 / 50;
  const double gain = started ? weight : 1.0;
  started = true;
  mean += gain * (normalised - mean);
  mean_square += gain * (square - mean_square);
  nis_per_dof += gain * (nis_over_dof - nis_per_dof);
}

}  // namespace downrange
