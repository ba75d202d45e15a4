/// One predict and update of every filter, beside the same algebra in bare fixed-size Eigen: read the ratios.
/// tools/bench prints both.
#include <benchmark/benchmark.h>

#include <array>
#include <downrange/est/method/joint.hpp>
#include <downrange/est/method/schmidt.hpp>
#include <downrange/est/method/song2015.hpp>
#include <downrange/est/method/ts.hpp>
#include <numbers>
#include <random>

namespace downrange {
namespace {

constexpr double deg = std::numbers::pi / 180;

Position<Ecef> truth_at(double t) {
  static const Site centre({34.4 * deg, 127.0 * deg, 0});
  return centre.ecef_of({{9e4 * std::sin(t / 300), 9e4 * std::cos(t / 300), 5e4 + 5e3 * std::sin(t / 170)}});
}

MethodSettings settings_of(int radars, int targets, Kinematics kinematics) {
  MethodSettings s;
  s.targets = targets;
  s.stations = 1;
  s.motion.kinematics = kinematics;
  s.arbitration.gate_probability = 1;
  s.gps.no_gps.enabled = false;
  for (int i = 0; i < radars; ++i) {
    RadarModel radar;
    radar.site = Site({(34 + 0.1 * i) * deg, (126 + 0.2 * i) * deg, 100});
    radar.sigma = {25, 0.02 * deg, 0.02 * deg};
    s.radars.push_back(radar);
  }
  return s;
}

/// Plots of all radars and targets in turn, 50 ms apart, for as long as asked for; every 20th measurement is a fix.
class Plots {
 public:
  explicit Plots(const MethodSettings& s) : settings_(s) {}

  const Measurement& next() {
    const double t = 0.05 * static_cast<double>(++count_);
    const auto radars = static_cast<std::uint64_t>(settings_.radars.size());
    m_.epoch = Time{} + seconds(t);
    m_.sequence = count_;
    m_.target = static_cast<int>(count_ / radars % static_cast<std::uint64_t>(settings_.targets));
    if (count_ % 20 == 0) {
      m_.source = static_cast<int>(radars);
      m_.measured = Fix{.position = truth_at(t + 10 * m_.target), .sigma_horizontal_m = 5, .sigma_vertical_m = 5};
      return m_;
    }
    m_.source = static_cast<int>(count_ % radars);
    const RadarModel& radar = settings_.radars[static_cast<std::size_t>(m_.source)];
    Plot plot{.measured = polar_from_enu(radar.site.enu_of(truth_at(t + 10 * m_.target)))};
    plot.measured.range_m += radar.sigma.range_m * normal_(rng_);
    m_.measured = plot;
    return m_;
  }

 private:
  const MethodSettings& settings_;
  std::mt19937_64 rng_{1};
  std::normal_distribution<double> normal_;
  std::uint64_t count_ = 0;
  Measurement m_;
};

template <class Core>
void run(benchmark::State& state, const MethodSettings& settings) {
  const Core core(settings);
  typename Core::State x = core.initial();
  Plots plots(settings);
  for (int i = 0; i < 40 * settings.targets; ++i) (void)core.apply(x, plots.next());
  for (auto _ : state) benchmark::DoNotOptimize(core.apply(x, plots.next()));
}

/// Making the plot itself: to be subtracted.
void make_plot(benchmark::State& state) {
  const MethodSettings settings = settings_of(2, 1, Kinematics::Ca);
  Plots plots(settings);
  for (auto _ : state) benchmark::DoNotOptimize(plots.next());
}
BENCHMARK(make_plot);

/// What predict and update of N states cost in plain fixed-size Eigen: motions by blocks, a Jacobian of two blocks, no
/// model of anything.
template <int N>
struct Bare {
  Vec<N> x = Vec<N>::Zero();
  Mat<N, N> P = Mat<N, N>::Identity();
  Mat<3, 9> H = Mat<3, 9>::Random();
  Mat<3, 10> G = Mat<3, 10>::Random();
  Mat<3, 3> R = Mat<3, 3>::Identity();

