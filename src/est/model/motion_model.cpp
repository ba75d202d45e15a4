#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <downrange/est/model/motion_model.hpp>
#include <downrange/geo/earth.hpp>

namespace downrange {
namespace {

constexpr double longest_step_s = 1;

Vec<9> constant_third_part(const Vec<9>& x, double dt, const Vec<3>& acceleration) {
  Vec<9> y = x;
  y.head<3>() += dt * x.segment<3>(3) + dt * dt / 2 * acceleration;
  y.segment<3>(3) += dt * acceleration;
  return y;
}

}  // namespace

Vec<3> acceleration(const MotionModel& model, const Vec<9>& x) {
  if (!model.gravity_aware) return x.tail<3>();
  return free_fall_acceleration({x.head<3>()}, {x.segment<3>(3)}) + x.tail<3>();
}

Vec<9> predict_mean(const MotionModel& model, const Vec<9>& x, double dt) {
  if (!model.gravity_aware) return constant_third_part(x, dt, x.tail<3>());
  const int steps = std::max(1, static_cast<int>(std::ceil(std::abs(dt) / longest_step_s)));
  const double h = dt / steps;
  Vec<9> y = x;
  for (int i = 0; i < steps; ++i) {
    const Vec<9> middle = constant_third_part(y, h / 2, acceleration(model, y));
    y = constant_third_part(y, h, acceleration(model, middle));
  }
  return y;
}

Mat<3, 3> process_noise(const MotionModel& model, double dt) {
  const double T = std::abs(dt);
  const double sign = dt < 0 ? -1 : 1;  // towards the past odd powers of dt change sign
  const double T2 = T * T;
  const double T3 = T2 * T;
  Mat<3, 3> Q = Mat<3, 3>::Zero();
  if (model.noise == MotionModel::Noise::WhiteAcceleration) {
    Q.topLeftCorner<2, 2>() << T3 / 3, sign * T2 / 2, sign * T2 / 2, T;
  } else {
    Q << T3 * T2 / 20, sign * T2 * T2 / 8, T3 / 6,  //
        sign * T2 * T2 / 8, T3 / 3, sign * T2 / 2,  //
        T3 / 6, sign * T2 / 2, T;
  }
  return model.q * Q;
}

Gaussian<9> predict(const MotionModel& model, const Gaussian<9>& x, double dt) {
  Mat<9, 9> F = Mat<9, 9>::Identity();
  F.block<3, 3>(0, 3).diagonal().setConstant(dt);
  F.block<3, 3>(3, 6).diagonal().setConstant(dt);
  F.block<3, 3>(0, 6).diagonal().setConstant(dt * dt / 2);
  const Mat<3, 3> Q = process_noise(model, dt);
  Gaussian<9> y{.mean = predict_mean(model, x.mean, dt), .cov = F * x.cov * F.transpose()};
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 3; ++column)
      y.cov.block<3, 3>(3 * row, 3 * column).diagonal().array() += Q(row, column);
  }
  return y;
}

Bridge bridge(const MotionModel& model, double since_before, double until_after) {
  const auto transition = [](double dt) {
    Mat<3, 3> F;
    F << 1, dt, dt * dt / 2, 0, 1, dt, 0, 0, 1;
    return F;
  };
  const Mat<3, 3> F = transition(until_after);
  const Mat<3, 3> Q = process_noise(model, since_before);
  const Mat<3, 3> S = F * Q * F.transpose() + process_noise(model, until_after);
  const Mat<3, 3> K = S.llt().solve(F * Q).transpose();
  const Mat<3, 3> ImKF = Mat<3, 3>::Identity() - K * F;
  const Mat<3, 3> P = ImKF * Q;
  return {.from = ImKF * transition(since_before), .to = K, .noise = (P + P.transpose()) / 2};
}

}  // namespace downrange
