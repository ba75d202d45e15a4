/// The hot steps, each beside what it is made of: read the ratios of one run, not the seconds.
#include <benchmark/benchmark.h>

#include <archive/writer.hpp>
#include <downrange/est/filter/async_fusion.hpp>
#include <downrange/est/method/method.hpp>
#include <downrange/est/model/impact.hpp>
#include <downrange/est/model/motion.hpp>
#include <downrange/geo/earth.hpp>
#include <downrange/stage/engine.hpp>
#include <filesystem>
#include <limits>
#include <numbers>

#include "../support/small_range.hpp"

namespace downrange {
namespace {

const Mat<3, 6> H = (Mat<3, 6>() << Mat<3, 3>::Identity(), Mat<3, 3>::Zero()).finished();

/// One predict and update of a 6-state filter: the unit that everything else is compared with.
void predict_and_update(benchmark::State& state) {
  Gaussian<6> x{Vec<6>::Zero(), Mat<6, 6>::Identity() * 1e4};
  const Mat<3, 3> R = Mat<3, 3>::Identity() * 625;
  for (auto _ : state) {
    x = kalman_update<6, 3>(cv::predict(x, 0.05, 1000), Vec<3>::Ones(), H, R, std::numeric_limits<double>::infinity())
            .posterior;
    benchmark::DoNotOptimize(x);
  }
}
BENCHMARK(predict_and_update);

/// A batch of n positions fused at once.
void fuse_batch(benchmark::State& state) {
  std::vector<TimedPosition> batch(static_cast<std::size_t>(state.range(0)));
  for (std::size_t i = 0; i < batch.size(); ++i)
    batch[i] = {0.01 * static_cast<double>(i), Vec<3>::Ones(), Mat<3, 3>::Identity() * 625};
  const Gaussian<6> x{Vec<6>::Zero(), Mat<6, 6>::Identity() * 1e4};
  for (auto _ : state) benchmark::DoNotOptimize(fuse_asynchronous(x, 0.2, batch, 1000));
}
BENCHMARK(fuse_batch)->Arg(1)->Arg(2)->Arg(4)->Arg(8);

void convert_plot(benchmark::State& state) {
  Polar q{3e5, 1.0, 0.3};
  for (auto _ : state) {
    q.range_m += 1;
    benchmark::DoNotOptimize(convert_unbiased(q, {25, 1.7e-4, 1.7e-4}));
  }
}
BENCHMARK(convert_plot);

/// A track over the sea south of Naro, or nearly in an orbit; velocity east, north, up.
Gaussian<6> falling(double height_m, const Eigen::Vector3d& enu_m_s, double sigma_m_s) {
  const Geodetic g{33 * test::deg, 127.8 * test::deg, height_m};
  Gaussian<6> x;
  x.mean << ecef_from_geodetic(g).m, (enu_from_ecef_at(g).inverse() * Velocity<Enu>{enu_m_s}).m_s;
  x.cov.setZero();
  x.cov.diagonal() << 400, 400, 400, Vec<3>::Constant(sigma_m_s * sigma_m_s);
  return x;
}

/// Point and ellipse; minutes of flight beside each.
void impact_of_state(benchmark::State& state, Gaussian<6> x) {
  for (auto _ : state) {
    x.mean[0] += 1e-3;
    benchmark::DoNotOptimize(impact_of(x, {}));
  }
}
BENCHMARK_CAPTURE(impact_of_state, 7_min, falling(140e3, {250, -2000, 1500}, 0.3));
BENCHMARK_CAPTURE(impact_of_state, 45_min, falling(300e3, {100, -900, 6500}, 0.3));
BENCHMARK_CAPTURE(impact_of_state, by_sigma_points, falling(180e3, {6900, 800, 500}, 100));
BENCHMARK_CAPTURE(impact_of_state, an_orbit, falling(400e3, {7300, 0, 0}, 0.3));

/// Against one corridor of ten corners and 8000 km around: distance of two places, way ahead, probability.
void boundary_of_impact(benchmark::State& state) {
  std::vector<GroundPoint> corners;
  for (int i = 0; i < 10; ++i) {
    const double around = i * std::numbers::pi / 5;
    corners.push_back({(20 + 15 * std::cos(around)) * test::deg, (128 + 8 * std::sin(around)) * test::deg});
  }
  const GroundPolygon polygon(corners);
  const GroundPoint point{20 * test::deg, 130 * test::deg};
  const Eigen::Matrix2d cov = 1e10 * Eigen::Matrix2d::Identity();
  for (auto _ : state) {
    benchmark::DoNotOptimize(polygon.signed_distance_m(point));
    benchmark::DoNotOptimize(polygon.signed_distance_m(corners[3]));
    benchmark::DoNotOptimize(polygon.distance_ahead_m(point, 1));
    benchmark::DoNotOptimize(probability_outside(polygon, point, cov));
  }
}
BENCHMARK(boundary_of_impact);

struct Discard final : ResultSink {
  void emit(const Result& result) override { benchmark::DoNotOptimize(result.index()); }
};

/// A plot or fix through all four stages, late data and ticks included.
void engine_event(benchmark::State& state) {
  const RangeConfig range = test::small_range();
  const auto events = test::small_flight(range, 60, 1);
  for (auto _ : state) {
    Discard sink;
    Engine engine(range, {}, sink);
    for (const Event& e : events) engine.handle(engine.admit(e));
  }
  state.SetItemsProcessed(state.iterations() * static_cast<std::int64_t>(events.size()));
}
BENCHMARK(engine_event)->Unit(benchmark::kMillisecond);

/// The same with everything written to an archive.
void engine_event_recorded(benchmark::State& state) {
  const RangeConfig range = test::small_range();
  const auto events = test::small_flight(range, 60, 1);
  const auto path = std::filesystem::temp_directory_path() / "downrange-bench.mcap";
  struct Sink final : ResultSink {
    explicit Sink(archive::Writer& w) : writer(w) {}
    void emit(const Result& result) override { writer.write(result); }
    archive::Writer& writer;
  };
  for (auto _ : state) {
    archive::Writer writer(path, {.overwrite = true});
    Sink sink(writer);
    Engine engine(range, {}, sink);
    for (const Event& e : events) {
      const Event admitted = engine.admit(e);
      writer.write(admitted);
      engine.handle(admitted);
    }
    if (!writer.close().ok()) state.SkipWithError("the archive could not be written");
  }
  std::filesystem::remove(path);
  state.SetItemsProcessed(state.iterations() * static_cast<std::int64_t>(events.size()));
}
BENCHMARK(engine_event_recorded)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace downrange
