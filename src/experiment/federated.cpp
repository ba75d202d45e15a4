/// S. W. Hwang Bo, K. S. Hong, J. W. Choi, S. L. Choi, Maneuvering-target tracking using the federated Kalman filter
/// with multiple sensors: a target that accelerates, two sensors, filters that share information and filters that
/// notice.

#include <algorithm>
#include <array>
#include <cmath>
#include <downrange/est/filter/async_fusion.hpp>
#include <downrange/est/filter/consistency.hpp>
#include <downrange/est/filter/imm.hpp>
#include <downrange/est/filter/input_estimation.hpp>
#include <downrange/est/model/motion.hpp>
#include <downrange/est/track/track_fusion.hpp>
#include <limits>
#include <memory>
#include <string>
#include <vector>

#include "experiment/experiment.hpp"
#include "experiment/parallel.hpp"
#include "sim/random_stream.hpp"

namespace downrange::experiment {
namespace {

constexpr double no_gate = std::numeric_limits<double>::infinity();

// The paper's: manoeuvre, its time, process noise, window of 6, 3 sigma. Chosen here: the rest.
constexpr int scans = 100;
constexpr double T = 1;
constexpr double manoeuvre_from_s = 30;
constexpr double manoeuvre_to_s = 60;
constexpr double manoeuvre_m_s2 = 15;
constexpr double sigma_w = 5;  ///< m/s^2, constant over a scan
constexpr std::array<double, 2> sigma_z{100, 60};
constexpr double sigma_start_m = 50;
constexpr double sigma_start_m_s = 20;
constexpr double sigma_jerk = 2;           ///< m/s^2 a scan that an acceleration may change by
constexpr double sigma_acceleration = 15;  ///< that a manoeuvre may begin with
constexpr double mean_quiet_s = 40;        ///< between manoeuvres, of the interacting models
constexpr double mean_manoeuvre_s = 20;

using State = Gaussian<4>;  ///< position x y (m), velocity x y (m/s)

struct Model {
  Mat<4, 4> F = Mat<4, 4>::Identity();
  Mat<4, 2> B;
  Mat<4, 4> Q;
  Mat<2, 4> H = Mat<2, 4>::Identity();
  std::array<Mat<2, 2>, 2> R;
  State start;  ///< of every filter, about the true start

  Model() {
    F.topRightCorner<2, 2>().diagonal().setConstant(T);
    B << T * T / 2 * Mat<2, 2>::Identity(), T * Mat<2, 2>::Identity();
    Q = sigma_w * sigma_w * B * B.transpose();
    for (std::size_t i = 0; i < R.size(); ++i) R[i] = sigma_z[i] * sigma_z[i] * Mat<2, 2>::Identity();
    start.mean << 0, 0, 150, 100;
    start.cov.diagonal() << Vec<2>::Constant(sigma_start_m * sigma_start_m),
        Vec<2>::Constant(sigma_start_m_s * sigma_start_m_s);
    start.cov = Mat<4, 4>(start.cov.diagonal().asDiagonal());
  }
};

/// A way to track; one instance flies one run.
class Tracker {
 public:
  virtual ~Tracker() = default;
  /// One scan of both sensors.
  virtual void scan(const std::array<Vec<2>, 2>& z) = 0;
  [[nodiscard]] virtual State state() const = 0;
  /// That the target accelerates, as the tracker sees it.
  [[nodiscard]] virtual double manoeuvre_probability() const { return 0; }
};

class Centralised : public Tracker {
 public:
  explicit Centralised(const Model& model) : model_(model), x_(model.start) {}
  void scan(const std::array<Vec<2>, 2>& z) override {
    x_ = {model_.F * x_.mean, symmetric<4>(model_.F * x_.cov * model_.F.transpose() + model_.Q)};
    for (std::size_t i = 0; i < 2; ++i)
      x_ = kalman_update<4, 2>(x_, z[i] - model_.H * x_.mean, model_.H, model_.R[i], no_gate).posterior;
  }
  [[nodiscard]] State state() const override { return x_; }

 private:
  const Model& model_;
  State x_;
};

class Federated : public Tracker {
 public:
  explicit Federated(const Model& model) : model_(model), filter_(model.start, {2, 2}) {}
  void scan(const std::array<Vec<2>, 2>& z) override {
    filter_.predict(model_.F, model_.Q);
    for (int i = 0; i < 2; ++i) {
      const auto s = static_cast<std::size_t>(i);
      (void)filter_.update<2>(i, z[s] - model_.H * filter_.local(i).mean, model_.H, model_.R[s], no_gate);
    }
    (void)filter_.fuse();
  }
  [[nodiscard]] State state() const override { return filter_.state(); }

