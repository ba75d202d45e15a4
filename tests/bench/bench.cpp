/// The hot steps, each beside what it is made of: read the ratios of one run, not the seconds.
#include <benchmark/benchmark.h>

#include <archive/writer.hpp>
#include <downrange/est/filter/async_fusion.hpp>
#include <downrange/est/method/method.hpp>
#include <downrange/est/model/motion.hpp>
#include <downrange/stage/engine.hpp>
#include <filesystem>
#include <limits>

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
