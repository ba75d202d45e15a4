/// One predict and update of every filter, beside bare fixed-size Eigen of the same number of states: read the ratios.
#include <benchmark/benchmark.h>

#include <downrange/est/joint.hpp>
#include <downrange/est/schmidt.hpp>
#include <downrange/est/ts.hpp>
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
  s.kinematics = kinematics;
  s.gate_probability = 1;
  s.no_gps.enabled = false;
  for (int i = 0; i < radars; ++i) {
    RadarModel radar;
    radar.site = Site({(34 + 0.1 * i) * deg, (126 + 0.2 * i) * deg, 100});
    radar.sigma = {25, 0.02 * deg, 0.02 * deg};
    s.radars.push_back(radar);
  }
  return s;
}

/// Plots of all radars and targets in turn, 50 ms apart, for as long as asked for.
class Plots {
 public:
  explicit Plots(const MethodSettings& s) : settings_(s) {}

  const Measurement& next() {
    const double t = 0.05 * static_cast<double>(++count_);
    const auto radars = static_cast<std::uint64_t>(settings_.radars.size());
    m_.epoch = Time{} + seconds(t);
    m_.sequence = count_;
    m_.source = static_cast<int>(count_ % radars);
    m_.target = static_cast<int>(count_ / radars % static_cast<std::uint64_t>(settings_.targets));
    const RadarModel& radar = settings_.radars[static_cast<std::size_t>(m_.source)];
    m_.plot = polar_from_enu(radar.site.enu_of(truth_at(t + 10 * m_.target)));
    m_.plot.range_m += radar.sigma.range_m * normal_(rng_);
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

/// What a predict and update of N states costs in plain fixed-size Eigen: motion by blocks, a Jacobian of two blocks,
/// no model of anything.
template <int N>
void bare_eigen(benchmark::State& state) {
  static Vec<N> x = Vec<N>::Zero();
  static Mat<N, N> P = Mat<N, N>::Identity();
  const Mat<3, 9> H = Mat<3, 9>::Random();
  const Mat<3, 10> G = Mat<3, 10>::Random();
  const Mat<3, 3> R = Mat<3, 3>::Identity();
  const double dt = 0.05;
  for (auto _ : state) {
    P.template middleCols<3>(0) += dt * P.template middleCols<3>(3) + dt * dt / 2 * P.template middleCols<3>(6);
    P.template middleCols<3>(3) += dt * P.template middleCols<3>(6);
    P.template middleRows<3>(0) += dt * P.template middleRows<3>(3) + dt * dt / 2 * P.template middleRows<3>(6);
    P.template middleRows<3>(3) += dt * P.template middleRows<3>(6);
    P.diagonal().template head<9>().array() += 0.1;
    const Mat<N, 3> PHt = P.template leftCols<9>() * H.transpose() + P.template middleCols<10>(12) * G.transpose();
    const Mat<3, 3> S = H * PHt.template topRows<9>() + G * PHt.template middleRows<10>(12) + R;
    const Mat<N, 3> K = S.llt().solve(PHt.transpose()).transpose();
    x.noalias() += K * Vec<3>::Ones();
    P.noalias() -= K * PHt.transpose();
    benchmark::DoNotOptimize(P);
  }
}
BENCHMARK(bare_eigen<32>);
BENCHMARK(bare_eigen<62>);
BENCHMARK(bare_eigen<112>);

template <Kinematics kinematics>
void joint(benchmark::State& state) {
  run<Joint>(state, settings_of(static_cast<int>(state.range(0)), 1, kinematics));
}
BENCHMARK(joint<Kinematics::Cv>)->Name("joint_cv/radars")->Arg(2)->Arg(5)->Arg(10);
BENCHMARK(joint<Kinematics::Ca>)->Name("joint_ca/radars")->Arg(2)->Arg(5)->Arg(10);
BENCHMARK(joint<Kinematics::Launch>)->Name("joint_launch/radars")->Arg(2)->Arg(5)->Arg(10);
BENCHMARK(joint<Kinematics::Vdie>)->Name("joint_vdie/radars")->Arg(2)->Arg(5)->Arg(10);

void schmidt(benchmark::State& state) {
  run<Schmidt>(state, settings_of(static_cast<int>(state.range(0)), 1, Kinematics::Ca));
}
BENCHMARK(schmidt)->Name("schmidt_ca/radars")->Arg(2)->Arg(5)->Arg(10);

/// Per update: constant where the cost of a scan is linear in the targets.
void ts(benchmark::State& state) {
  run<Ts<9>>(state, settings_of(2, static_cast<int>(state.range(0)), Kinematics::Ca));
}
BENCHMARK(ts)->Name("ts/targets")->Arg(10)->Arg(100)->Arg(1000);

}  // namespace
}  // namespace downrange
