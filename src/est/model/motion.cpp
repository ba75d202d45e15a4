#include <cmath>
#include <downrange/est/model/motion.hpp>

namespace downrange::cv {

Mat<6, 6> transition(double dt) {
  Mat<6, 6> F = Mat<6, 6>::Identity();
  F.topRightCorner<3, 3>().diagonal().setConstant(dt);
  return F;
}

Mat<6, 6> process_noise(double dt, double q) {
  const double T = std::abs(dt);
  const double sign = dt < 0 ? -1 : 1;  // backwards the position error falls as the velocity error rises
  Mat<6, 6> Q = Mat<6, 6>::Zero();
  Q.topLeftCorner<3, 3>().diagonal().setConstant(q * T * T * T / 3);
  Q.topRightCorner<3, 3>().diagonal().setConstant(sign * q * T * T / 2);
  Q.bottomLeftCorner<3, 3>().diagonal().setConstant(sign * q * T * T / 2);
  Q.bottomRightCorner<3, 3>().diagonal().setConstant(q * T);
  return Q;
}

Gaussian<6> predict(const Gaussian<6>& x, double dt, double q) {
  // Block form of F P F' + Q with F = [I dt I; 0 I].
  const Mat<3, 3> Ppp = x.cov.topLeftCorner<3, 3>();
  const Mat<3, 3> Ppv = x.cov.topRightCorner<3, 3>();
  const Mat<3, 3> Pvv = x.cov.bottomRightCorner<3, 3>();
  Gaussian<6> y;
  y.mean << x.mean.head<3>() + dt * x.mean.tail<3>(), x.mean.tail<3>();
  y.cov.topLeftCorner<3, 3>() = Ppp + dt * (Ppv + Ppv.transpose()) + dt * dt * Pvv;
  y.cov.topRightCorner<3, 3>() = Ppv + dt * Pvv;
  y.cov.bottomLeftCorner<3, 3>() = y.cov.topRightCorner<3, 3>().transpose();
  y.cov.bottomRightCorner<3, 3>() = Pvv;
  y.cov += process_noise(dt, q);
  return y;
}

}  // namespace downrange::cv
