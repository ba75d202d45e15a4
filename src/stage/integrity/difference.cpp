#include "difference.hpp"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <cmath>
#include <downrange/est/filter/consistency.hpp>
#include <downrange/est/model/plot_model.hpp>
#include <limits>
#include <numbers>

namespace downrange::integrity {
namespace {

/// No receiver is better than this, whatever it states.
constexpr double receiver_floor_m = 1;
constexpr double least_cos_elevation = 0.01;
constexpr double false_alarm = 1e-6;

/// Where a witness says that the target is.
struct Told {
  Vec<3> position = Vec<3>::Zero();
  Mat<3, 3> white = Mat<3, 3>::Zero();
  Mat<3, 3> slow = Mat<3, 3>::Zero();
  Mat<3, bias_term_count> by_bias = Mat<3, bias_term_count>::Zero();
};

Mat<3, 3> plot_noise(const Witness& w, const Sample& s) {
  Vec<3> variance = plot_variance(w.model, {.measured = {s.z[0], s.z[1], s.z[2]}});
  if (w.kind == WitnessKind::Angles) variance[0] = 1;
  return s.median_factor() * Mat<3, 3>(variance.asDiagonal());
}

Mat<3, 3> pointing(const Witness& w, const Sample& s) {
  const Vec<3> variance = plot_variance(w.model, {.measured = {s.z[0], s.z[1], s.z[2]}});
  const double wander = w.model.wander.sigma_rad * w.model.wander.sigma_rad;
  const double cos_elevation = std::max(std::cos(s.z[2]), least_cos_elevation);
  return Vec<3>(0, w.slow_factor * variance[1] + wander / (cos_elevation * cos_elevation),
                w.slow_factor * variance[2] + wander)
      .asDiagonal();
}

std::optional<Told> tell(const Witness& w, const Sample& s, const BiasVector& bias) {
  Told told;
  if (w.is_receiver()) {
    told.position = s.z;
    told.white = s.median_factor() * fix_noise(s.z, s.sigma_horizontal_m, s.sigma_vertical_m);
    told.slow = w.slow_sigma_m * w.slow_sigma_m * Mat<3, 3>::Identity();
    return told;
  }
  // The plot's inverse, by Newton from the reference: three unknowns, three equations.
  Vec<9> motion = s.motion;
  Mat<3, 3> to_position = Mat<3, 3>::Zero();
  PredictedPlot predicted;
  for (int iteration = 0; iteration < 4; ++iteration) {
    predicted = predict_plot(w.model, motion, bias);
    to_position = predicted.d_motion.leftCols<3>().partialPivLu().solve(Mat<3, 3>::Identity());
    motion.head<3>() += to_position * plot_residual({s.z[0], s.z[1], s.z[2]}, predicted.q);
  }
  told.position = motion.head<3>();
  told.white = to_position * plot_noise(w, s) * to_position.transpose();
  told.slow = to_position * pointing(w, s) * to_position.transpose();
  told.by_bias = -to_position * predicted.d_bias;
  if (!told.position.allFinite() || !told.white.allFinite()) return std::nullopt;
  return told;
}

}  // namespace

Mat<3, 3> fix_noise(const Vec<3>& position, double sigma_horizontal_m, double sigma_vertical_m) {
  const double horizontal = std::max(sigma_horizontal_m, receiver_floor_m);
  const double vertical = std::max(sigma_vertical_m, receiver_floor_m);
  const Mat<3, 3> R = enu_from_ecef_at(geodetic_from_ecef({position})).R;
  return R.transpose() * Vec<3>(horizontal, horizontal, vertical).cwiseAbs2().asDiagonal() * R;
}

std::optional<Position<Ecef>> told_position(const Witness& witness, const Sample& sample) {
  if (!witness.tells_position()) return std::nullopt;
  if (witness.is_receiver()) return Position<Ecef>{sample.z};
  return witness.model.site.ecef_of(enu_from_polar({sample.z[0], sample.z[1], sample.z[2]}));
}

Vec<3> displacement(const Witness& radar, const Sample& sample, const BiasVector& bias) {
  const std::optional<Told> told = tell(radar, sample, BiasVector::Zero());
  return told ? Vec<3>(-told->by_bias * bias) : Vec<3>(Vec<3>::Zero());
}

Vec<3> wrapped(const Witness& second, Vec<3> d) {
  if (!second.is_receiver()) d[1] = wrap_pi(d[1]);
  return d;
}

std::optional<Difference> difference(const Witness& first, const Sample& a, const BiasVector& bias_a,
                                     const Witness& second, const Sample& b, const BiasVector& bias_b) {
  const std::optional<Told> told = tell(first, a, bias_a);
  if (!told) return std::nullopt;
  Difference out;
  if (second.is_receiver()) {
    out.d = b.z - told->position;
    out.white = told->white + b.median_factor() * fix_noise(b.z, b.sigma_horizontal_m, b.sigma_vertical_m);
    out.slow_first = told->slow;
    out.slow_second = second.slow_sigma_m * second.slow_sigma_m * Mat<3, 3>::Identity();
    out.by_first = -told->by_bias;
    return out;
  }
  Vec<9> motion = a.motion;
  motion.head<3>() = told->position;
  const PredictedPlot predicted = predict_plot(second.model, motion, bias_b);
  const Mat<3, 3> H = predicted.d_motion.leftCols<3>();
  out.ranged = second.kind == WitnessKind::Radar;
  out.d = plot_residual({b.z[0], b.z[1], b.z[2]}, predicted.q);
  out.white = plot_noise(second, b) + H * told->white * H.transpose();
  out.slow_first = H * told->slow * H.transpose();
  out.slow_second = pointing(second, b);
  out.by_first = -H * told->by_bias;
  out.by_second = -predicted.d_bias;
  const double range = (told->position - second.model.site.ecef().m).norm();
  out.to_metres = {out.ranged ? 1.0 : 0.0, range * std::cos(predicted.q[2]), range};
  if (!out.d.allFinite() || !out.white.allFinite()) return std::nullopt;
  return out;
}

double azimuth_from_south(const Mat<3, bias_term_count>& by) {
  const Vec<3> per_azimuth = by.col(static_cast<Eigen::Index>(BiasTerm::OffsetAzimuth));
  const double square = per_azimuth.squaredNorm();
  return square > 0 ? by.col(static_cast<Eigen::Index>(BiasTerm::ScaleAzimuth)).dot(per_azimuth) / square : 0;
}

Mat<3, 3> north_jump(const Mat<3, bias_term_count>& by, const KnownBias& bias) {
  constexpr double sigmas = 4;  // below one in ten thousand that it is the other side all the same
  constexpr auto scale = static_cast<Eigen::Index>(BiasTerm::ScaleAzimuth);
  const Vec<3> per_azimuth = by.col(static_cast<Eigen::Index>(BiasTerm::OffsetAzimuth));
  const double square = per_azimuth.squaredNorm();
  if (square == 0) return Mat<3, 3>::Zero();
  // Where the radar stands and what its clock says decide on which side it sees the target; what the instrument adds to
  // the angle comes after.
  Vec<bias_term_count> to_the_side = by.transpose() * per_azimuth / square;
  to_the_side.segment<6>(static_cast<Eigen::Index>(BiasTerm::OffsetRange)).setZero();
  const double sigma = std::sqrt(to_the_side.dot(bias.cov * to_the_side));
  if (std::numbers::pi - std::abs(azimuth_from_south(by)) > sigmas * sigma) return Mat<3, 3>::Zero();
  const Vec<3> turn = 2 * std::numbers::pi * per_azimuth;
  return (bias.cov(scale, scale) + bias.mean[scale] * bias.mean[scale]) * turn * turn.transpose();
}

Threshold::Threshold() : three_(chi2_quantile(1 - false_alarm, 3)), two_(chi2_quantile(1 - false_alarm, 2)) {}

double Threshold::ratio(const Vec<3>& d, const Mat<3, 3>& S, bool ranged, Vec<3>* whitened) const {
  Vec<3> e = d;
  Mat<3, 3> C = S;
  if (!ranged) {
    e[0] = 0;
    C.row(0).setZero();
    C.col(0).setZero();
    C(0, 0) = 1;
  }
  const Eigen::LLT<Mat<3, 3>> llt(C);
  if (llt.info() != Eigen::Success || !e.allFinite()) return std::numeric_limits<double>::infinity();
  const Vec<3> u = llt.matrixL().solve(e);
  if (whitened != nullptr) *whitened = u;
  return u.squaredNorm() / chi2(ranged);
}

}  // namespace downrange::integrity
