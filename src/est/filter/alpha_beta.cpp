#include <downrange/est/filter/alpha_beta.hpp>

namespace downrange {
namespace {

/// r = 4 / (4 + lambda + s), s = sqrt(lambda^2 + 8 lambda).
struct Root {
  double s;
  double r;
  double one_minus_r;

  explicit Root(double lambda)
      : s(std::sqrt(lambda) * std::sqrt(lambda + 8)),
        r(4 / (4 + lambda + s)),
        one_minus_r(1 / (1 + 4 / (lambda + s))) {}
};

constexpr double alpha_least = 1e-6;
constexpr double alpha_most = 0.999;  // the exact beta there is 1.876: poles at -0.87 and -0.001

}  // namespace

AlphaBetaGains exact_gains(double lambda) {
  const Root root(lambda);
  return {.alpha = root.one_minus_r * (1 + root.r), .beta = 2 * root.one_minus_r * root.one_minus_r};
}

AlphaBetaGains gain_slopes(double lambda) {
  const Root root(lambda);
  const double fall = root.r / root.s;  // -dr/d lambda
  return {.alpha = 2 * root.r * fall, .beta = 4 * root.one_minus_r * fall};
}

AlphaBetaGains clamped(const AlphaBetaGains& gains) {
  const double alpha = std::clamp(gains.alpha, alpha_least, alpha_most);
  const double one_minus_r = alpha / (1 + std::sqrt(1 - alpha));
  return {.alpha = alpha, .beta = std::clamp(gains.beta, 0.0, 2 * one_minus_r * one_minus_r)};
}

AlphaBetaGains gains_by(GainRule rule, double lambda, double nominal) {
  switch (rule) {
    case GainRule::Exact:
      break;
    case GainRule::Linear: {
      const AlphaBetaGains at_nominal = exact_gains(nominal);
      const AlphaBetaGains slope = gain_slopes(nominal);
      return clamped({.alpha = at_nominal.alpha + slope.alpha * (lambda - nominal),
                      .beta = at_nominal.beta + slope.beta * (lambda - nominal)});
    }
    case GainRule::Fixed:
      return clamped(exact_gains(nominal));
  }
  return clamped(exact_gains(lambda));
}

Mat<2, 2> steady_covariance(const AlphaBetaGains& gains, double sigma_measurement, double T) {
  const auto [alpha, beta] = gains;
  Mat<2, 2> P;
  P << alpha, beta / T, beta / T, beta * (alpha - beta / 2) / ((1 - alpha) * T * T);
  return sigma_measurement * sigma_measurement * P;
}

template <>
Mat<2, 2> line_of_sight_axes<2>(const Vec<2>& d) {
  const double r = d.norm();
  const Vec<2> along = r > 0 ? Vec<2>(d / r) : Vec<2>::UnitX();
  Mat<2, 2> axes;
  axes << along[0], -along[1], along[1], along[0];
  return axes;
}

template <>
Mat<3, 3> line_of_sight_axes<3>(const Vec<3>& d) {
  const double horizontal = std::hypot(d[0], d[1]);
  const double r = d.norm();
  const double sin_az = horizontal > 0 ? d[0] / horizontal : 0;
  const double cos_az = horizontal > 0 ? d[1] / horizontal : 1;
  const double sin_el = r > 0 ? d[2] / r : 0;
  const double cos_el = r > 0 ? horizontal / r : 1;
  Mat<3, 3> axes;
  axes << sin_az * cos_el, cos_az, -sin_az * sin_el,  //
      cos_az * cos_el, -sin_az, -cos_az * sin_el,     //
      sin_el, 0, cos_el;
  return axes;
}

}  // namespace downrange
