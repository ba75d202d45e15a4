#pragma once
/// The cheap tracker: alpha-beta gains in closed form, along and across the line of sight.
///
/// B.-D. Kim, J.-S. Lee, "Performance improvement of alpha-beta tracking filter using approximate gain updates", 2006;
/// gains of P. R. Kalata 1984 (doi 10.1109/TAES.1984.310438). Motion is piecewise constant acceleration: sigma_v m/s^2,
/// constant over one interval T.

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <downrange/est/filter/gaussian.hpp>

namespace downrange {

struct AlphaBetaGains {
  double alpha = 0;
  double beta = 0;
};

/// lambda = sigma_v T^2 / sigma_w (5): acceleration over one interval against the measurement's 1-sigma.
[[nodiscard]] inline double tracking_index(double sigma_acceleration, double sigma_measurement, double T) {
  return sigma_acceleration * T * T / sigma_measurement;
}

/// Steady-state Kalman gains (6), (7), lambda >= 0, infinity allowed. With r = 4 / (4 + lambda + sqrt(lambda^2 + 8
/// lambda)) they are alpha = 1 - r^2, beta = 2 (1 - r)^2: the printed forms lose all digits for a large index, these
/// none. Equal to the Riccati steady state to 1e-12.
[[nodiscard]] AlphaBetaGains exact_gains(double lambda);

/// d alpha / d lambda (19) and d beta / d lambda (20), lambda > 0.
[[nodiscard]] AlphaBetaGains gain_slopes(double lambda);

/// Where gains are kept: alpha in (0, 1) and beta no larger than the exact one of that alpha. Both poles then stay
/// inside the unit circle, the alternating one above -0.9, whatever the index. (Unclamped, the linear update near the
/// radar has alpha > 1 and diverges.)
[[nodiscard]] AlphaBetaGains clamped(const AlphaBetaGains& gains);

/// How a tracker finds its gains each scan.
enum class GainRule : std::uint8_t {
  Exact,   ///< by the index of this scan; default
  Linear,  ///< nominal + slope (lambda - nominal index), eq. (29)-(33); about the nominal, never recursive
  Fixed,   ///< those of the nominal index
};

/// Clamped gains by `rule` at index `lambda`, for the nominal index `nominal` (unused by Exact).
[[nodiscard]] AlphaBetaGains gains_by(GainRule rule, double lambda, double nominal);

/// Covariance of [position, velocity] after an update, of the exact gains' filter in its steady state, from the gains
/// alone (Bar-Shalom, Fortmann 1988): sigma_w^2 [[alpha, beta/T], [., beta (alpha - beta/2) / ((1 - alpha) T^2)]].
[[nodiscard]] Mat<2, 2> steady_covariance(const AlphaBetaGains& gains, double sigma_measurement, double T);

/// Axes of a line of sight, columns: along it, then across. In the plane: along (x, y), across to the left. In space:
/// along (east, north, up), across with growing azimuth, across with growing elevation. At the sensor itself and at
/// the zenith, where they are undefined, azimuth is 0.
template <int D>
[[nodiscard]] Mat<D, D> line_of_sight_axes(const Vec<D>& d);

/// Normalised position error: rms of the estimates' errors over rms of the measurements'. Above 1 the track is lost.
struct NormalisedPositionError {
  double estimate_square = 0;
  double measurement_square = 0;

  void add(double estimate_error_m, double measurement_error_m) {
    estimate_square += estimate_error_m * estimate_error_m;
    measurement_square += measurement_error_m * measurement_error_m;
  }
  [[nodiscard]] double value() const { return std::sqrt(estimate_square / measurement_square); }
  [[nodiscard]] bool lost() const { return !(value() <= 1); }
};

struct AlphaBetaSettings {
  double sigma_acceleration = 10;       ///< m/s^2, constant over one interval
  double initial_sigma_velocity = 500;  ///< m/s
  GainRule rule = GainRule::Exact;
  double nominal_sigma = 0;  ///< m, per axis; of Linear and Fixed
  double gate = 0;           ///< chi2(D) quantile; 0: none
};

/// Decoupled alpha-beta tracker (Fitzgerald 1986; paper eq. 9-13) in the plane (D = 2) or in space (D = 3), about its
/// sensor. Gains are those along and across the line of sight to the predicted position. At the start an axis uses the
/// Kalman gains of its covariance until they have come down to the exact steady ones. A lost scan is a longer T.
template <int D>
class AlphaBetaTracker {
 public:
  struct Scan {
    Vec<D> innovation = Vec<D>::Zero();  ///< along the line-of-sight axes, m
    Vec<D> sigma = Vec<D>::Zero();       ///< of the innovation
    double nis = 0;
    Verdict verdict = Verdict::Accepted;
  };

  /// Starts on a first measured position; `sigma` of it along the line-of-sight axes, m.
  AlphaBetaTracker(const AlphaBetaSettings& settings, const Vec<D>& position, const Vec<D>& sigma)
      : settings_(settings), position_(position) {
    for (int i = 0; i < D; ++i) {
      at(P_, i) << sigma[i] * sigma[i], 0, 0, settings.initial_sigma_velocity * settings.initial_sigma_velocity;
    }
  }

  /// Starts on a first estimate of [position, velocity] about the sensor. Of its covariance the tracker keeps what lies
  /// along each line-of-sight axis.
  AlphaBetaTracker(const AlphaBetaSettings& settings, const Gaussian<2 * D>& estimate)
      : settings_(settings), position_(estimate.mean.template head<D>()), velocity_(estimate.mean.template tail<D>()) {
    const Mat<D, D> axes = line_of_sight_axes<D>(position_);
    const auto along = [&](int i, int row, int column) {
      return axes.col(i).dot(estimate.cov.template block<D, D>(row * D, column * D) * axes.col(i));
    };
    for (int i = 0; i < D; ++i) at(P_, i) << along(i, 0, 0), along(i, 0, 1), along(i, 1, 0), along(i, 1, 1);
  }

