#include <algorithm>
#include <cmath>
#include <downrange/geo/polar.hpp>
#include <string>

#include "experiment/kim2011_scenario.hpp"
#include "sim/random_stream.hpp"

namespace downrange::experiment::kim2011 {
namespace {

Vec<2> position_of(int sensor) { return {sensor == 0 ? 0.0 : 10e3, 0}; }

std::array<Vec<4>, targets> start_truth() {
  std::array<Vec<4>, targets> x;
  std::size_t t = 0;
  for (int row = 0; row < 4; ++row) {
    for (int column = 0; column < 8; ++column) x[t++] << -15e3 + 6e3 * column, 10e3 + 10e3 * row, 20, 20;
  }
  std::ranges::stable_sort(x, {}, [](const Vec<4>& a) { return a.head<2>().squaredNorm(); });
  return x;
}

template <int N>
Vec<N> noise(sim::RandomStream& random) {
  Vec<N> w;
  for (int i = 0; i < N; ++i) w[i] = random.normal();
  return w;
}

}  // namespace

Vec<terms> true_bias() { return {20, 2e-3, 3e-5, 2e-4}; }

Gaussian<biases> bias_prior() {
  Vec<biases> sigma;
  sigma << 100, 0.2, 0.01, 0.1, 100, 0.2, 0.01, 0.1;
  return {Vec<biases>::Zero(), sigma.cwiseAbs2().asDiagonal()};
}

Mat<4, 4> start_covariance() { return Vec<4>(100, 100, 25, 25).asDiagonal(); }

Mat<4, 4> transition(double dt) {
  Mat<4, 4> Phi = Mat<4, 4>::Identity();
  Phi.topRightCorner<2, 2>().diagonal().setConstant(dt);
  return Phi;
}

Mat<4, 4> process_noise(double dt) {
  Mat<4, 4> Q;
  Q << dt * dt * dt / 3 * Mat<2, 2>::Identity(), dt * dt / 2 * Mat<2, 2>::Identity(),
      dt * dt / 2 * Mat<2, 2>::Identity(), dt * Mat<2, 2>::Identity();
  return q_m2_s3 * Q;
}

PlanarPlot predict_plot(int sensor, const Vec<4>& x, const Vec<terms>& beta) {
  const Vec<2> d = x.head<2>() - position_of(sensor);
  const double r = d.norm();
  const Vec<2> polar(r, std::atan2(d.y(), d.x()));
  PlanarPlot p;
  p.q = polar + beta.head<2>() + beta.tail<2>().cwiseProduct(polar);
  p.d_state.setZero();
  p.d_state.leftCols<2>() << d.transpose() / r, Vec<2>(-d.y(), d.x()).transpose() / (r * r);
  p.d_state = (Vec<2>::Ones() + beta.tail<2>()).asDiagonal() * p.d_state;
  p.d_bias << Mat<2, 2>::Identity(), Mat<2, 2>(polar.asDiagonal());
  return p;
}

Vec<2> residual(const Vec<2>& plot, const Vec<2>& predicted) {
  return {plot[0] - predicted[0], wrap_pi(plot[1] - predicted[1])};
}

Mat<2, 2> plot_noise() {
  return Vec<2>(sigma_range_m * sigma_range_m, sigma_azimuth_rad * sigma_azimuth_rad).asDiagonal();
}

BiasedPosition<2, terms> converted(int sensor, const Vec<2>& plot) {
  const double c = std::cos(plot[1]);
  const double s = std::sin(plot[1]);
  Mat<2, 2> B;  // (4)
  B << c, -plot[0] * s, s, plot[0] * c;
  Mat<2, terms> C;  // (3)
  C << Mat<2, 2>::Identity(), Mat<2, 2>(plot.asDiagonal());
  const Mat<2, 2> R = B * plot_noise() * B.transpose();
  return {position_of(sensor) + plot[0] * Vec<2>(c, s), B * C, (R + R.transpose()) / 2};
}

Draw draw(std::uint64_t seed, int run) {
  const auto stream = [&](const char* of) { return sim::RandomStream(seed, "kim2011 " + std::to_string(run) + of); };
  sim::RandomStream motion = stream(" motion");
  sim::RandomStream plot = stream(" plots");
  sim::RandomStream start = stream(" start");
  const Mat<4, 4> Phi = transition(scan_s);
  const Mat<4, 4> root_Q = process_noise(scan_s).llt().matrixL();
  const Vec<2> sigma = plot_noise().diagonal().cwiseSqrt();

  Draw d;
  d.truth.resize(scans + 1);
  d.plots.resize(scans + 1);
  d.truth[0] = start_truth();
  for (auto& of_sensor : d.start) {
    for (std::size_t t = 0; t < targets; ++t)
      of_sensor[t] = d.truth[0][t] + start_covariance().diagonal().cwiseSqrt().cwiseProduct(noise<4>(start));
  }
  for (int k = 1; k <= scans; ++k) {
    for (std::size_t t = 0; t < targets; ++t) {
      d.truth[k][t] = Phi * d.truth[k - 1][t] + root_Q * noise<4>(motion);
      d.plots[k][t] = predict_plot(sensor_of(k), d.truth[k][t], true_bias()).q + sigma.cwiseProduct(noise<2>(plot));
    }
  }
  return d;
}

}  // namespace downrange::experiment::kim2011
