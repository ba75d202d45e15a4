// own_method FOLDER: a method that the library does not know, registered at run time, flown beside joint. Ends with how
// far each is from truth.csv.
//
// The method ("plain-cv") is the plainest there is: a constant-velocity Kalman filter per target over the plots of all
// radars. No biases, no GPS. What a method is asked for: downrange/est/method/method.hpp; what keeps late data in
// order: rewind.hpp.

#include <cmath>
#include <cstdio>
#include <downrange/est/filter/consistency.hpp>
#include <downrange/est/method/method_table.hpp>
#include <downrange/est/method/source_checks.hpp>
#include <downrange/est/model/motion.hpp>
#include <downrange/stage/engine.hpp>
#include <exception>
#include <map>

#include "csv_flight.hpp"

namespace {

using namespace downrange;

class PlainCv {
 public:
  // All that changes: copied for the history, so that a late plot can be put into its place.
  struct Track {
    bool started = false;
    Time epoch;
    Gaussian<6> state;
    double nis = 0;
  };
  struct State {
    std::vector<Track> tracks;  // per target
    std::vector<SourceAccount> accounts;
  };

  explicit PlainCv(MethodSettings settings)
      : settings_(std::move(settings)), gate_(chi2_quantile(settings_.arbitration.gate_probability, 3)) {}

  State initial() const {
    return {
        .tracks = std::vector<Track>(static_cast<std::size_t>(settings_.targets)),
        .accounts = std::vector<SourceAccount>(settings_.radars.size() + static_cast<std::size_t>(settings_.stations))};
  }

  void start(State& state, int target, Time epoch, const Gaussian<9>& estimate) const {
    Track& track = state.tracks[static_cast<std::size_t>(target)];
    track = {.started = true, .epoch = epoch, .state = {}};
    track.state.mean = estimate.mean.head<6>();
    track.state.cov = estimate.cov.topLeftCorner<6, 6>();
  }

  Outcome apply(State& state, const Measurement& m) const {
    if (is_fix(m) || !tells_position(m.measured)) return {};
    const RadarModel& radar = settings_.radars[static_cast<std::size_t>(m.source)];
    const ConvertedMeasurement plot = convert_unbiased(plot_of(m.measured).measured, radar.sigma);
    const Mat<3, 3> R_ecef_enu = radar.site.R_enu_ecef().R.transpose();
    const Vec<3> z = radar.site.ecef_of(plot.z).m;
    const Mat<3, 3> R = R_ecef_enu * plot.R * R_ecef_enu.transpose();

    Track& track = state.tracks[static_cast<std::size_t>(m.target)];
    SourceAccount& account = state.accounts[static_cast<std::size_t>(m.source)];
    if (!track.started) {
      track = {.started = true, .epoch = m.epoch, .state = {}};
      track.state.mean << z, Vec<3>::Zero();
      const double sigma_v = settings_.start.sigma_velocity_m_s;
      track.state.cov << R, Mat<3, 3>::Zero(), Mat<3, 3>::Zero(), sigma_v * sigma_v * Mat<3, 3>::Identity();
      count(account, {});
      return {};
    }
    const Gaussian<6> predicted =
        cv::predict(track.state, (m.epoch - track.epoch).seconds(), settings_.motion.q_cv_m2_s3);
    const Mat<3, 6> H = (Mat<3, 6>() << Mat<3, 3>::Identity(), Mat<3, 3>::Zero()).finished();
    const auto update = kalman_update<6, 3>(predicted, z - predicted.mean.head<3>(), H, R, gate_);
    const Outcome outcome{.verdict = update.verdict, .nis = update.nis, .dof = 3};
    count(account, outcome);
    if (outcome.verdict != Verdict::Accepted) return outcome;
    note_innovation<3>(account, update.innovation, update.S, update.nis);
    track.state = update.posterior;
    track.epoch = m.epoch;
    track.nis = update.nis;
    return outcome;
  }

  std::optional<TrackEstimate> fused(const State& state, int target, std::optional<Time> at) const {
    const Track& track = state.tracks[static_cast<std::size_t>(target)];
    if (!track.started) return std::nullopt;
    TrackEstimate e;
    e.epoch = at.value_or(track.epoch);
    e.data_epoch = track.epoch;
    const Gaussian<6> predicted =
        cv::predict(track.state, (e.epoch - track.epoch).seconds(), settings_.motion.q_cv_m2_s3);
    e.mean.head<6>() = predicted.mean;
    e.cov.topLeftCorner<6, 6>() = predicted.cov;
    e.nis = track.nis;
    e.nis_dof = 3;
    return e;
  }
  BiasEstimate bias(const State&, int) const { return {}; }
  const MethodSettings& settings() const { return settings_; }

 private:
  MethodSettings settings_;
  double gate_;
};

// The squares of each method's errors at the instants of the true trajectory's samples.
class Judge final : public ResultSink {
 public:
  explicit Judge(const std::string& folder) : truth_(example::read_rows(folder + "/truth.csv", 7)) {}

  void emit(const Result& result) override {
    const auto* t = std::get_if<Trajectory>(&result);
    if (t == nullptr) return;
    const double flown_s = (t->epoch - example::liftoff).seconds();
    const auto& row = truth_[static_cast<std::size_t>(std::lround(flown_s))];
    const double later_s = flown_s - row[0];  // less than 0.02 s: straight on
    if (flown_s < 10 || std::abs(later_s) > 0.02) return;
    Sum& sum = sums_[std::string(t->method.view())];
    for (std::size_t i = 0; i < 3; ++i) sum.squares += std::pow(t->state[i] - row[1 + i] - later_s * row[4 + i], 2);
    ++sum.count;
  }
  void print() const {
    for (const auto& [method, sum] : sums_)
      std::printf("%-10s %6.1f m rms at %d instants\n", method.c_str(), std::sqrt(sum.squares / sum.count), sum.count);
  }

 private:
  struct Sum {
    double squares = 0;
    int count = 0;
  };
  std::vector<std::vector<double>> truth_;
  std::map<std::string, Sum> sums_;
};

void fly(const std::string& folder) {
  register_method("plain-cv", [](const MethodSettings& settings) { return rewound(PlainCv(settings)); });

  RangeConfig range = example::example_range();
  range.fuse.methods = {"joint", "plain-cv"};  // antennas follow the first
  Judge judge(folder);
  Engine engine(range, StageSet{}, judge);
  for (const Event& event : example::read_flight(folder)) engine.handle(engine.admit(event));
  judge.print();
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 2) {
    std::fprintf(stderr, "usage: %s FOLDER\n", argv[0]);
    return 2;
  }
  try {
    fly(argv[1]);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 1;
  }
  return 0;
}
