#include <cassert>
#include <cmath>
#include <downrange/est/filter/hypothesis.hpp>
#include <downrange/est/method/bound.hpp>
#include <stdexcept>
#include <utility>

namespace downrange {
namespace {

constexpr int motion_at = 0;
constexpr int gps_error_at = 9;
constexpr int first_radar_at = 12;

}  // namespace

class Bound::Impl {
 public:
  Impl(const MethodSettings& settings, TrueMotion truth, std::vector<Vec<bias_term_count>> biases)
      : settings_(settings),
        truth_(std::move(truth)),
        biases_(std::move(biases)),
        model_(model_set(settings.motion).model[0]),
        layout_(bias_layout(settings.radars, first_radar_at)) {
    if (settings.motion.kinematics != Kinematics::Cv && settings.motion.kinematics != Kinematics::Ca)
      throw std::invalid_argument("the bound is that of kinematics cv or ca");
    assert(biases_.size() == settings_.radars.size());
    h_.x.setZero(first_radar_at + layout_.size);
    h_.P.setZero(h_.x.size(), h_.x.size());
    for (const RadarBlock& block : layout_.radars) reset_bias(h_, block);
    if (settings_.gps.error.enabled)
      reset_block(h_, gps_error_at, Vec<3>::Zero(), std::pow(settings_.gps.error.sigma_m, 2) * Mat<3, 3>::Identity());
  }

  void start(Time epoch, const Mat<9, 9>& cov) {
    epoch_ = epoch;
    Mat<9, 9> own = cov;
    if (model_.noise == MotionModel::Noise::WhiteAcceleration) {
      own.bottomRows<3>().setZero();
      own.rightCols<3>().setZero();
    }
    reset_block(h_, motion_at, Vec<9>::Zero(), own);
  }

  void apply(const Measurement& m) {
    const double dt = (m.epoch - epoch_).seconds();
    epoch_ = m.epoch;
    if (dt > 0) {
      predict_motion(h_, motion_at, model_, dt);
      if (settings_.gps.error.enabled)
        predict_gauss_markov(h_, gps_error_at, 3, settings_.gps.error.sigma_m, settings_.gps.error.tau_s, dt);
      predict_bias(h_, layout_, dt);
    }
    linearise_at_truth(m.epoch);
    if (is_fix(m)) {
      const Fix& fix = fix_of(m);
      if (fix.velocity_valid && settings_.gps_use.velocity) {
        add_information<6>(fix_jacobian<6>(motion_at), fix_noise<6>(fix));
      } else {
        add_information<3>(fix_jacobian<3>(motion_at), fix_noise<3>(fix));
      }
      return;
    }
    const Plot plot = plot_of(m.measured);
    const auto source = static_cast<std::size_t>(m.source);
    const RadarModel& radar = settings_.radars[source];
    const PlotLinearisation l = linearise_plot(h_, motion_at, model_, radar, layout_.radars[source], plot.measured);
    add_information<3>(l.H, plot_variance(radar, plot).asDiagonal());
  }

  [[nodiscard]] Mat<9, 9> track() const { return h_.P.block<9, 9>(motion_at, motion_at); }
  [[nodiscard]] Eigen::MatrixXd bias(int radar) const {
    const RadarBlock& block = layout_.radars[static_cast<std::size_t>(radar)];
    return h_.P.block(block.at, block.at, block.terms, block.terms);
  }

 private:
  void linearise_at_truth(Time t) {
    h_.x.setZero();
    h_.x.segment<9>(motion_at) = truth_(t);
    for (std::size_t r = 0; r < layout_.radars.size(); ++r) {
      const RadarBlock& block = layout_.radars[r];
      for (int i = 0; i < block.terms; ++i)
        h_.x[block.at + i] = biases_[r][static_cast<Eigen::Index>(block.term[static_cast<std::size_t>(i)])];
    }
  }

  template <int M>
  void add_information(const BlockJacobian<M>& H, const Mat<M, M>& R) {
    apply_evidence<M>(h_, evidence_of<M>(h_, H, Vec<M>::Zero(), R));
  }

  MethodSettings settings_;
  TrueMotion truth_;
  std::vector<Vec<bias_term_count>> biases_;
  MotionModel model_;
  BiasLayout layout_;
  Hypothesis h_;
  Time epoch_;
};

Bound::Bound(const MethodSettings& settings, TrueMotion truth, std::vector<Vec<bias_term_count>> biases)
    : impl_(std::make_unique<Impl>(settings, std::move(truth), std::move(biases))) {}
Bound::~Bound() = default;
Bound::Bound(Bound&&) noexcept = default;

void Bound::start(Time epoch, const Mat<9, 9>& cov) { impl_->start(epoch, cov); }
void Bound::apply(const Measurement& m) { impl_->apply(m); }
Mat<9, 9> Bound::track_covariance() const { return impl_->track(); }
Eigen::MatrixXd Bound::bias_covariance(int radar) const { return impl_->bias(radar); }

}  // namespace downrange