 private:
  const Model& model_;
  FederatedFilter<4, 2> filter_;
};

/// Two filters on their own; what they report is fused, by information with memory or, without sharing anything, as if
/// they were independent.
class Local : public Tracker {
 public:
  Local(const Model& model, bool with_memory)
      : model_(model), with_memory_(with_memory), x_{model.start, model.start}, fused_(model.start) {}
  void scan(const std::array<Vec<2>, 2>& z) override {
    std::array<TrackReport<4>, 2> reports;
    for (std::size_t i = 0; i < 2; ++i) {
      State& x = x_[i];
      x = {model_.F * x.mean, symmetric<4>(model_.F * x.cov * model_.F.transpose() + model_.Q)};
      reports[i].predicted = x;
      x = kalman_update<4, 2>(x, z[i] - model_.H * x.mean, model_.H, model_.R[i], no_gate).posterior;
      reports[i].updated = x;
    }
    if (with_memory_) {
      fused_ = {model_.F * fused_.mean, symmetric<4>(model_.F * fused_.cov * model_.F.transpose() + model_.Q)};
      fused_ = fuse_information<4>(fused_, reports).state;
    } else {
      fused_ = fuse_convex<4>(x_).state;
    }
  }
  [[nodiscard]] State state() const override { return fused_; }

 private:
  const Model& model_;
  bool with_memory_;
  std::array<State, 2> x_;
  State fused_;
};

class Vdie : public Tracker {
 public:
  explicit Vdie(const Model& model) : model_(model), filter_(model.start, VdieSettings{}) {}
  void scan(const std::array<Vec<2>, 2>& z) override {
    filter_.predict({.dt = T,
                     .F = model_.F,
                     .B = model_.B,
                     .Q = model_.Q,
                     .Q_input = sigma_jerk * sigma_jerk * Mat<2, 2>::Identity()});
    for (std::size_t i = 0; i < 2; ++i)
      (void)filter_.update<2>(z[i] - model_.H * filter_.state().mean, model_.H, model_.R[i], no_gate);
    filter_.decide();
  }
  [[nodiscard]] State state() const override { return filter_.state(); }
  [[nodiscard]] double manoeuvre_probability() const override { return filter_.manoeuvring() ? 1 : 0; }

 private:
  const Model& model_;
  VariableDimension<4, 2> filter_;
};

/// Interacting models: constant velocity, and a manoeuvre with a constant acceleration.
class Interacting : public Tracker {
 public:
  explicit Interacting(const Model& model) : model_(model) {
    quiet_prior_.cov = sigma_acceleration * sigma_acceleration * Mat<2, 2>::Identity();
    models_.fill(imm::augmented<6, 4>(model.start, quiet_prior_));
    const Mat<2, 2> rates =
        (Mat<2, 2>() << -1 / mean_quiet_s, 1 / mean_quiet_s, 1 / mean_manoeuvre_s, -1 / mean_manoeuvre_s).finished();
    switching_ = imm::switching_over<2>(rates, T);
  }
  void scan(const std::array<Vec<2>, 2>& z) override {
    const auto mixing = imm::mixing_weights<2>(probabilities_, switching_);
    models_ = imm::mix<6, 2>(models_, mixing);
    Vec<2> log_likelihoods = Vec<2>::Zero();
    for (int j = 0; j < 2; ++j) {
      Gaussian<6>& x = models_[static_cast<std::size_t>(j)];
      const bool manoeuvres = j == 1;
      Mat<6, 6> F = Mat<6, 6>::Identity();
      F.topLeftCorner<4, 4>() = model_.F;
      if (manoeuvres) F.topRightCorner<4, 2>() = model_.B;
      Mat<6, 6> P = F * x.cov * F.transpose();
      P.topLeftCorner<4, 4>() += model_.Q;
      if (manoeuvres) P.bottomRightCorner<2, 2>() += sigma_jerk * sigma_jerk * Mat<2, 2>::Identity();
      x = {F * x.mean, symmetric<6>(P)};
      const Mat<2, 6> H = Mat<2, 6>::Identity();
      for (std::size_t i = 0; i < 2; ++i) {
        const auto u = kalman_update<6, 2>(x, z[i] - H * x.mean, H, model_.R[i], no_gate);
        log_likelihoods[j] += imm::log_likelihood<2>(u.innovation, u.S);
        x = u.posterior;
      }
    }
    // The quiet model has no acceleration: what another model gets of it there is its own prior.
    models_[0] = imm::augmented<6, 4>(planar(models_[0]), quiet_prior_);
    probabilities_ = imm::update_probabilities<2>(mixing.predicted, log_likelihoods);
  }
  [[nodiscard]] State state() const override { return planar(imm::combine<6, 2>(models_, probabilities_)); }
  [[nodiscard]] double manoeuvre_probability() const override { return probabilities_[1]; }

