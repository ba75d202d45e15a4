#include <downrange/est/filter/manoeuvre.hpp>

namespace downrange {
namespace {

/// Scans of the federated paper are a second; onsets are tried, and decisions taken, twice as often.
constexpr Duration scan = milliseconds(500);

constexpr VdieSettings settings;
/// Quantiles of the significance of an acceleration, found once.
double quiet_significance() {
  static const double quantile = chi2_quantile(settings.quiet_probability, 3);
  return quantile;
}
double detection_significance() {
  static const double quantile = chi2_quantile(settings.detection_probability, 3);
  return quantile;
}

}  // namespace

void Manoeuvre::clear() {
  hypotheses_.clear();
  open_ = false;
  quiet_in_row_ = 0;
}

void Manoeuvre::predict(int motion_at, double dt, double gps_error_decay) {
  if (open_) return;
  hypotheses_.predict_with(dt, [&](Transfer& W) {
    // F W + B: a unit acceleration moves position and velocity, and nothing else.
    W.middleRows<3>(motion_at) += dt * W.middleRows<3>(motion_at + 3);
    W.middleRows<3>(motion_at).diagonal().array() += dt * dt / 2;
    W.middleRows<3>(motion_at + 3).diagonal().array() += dt;
    W.middleRows<3>(motion_at + 9) *= gps_error_decay;
  });
}

void Manoeuvre::decide(Hypothesis& h, int motion_at, Time t) {
  const Time due = ceil_to_grid(decided_ + Duration{1}, scan);
  if (t < due) return;
  decided_ = t;
  const int a = motion_at + 6;
  if (open_) {
    const Vec<3> u = h.x.segment<3>(a);
    const double significance = u.dot(h.P.block<3, 3>(a, a).llt().solve(u));
    quiet_in_row_ = significance <= quiet_significance() ? quiet_in_row_ + 1 : 0;
    if (quiet_in_row_ < settings.quiet_scans) return;
    const Vec<3> none = Vec<3>::Zero();
    const Mat<3, 3> certain = Mat<3, 3>::Zero();
    reset_block(h, a, none, certain);
    clear();
  } else if (const auto found = hypotheses_.best(); found && found->significance > detection_significance()) {
    const Transfer& W = hypotheses_.transfer(found->hypothesis);
    const Columns<3> cross = W * found->R_u;
    h.x.noalias() += W * found->u;
    h.P.noalias() += cross * W.transpose();
    h.P.triangularView<Eigen::StrictlyUpper>() = h.P.transpose();
    h.x.segment<3>(a) = found->u;
    h.P.middleCols<3>(a) = cross;
    h.P.middleRows<3>(a) = h.P.middleCols<3>(a).transpose();
    h.P.block<3, 3>(a, a) = found->R_u;
    open_ = true;
    quiet_in_row_ = 0;
    return;
  }
  hypotheses_.open();
}

}  // namespace downrange