  template <int At>
  void predict() {
    constexpr double dt = 0.05;
    P.template middleCols<3>(At) +=
        dt * P.template middleCols<3>(At + 3) + dt * dt / 2 * P.template middleCols<3>(At + 6);
    P.template middleCols<3>(At + 3) += dt * P.template middleCols<3>(At + 6);
    P.template middleRows<3>(At) +=
        dt * P.template middleRows<3>(At + 3) + dt * dt / 2 * P.template middleRows<3>(At + 6);
    P.template middleRows<3>(At + 3) += dt * P.template middleRows<3>(At + 6);
    P.diagonal().template segment<9>(At).array() += 0.1;
  }
  template <int Motion, int Bias>
  [[nodiscard]] Mat<N, 3> PHt() const {
    return P.template middleCols<9>(Motion) * H.transpose() + P.template middleCols<10>(Bias) * G.transpose();
  }
  template <int Motion, int Bias, class Columns>
  [[nodiscard]] auto observed(const Columns& X) const {
    return (H * X.template middleRows<9>(Motion) + G * X.template middleRows<10>(Bias)).eval();
  }
  /// Returns the gain.
  Mat<N, 3> update() {
    const Mat<N, 3> cross = PHt<0, 12>();
    const Mat<3, 3> S = observed<0, 12>(cross) + R;
    const Mat<N, 3> K = S.llt().solve(cross.transpose()).transpose();
    x.noalias() += K * Vec<3>::Ones();
    P.noalias() -= K * cross.transpose();
    return K;
  }
};

/// Counterpart of joint with cv or ca: 12 states and 10 of each radar.
template <int N>
void bare_joint(benchmark::State& state) {
  static Bare<N> f;
  for (auto _ : state) {
    f.template predict<0>();
    benchmark::DoNotOptimize(f.update());
  }
}
BENCHMARK(bare_joint<32>);
BENCHMARK(bare_joint<62>);
BENCHMARK(bare_joint<112>);

/// Counterpart of joint with launch: three of them, mixed at every fourth update.
template <int N>
void bare_launch(benchmark::State& state) {
  static std::array<Bare<N>, 3> f;
  static std::array<Bare<N>, 3> mixed;
  const Mat<3, 3> weight = Mat<3, 3>::Constant(1.0 / 3);
  int n = 0;
  for (auto _ : state) {
    for (Bare<N>& mode : f) {
      mode.template predict<0>();
      benchmark::DoNotOptimize(mode.update());
    }
    if (++n % 4 != 0) continue;
    for (int to = 0; to < 3; ++to) {
      Bare<N>& out = mixed[static_cast<std::size_t>(to)];
      out.x.setZero();
      out.P.setZero();
      for (int from = 0; from < 3; ++from) out.x += weight(from, to) * f[static_cast<std::size_t>(from)].x;
      for (int from = 0; from < 3; ++from) {
        const Bare<N>& mode = f[static_cast<std::size_t>(from)];
        const Vec<N> d = mode.x - out.x;
        out.P += weight(from, to) * (mode.P + d * d.transpose());
      }
    }
    std::swap(f, mixed);
  }
}
BENCHMARK(bare_launch<32>);
BENCHMARK(bare_launch<62>);
BENCHMARK(bare_launch<112>);

/// Counterpart of joint with vdie: beside the filter the effects of three accelerations since six onsets.
template <int N>
void bare_vdie(benchmark::State& state) {
  static Bare<N> f;
  static std::array<Mat<N, 3>, 6> W;
  for (auto _ : state) {
    f.template predict<0>();
    const Mat<N, 3> K = f.update();
    for (Mat<N, 3>& effect : W) {
      effect.template topRows<3>() += 0.05 * effect.template middleRows<3>(3);
      const Mat<3, 3> seen = f.template observed<0, 12>(effect);
      effect.noalias() -= K * seen;
    }
    benchmark::DoNotOptimize(W);
  }
}
BENCHMARK(bare_vdie<32>);
BENCHMARK(bare_vdie<62>);
BENCHMARK(bare_vdie<112>);

/// Counterpart of schmidt: two motions and the GPS error, each plot compared with both.
template <int N>
void bare_schmidt(benchmark::State& state) {
  static Bare<N> f;
  for (auto _ : state) {
    f.template predict<0>();
    f.template predict<9>();
    Mat<N, 6> cross;
    cross << f.template PHt<0, 21>(), f.template PHt<9, 21>();
    Mat<6, 6> S;
    S << f.template observed<0, 21>(cross), f.template observed<9, 21>(cross);
    S.diagonal().array() += 1;
    Mat<N, 6> K = S.llt().solve(cross.transpose()).transpose();
    f.x.noalias() += K * Vec<6>::Ones();
    f.P.noalias() -= K * cross.transpose();
    benchmark::DoNotOptimize(f.P);
  }
}
BENCHMARK(bare_schmidt<41>);
BENCHMARK(bare_schmidt<71>);
BENCHMARK(bare_schmidt<121>);

/// Counterpart of ts with two radars: one target with the biases.
BENCHMARK(bare_joint<30>)->Name("bare_ts<30>");

/// Counterpart of song2015: GPS predicted to the plot, a bias filter of six states, and the plots of an interval of 0.1
/// s (two of them, 50 ms apart) fused in one stacked update.
void bare_song2015(benchmark::State& state) {
  static Gaussian<6> bias;
  static Gaussian<6> track;
  static Gaussian<6> gps;
  const Mat<3, 6> C = Mat<3, 6>::Random();
  const Mat<6, 6> A = Mat<6, 6>::Random();
  Mat<6, 6> F = Mat<6, 6>::Identity();
  F.topRightCorner<3, 3>().diagonal().setConstant(0.05);
  const auto update = [](Gaussian<6>& x, const auto& H, const auto& R) {
    const auto PHt = (x.cov * H.transpose()).eval();
    const auto S = (H * PHt + R).eval();
    const auto K = S.llt().solve(PHt.transpose()).transpose().eval();
    const Mat<6, 6> ImKH = Mat<6, 6>::Identity() - K * H;
    x.mean += K.rowwise().sum();
    x.cov = ImKH * x.cov * ImKH.transpose() + K * R * K.transpose();
  };
  for (auto _ : state) {
    for (Gaussian<6>* x : {&gps, &track}) {
      x->mean = F * x->mean;
      x->cov = F * x->cov * F.transpose() + 0.1 * Mat<6, 6>::Identity();
    }
    update(bias, C, Mat<3, 3>(Mat<3, 3>::Identity() + gps.cov.topLeftCorner<3, 3>()));
    update(track, A, Mat<6, 6>(Mat<6, 6>::Identity()));
    gps.cov.setIdentity();
    benchmark::DoNotOptimize(bias);
    benchmark::DoNotOptimize(track);
  }
}
BENCHMARK(bare_song2015);

template <Kinematics kinematics>
void joint(benchmark::State& state) {
  run<Joint>(state, settings_of(static_cast<int>(state.range(0)), 1, kinematics));
}
BENCHMARK(joint<Kinematics::Cv>)->Name("joint_cv/radars")->Arg(2)->Arg(5)->Arg(10);
BENCHMARK(joint<Kinematics::Ca>)->Name("joint_ca/radars")->Arg(2)->Arg(5)->Arg(10);
BENCHMARK(joint<Kinematics::Launch>)->Name("joint_launch/radars")->Arg(2)->Arg(5)->Arg(10);
BENCHMARK(joint<Kinematics::Vdie>)->Name("joint_vdie/radars")->Arg(2)->Arg(5)->Arg(10);

/// The same with the noise kept as it is configured: read the ratio, it is what learning costs.
template <Kinematics kinematics>
void joint_noise_kept(benchmark::State& state) {
  MethodSettings settings = settings_of(static_cast<int>(state.range(0)), 1, kinematics);
  settings.noise.enabled = false;
  run<Joint>(state, settings);
}
BENCHMARK(joint_noise_kept<Kinematics::Ca>)->Name("joint_ca_noise_kept/radars")->Arg(2)->Arg(5)->Arg(10);
BENCHMARK(joint_noise_kept<Kinematics::Launch>)->Name("joint_launch_noise_kept/radars")->Arg(2)->Arg(5)->Arg(10);

void schmidt(benchmark::State& state) {
  run<Schmidt>(state, settings_of(static_cast<int>(state.range(0)), 1, Kinematics::Ca));
}
BENCHMARK(schmidt)->Name("schmidt_ca/radars")->Arg(2)->Arg(5)->Arg(10);

void song2015(benchmark::State& state) {
  MethodSettings settings = settings_of(static_cast<int>(state.range(0)), 1, Kinematics::Cv);
  const Song2015 core(settings, true);
  Song2015::State x = core.initial();
  Plots plots(settings);
  for (int i = 0; i < 40; ++i) (void)core.apply(x, plots.next());
  for (auto _ : state) benchmark::DoNotOptimize(core.apply(x, plots.next()));
}
BENCHMARK(song2015)->Name("song2015/radars")->Arg(2)->Arg(5)->Arg(10);

/// Per update: constant where the cost of a scan is linear in the targets.
void ts(benchmark::State& state) {
  run<Ts<9>>(state, settings_of(2, static_cast<int>(state.range(0)), Kinematics::Ca));
}
BENCHMARK(ts)->Name("ts/targets")->Arg(10)->Arg(100)->Arg(1000);

}  // namespace
}  // namespace downrange