 private:
  static State planar(const Gaussian<6>& x) { return {x.mean.head<4>(), x.cov.topLeftCorner<4, 4>()}; }

  const Model& model_;
  Gaussian<2> quiet_prior_;
  imm::Bank<6, 2> models_;
  Mat<2, 2> switching_;
  Vec<2> probabilities_ = Vec<2>(1, 0);
};

struct Named {
  std::string name;
  std::unique_ptr<Tracker> (*make)(const Model& model);
};
const std::vector<Named>& trackers() {
  static const std::vector<Named> all{
      {"centralised", [](const Model& m) -> std::unique_ptr<Tracker> { return std::make_unique<Centralised>(m); }},
      {"federated", [](const Model& m) -> std::unique_ptr<Tracker> { return std::make_unique<Federated>(m); }},
      {"information", [](const Model& m) -> std::unique_ptr<Tracker> { return std::make_unique<Local>(m, true); }},
      {"decentralised", [](const Model& m) -> std::unique_ptr<Tracker> { return std::make_unique<Local>(m, false); }},
      {"vdie", [](const Model& m) -> std::unique_ptr<Tracker> { return std::make_unique<Vdie>(m); }},
      {"imm", [](const Model& m) -> std::unique_ptr<Tracker> { return std::make_unique<Interacting>(m); }}};
  return all;
}

/// Squares of one tracker's errors, scan by scan; summed over runs.
struct Errors {
  std::vector<double> position = std::vector<double>(scans, 0.0);
  std::vector<double> velocity = std::vector<double>(scans, 0.0);
  std::vector<double> nees = std::vector<double>(scans, 0.0);
  std::vector<double> manoeuvre = std::vector<double>(scans, 0.0);