  [[nodiscard]] const Vec<D>& position() const { return position_; }
  [[nodiscard]] const Vec<D>& velocity() const { return velocity_; }
  /// Of the last scan, per axis.
  [[nodiscard]] const AlphaBetaGains& gains(int axis) const { return gains_[static_cast<std::size_t>(axis)]; }
  /// Covariance of [position, velocity] along one axis, after the last scan.
  [[nodiscard]] const Mat<2, 2>& covariance(int axis) const { return P_[static_cast<std::size_t>(axis)]; }

  /// [position, velocity] about the sensor T seconds after the last scan (T may be 0 or negative).
  [[nodiscard]] Gaussian<2 * D> predicted(double T) const {
    Gaussian<2 * D> x;
    x.mean << position_ + T * velocity_, velocity_;
    const Mat<D, D> axes = line_of_sight_axes<D>(x.mean.template head<D>());
    x.cov.setZero();
    for (int i = 0; i < D; ++i) {
      const Mat<2, 2> P = predict(at(P_, i), T);
      const Mat<D, D> along = axes.col(i) * axes.col(i).transpose();
      x.cov.template topLeftCorner<D, D>() += P(0, 0) * along;
      x.cov.template topRightCorner<D, D>() += P(0, 1) * along;
      x.cov.template bottomRightCorner<D, D>() += P(1, 1) * along;
    }
    x.cov.template bottomLeftCorner<D, D>() = x.cov.template topRightCorner<D, D>().transpose();
    return x;
  }

  /// One scan, T > 0 seconds after the last accepted one: measured position and its 1-sigma along the line-of-sight
  /// axes (range, range x sigma_azimuth x cos elevation, range x sigma_elevation). A gated scan changes nothing.
  Scan scan(const Vec<D>& measured, const Vec<D>& sigma, double T) {
    const Vec<D> predicted = position_ + T * velocity_;
    const Mat<D, D> axes = line_of_sight_axes<D>(predicted);
    Scan s{.innovation = axes.transpose() * (measured - predicted)};
    std::array<Mat<2, 2>, static_cast<std::size_t>(D)> prior;
    for (int i = 0; i < D; ++i) {
      at(prior, i) = predict(at(P_, i), T);
      s.sigma[i] = std::sqrt(at(prior, i)(0, 0) + sigma[i] * sigma[i]);
    }
    s.nis = s.innovation.cwiseQuotient(s.sigma).squaredNorm();
    const bool inside = settings_.gate > 0 ? s.nis <= settings_.gate : std::isfinite(s.nis);
    if (!inside) {
      s.verdict = Verdict::Gated;
      return s;
    }
    Vec<D> to_position;
    Vec<D> to_velocity;
    for (int i = 0; i < D; ++i) {
      const AlphaBetaGains g = gains_for(i, at(prior, i), sigma[i], T);
      at(gains_, i) = g;
      to_position[i] = g.alpha * s.innovation[i];
      to_velocity[i] = g.beta / T * s.innovation[i];
      at(P_, i) = updated(at(prior, i), g, sigma[i], T);
    }
    position_ = predicted + axes * to_position;
    velocity_ += axes * to_velocity;
    return s;
  }

 private:
  template <class Array>
  static auto& at(Array& a, int i) {
    return a[static_cast<std::size_t>(i)];
  }

  [[nodiscard]] Mat<2, 2> predict(const Mat<2, 2>& P, double T) const {
    const double q = settings_.sigma_acceleration * settings_.sigma_acceleration;
    Mat<2, 2> Q;
    Q << q * T * T * T * T / 4, q * T * T * T / 2, q * T * T * T / 2, q * T * T;
    Mat<2, 2> F;
    F << 1, T, 0, 1;
    return F * P * F.transpose() + Q;
  }

  AlphaBetaGains gains_for(int axis, const Mat<2, 2>& prior, double sigma, double T) {
    const double a = settings_.sigma_acceleration;
    const double lambda = tracking_index(a, sigma, T);
    bool& settled = at(settled_, axis);
    if (!settled) {
      const double S = prior(0, 0) + sigma * sigma;
      const AlphaBetaGains start = clamped({.alpha = prior(0, 0) / S, .beta = T * prior(0, 1) / S});
      constexpr double near_steady = 1.02;
      settled = start.alpha <= near_steady * clamped(exact_gains(lambda)).alpha;
      if (!settled) return start;
    }
    return gains_by(settings_.rule, lambda, tracking_index(a, settings_.nominal_sigma, T));
  }

  /// Joseph form: right for whatever gains were used.
  static Mat<2, 2> updated(const Mat<2, 2>& prior, const AlphaBetaGains& g, double sigma, double T) {
    const Vec<2> K(g.alpha, g.beta / T);
    Mat<2, 2> ImKH;
    ImKH << 1 - K[0], 0, -K[1], 1;
    const Mat<2, 2> P = ImKH * prior * ImKH.transpose() + sigma * sigma * K * K.transpose();
    return (P + P.transpose()) / 2;
  }

  AlphaBetaSettings settings_;
  Vec<D> position_;
  Vec<D> velocity_ = Vec<D>::Zero();
  std::array<Mat<2, 2>, static_cast<std::size_t>(D)> P_;
  std::array<AlphaBetaGains, static_cast<std::size_t>(D)> gains_{};
  std::array<bool, static_cast<std::size_t>(D)> settled_{};  ///< the start is over
};

}  // namespace downrange
