#include <downrange/est/model/measurement.hpp>
#include <downrange/geo/site.hpp>
#include <tuple>

namespace downrange {

bool processed_before(const Measurement& a, const Measurement& b) {
  return std::tie(a.epoch, a.source, a.target, a.sequence) < std::tie(b.epoch, b.source, b.target, b.sequence);
}

Mat<3, 3> fix_covariance(const Fix& fix) {
  const double h2 = fix.sigma_horizontal_m * fix.sigma_horizontal_m;
  const double v2 = fix.sigma_vertical_m * fix.sigma_vertical_m;
  const Mat<3, 3> R_ecef_enu = enu_from_ecef_at(geodetic_from_ecef(fix.position)).R.transpose();
  return R_ecef_enu * Vec<3>(h2, h2, v2).asDiagonal() * R_ecef_enu.transpose();
}

}  // namespace downrange