  Errors& operator+=(const Errors& other) {
    for (std::size_t k = 0; k < scans; ++k) {
      position[k] += other.position[k];
      velocity[k] += other.velocity[k];
      nees[k] += other.nees[k];
      manoeuvre[k] += other.manoeuvre[k];
    }
    return *this;
  }
  /// Root mean square over scans from (exclusive) to `to` seconds.
  [[nodiscard]] double rms(double from_s, double to_s, int runs) const {
    double sum = 0;
    int count = 0;
    for (std::size_t k = 0; k < scans; ++k) {
      const double t = T * static_cast<double>(k + 1);
      if (t <= from_s || t > to_s) continue;
      sum += position[k] / runs;
      ++count;
    }
    return std::sqrt(sum / count);
  }
};

struct Run {
  std::vector<Errors> errors;  ///< in the order of trackers()
  double federated_apart = 0;
  double information_apart = 0;
  double asynchronous_apart = 0;
};

/// Largest difference: means in 1-sigma, covariances relative to their largest entry.
template <int N>
double apart(const Gaussian<N>& a, const Gaussian<N>& b) {
  const double means = (a.mean - b.mean).cwiseQuotient(b.cov.diagonal().cwiseSqrt()).cwiseAbs().maxCoeff();
  return std::max(means, (a.cov - b.cov).cwiseAbs().maxCoeff() / b.cov.cwiseAbs().maxCoeff());
}

/// Asynchronous fusion of a random batch against the sequential Kalman filter over the same measurements.
double asynchronous_apart(std::uint64_t seed, int run) {
  sim::RandomStream random(seed, "asynchronous batch " + std::to_string(run));
  const double q = std::pow(10, random.uniform(0, 4));
  Gaussian<6> x;
  const Mat<6, 6> root = Mat<6, 6>::NullaryExpr([&] { return 10 * random.normal(); });
  x.cov = root * root.transpose() + Mat<6, 6>::Identity();
  x.mean << Vec<3>::NullaryExpr([&] { return 1e5 * random.normal(); }),
      Vec<3>::NullaryExpr([&] { return 1e3 * random.normal(); });

  const double interval = random.uniform(0.01, 1);
  std::vector<TimedPosition> batch(static_cast<std::size_t>(random.uniform(1, max_batch)));
  for (TimedPosition& m : batch) {
    const Mat<3, 3> noise = Mat<3, 3>::NullaryExpr([&] { return 20 * random.normal(); });
    m = {.age_s = interval * random.uniform(),
         .z = x.mean.head<3>() + Vec<3>::NullaryExpr([&] { return 30 * random.normal(); }),
         .R = noise * noise.transpose() + Mat<3, 3>::Identity()};
  }
  const Gaussian<6> fused = fuse_asynchronous(x, interval, batch, q);

  std::sort(batch.begin(), batch.end(), [](const auto& a, const auto& b) { return a.age_s > b.age_s; });
  const Mat<3, 6> H = Mat<3, 6>::Identity();
  double age = interval;
  for (const TimedPosition& m : batch) {
    x = cv::predict(x, age - m.age_s, q);
    age = m.age_s;
    x = kalman_update<6, 3>(x, m.z - H * x.mean, H, m.R, no_gate).posterior;
  }
  return apart<6>(fused, cv::predict(x, age, q));
}

Run fly(const Model& model, std::uint64_t seed, int run) {
  sim::RandomStream motion(seed, "federated motion " + std::to_string(run));
  sim::RandomStream noise(seed, "federated sensors " + std::to_string(run));
  Vec<4> truth = model.start.mean;
  for (int i = 0; i < 4; ++i) truth[i] += std::sqrt(model.start.cov(i, i)) * motion.normal();

  std::vector<std::unique_ptr<Tracker>> flying;
  for (const Named& t : trackers()) flying.push_back(t.make(model));
  Run result{.errors = std::vector<Errors>(flying.size())};
  for (std::size_t k = 0; k < scans; ++k) {
    const double t = T * static_cast<double>(k);
    const bool manoeuvres = t >= manoeuvre_from_s && t < manoeuvre_to_s;
    Vec<2> acceleration = Vec<2>::Constant(manoeuvres ? manoeuvre_m_s2 : 0);
    for (int axis = 0; axis < 2; ++axis) acceleration[axis] += sigma_w * motion.normal();
    truth = model.F * truth + model.B * acceleration;
    std::array<Vec<2>, 2> z;
    for (std::size_t i = 0; i < 2; ++i) {
      z[i] = truth.head<2>();
      for (int axis = 0; axis < 2; ++axis) z[i][axis] += sigma_z[i] * noise.normal();
    }
    for (std::size_t m = 0; m < flying.size(); ++m) {
      flying[m]->scan(z);
      const State x = flying[m]->state();
      const Vec<4> e = x.mean - truth;
      result.errors[m].position[k] = e.head<2>().squaredNorm();
      result.errors[m].velocity[k] = e.tail<2>().squaredNorm();
      result.errors[m].nees[k] = normalised_square<4>(e, x.cov) / 4;
      result.errors[m].manoeuvre[k] = flying[m]->manoeuvre_probability();
    }
    const State central = flying[0]->state();
    result.federated_apart = std::max(result.federated_apart, apart<4>(flying[1]->state(), central));
    result.information_apart = std::max(result.information_apart, apart<4>(flying[2]->state(), central));
  }
  result.asynchronous_apart = asynchronous_apart(seed, run);
  return result;
}

/// The curve of one quantity, `of` its mean over the runs.
std::vector<Curve> curves(const std::vector<Errors>& errors, const std::vector<std::string>& methods, int runs,
                          std::vector<double> Errors::*which, double (*of)(double mean)) {
  std::vector<Curve> all;
  for (std::size_t m = 0; m < errors.size(); ++m) {
    const std::string& name = trackers()[m].name;
    if (std::find(methods.begin(), methods.end(), name) == methods.end()) continue;
    Curve& curve = all.emplace_back();
    curve.label = name;
    for (std::size_t k = 0; k < scans; ++k) {
      curve.x.push_back(T * static_cast<double>(k + 1));
      curve.y.push_back(of((errors[m].*which)[k] / runs));
    }
  }
  return all;
}

double itself(double mean) { return mean; }
double root(double mean) { return std::sqrt(mean); }

}  // namespace

ExperimentResult run_federated(const ExperimentOptions& options) {
  const auto& self = *std::find_if(experiments().begin(), experiments().end(),
                                   [](const Experiment& e) { return e.name == "federated"; });
  const std::vector<std::string> methods = chosen_methods(options.methods, self.methods);
  const int runs = options.runs > 0 ? options.runs : self.runs;

  const Model model;
  const auto flown = parallel_runs<Run>(
      runs, options.jobs, [&](int run) { return fly(model, options.seed, run); }, options.progress);
  Run sum = flown.front();
  for (auto it = flown.begin() + 1; it != flown.end(); ++it) {
    for (std::size_t m = 0; m < sum.errors.size(); ++m) sum.errors[m] += it->errors[m];
    sum.federated_apart = std::max(sum.federated_apart, it->federated_apart);
    sum.information_apart = std::max(sum.information_apart, it->information_apart);
    sum.asynchronous_apart = std::max(sum.asynchronous_apart, it->asynchronous_apart);
  }
  const auto has = [&](const char* name) { return std::find(methods.begin(), methods.end(), name) != methods.end(); };
  const auto errors = [&](std::string_view name) -> const Errors& {
    const auto tracker =
        std::find_if(trackers().begin(), trackers().end(), [&](const Named& t) { return t.name == name; });
    return sum.errors[static_cast<std::size_t>(tracker - trackers().begin())];
  };

  ExperimentResult out;
  out.name = self.name;
  out.title = "Manoeuvring target, federated filter, two sensors (Hwang Bo, Hong, Choi, Choi)";
  out.runs = runs;
  out.seed = options.seed;
  out.settings = {
      {"motion",
       "constant velocity, 15 m/s^2 along x and along y from 30 to 60 s; process noise 5 m/s^2 per axis, "
       "constant over a scan, of truth and filters"},
      {"scans", "100 of 1 s (the interval is not in the paper)"},
      {"sensors", "position x, y, 1-sigma 100 m and 60 m (not in the paper)"},
      {"start", "0, 0 m, 150, 100 m/s; 1-sigma 50 m, 20 m/s per axis, drawn per run (not in the paper)"},
      {"federated", "two local filters, beta 2 and 2, fusion-reset"},
      {"vdie",
       "onsets over 6 scans, detection at chi2 0.9973 (3 sigma); acceleration random walk 2 m/s^2 a scan; quiet "
       "below chi2 0.95 twice in a row"},
      {"imm", "cv and constant acceleration, random walk 2 m/s^2 a scan, prior 15 m/s^2; 40 s quiet, 20 s manoeuvre"}};

  constexpr double identity = 1e-9;
  out.figures.push_back(at_most("asynchronous fusion = sequential filter", sum.asynchronous_apart, identity));
  if (has("federated")) out.figures.push_back(at_most("federated = centralised", sum.federated_apart, identity));
  if (has("information")) out.figures.push_back(at_most("information = centralised", sum.information_apart, identity));
  const Errors& reference = errors("centralised");
  if (has("vdie"))
    out.figures.push_back(at_most("vdie / centralised cv, position rms 38-60 s",
                                  errors("vdie").rms(38, 60, runs) / reference.rms(38, 60, runs), 0.33));
  if (has("imm"))
    out.figures.push_back(at_most("imm / centralised cv, position rms 10-100 s",
                                  errors("imm").rms(10, 100, runs) / reference.rms(10, 100, runs), 0.52));
  for (const std::string& name : methods) {
    const Errors& e = errors(name);
    out.figures.push_back(shown(name + ", position rms 10-30 s, m", e.rms(10, 30, runs)));
    out.figures.push_back(shown(name + ", position rms 38-60 s, m", e.rms(38, 60, runs)));
    out.figures.push_back(shown(name + ", position rms 70-100 s, m", e.rms(70, 100, runs)));
  }

  const auto plot = [&](const char* title, const char* y, bool log_y, std::vector<double> Errors::*which,
                        double (*of)(double)) {
    out.plots.push_back({title, "time, s", y, log_y, curves(sum.errors, methods, runs, which, of)});
  };
  plot("Position error through the manoeuvre (30-60 s)", "rms, m", false, &Errors::position, root);
  plot("Velocity error through the manoeuvre", "rms, m/s", false, &Errors::velocity, root);
  plot("Mean NEES per degree of freedom", "NEES / 4", true, &Errors::nees, itself);
  plot("Probability of a manoeuvre (vdie: share of runs)", "probability", false, &Errors::manoeuvre, itself);
  out.notes = {
      "Differences of the identities: means in 1-sigma, covariances relative to their largest entry, the largest of "
      "all "
      "runs and scans; asynchronous fusion over one random batch of 1 to 15 measurements a run.",
      "'decentralised': two filters that share nothing, fused as if independent; the common process noise makes it "
      "over-confident.",
      "The paper prints curves without numbers; measurement noise, scan interval and start are chosen here."};
  return out;
}

}  // namespace downrange::experiment
