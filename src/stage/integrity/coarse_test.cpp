#include "coarse_test.hpp"

namespace downrange::integrity {

TestResult coarse_test(const Witness& first, const Sample& a, const Witness& second, const Sample& b,
                       const Threshold& threshold) {
  const auto x = difference(first, a, first.prior.mean, second, b, second.prior.mean);
  if (!x) return {};
  TestResult result;
  const Mat<3, 3> S = x->white + x->slow_first + x->slow_second +
                      x->by_first * first.prior.cov * x->by_first.transpose() +
                      x->by_second * second.prior.cov * x->by_second.transpose() +
                      north_jump(x->by_first, first.prior) + north_jump(x->by_second, second.prior);
  result.ratio = threshold.ratio(x->d, S, x->ranged, &result.whitened);
  result.apart_m = x->d.cwiseProduct(x->to_metres).norm();
  return result;
}

}  // namespace downrange::integrity
