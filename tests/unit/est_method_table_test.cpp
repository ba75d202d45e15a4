// A method that is registered at run time is as good as one of the house: known by its name, made, run by the engine.

#include <gtest/gtest.h>

#include <algorithm>
#include <downrange/est/method/method_table.hpp>
#include <downrange/stage/engine.hpp>
#include <stdexcept>

#include "../support/small_range.hpp"

namespace downrange {
namespace {

/// The last plot, nothing else.
class LastPlot {
 public:
  struct State {
    std::vector<std::optional<Measurement>> plots;  ///< per target
    SourceAccount account;
  };

  explicit LastPlot(MethodSettings settings) : settings_(std::move(settings)) {}

  State initial() const {
    State state;
    state.plots.resize(static_cast<std::size_t>(settings_.targets));
    return state;
  }
  void start(State&, int, Time, const Gaussian<9>&) const {}
  Outcome apply(State& state, const Measurement& m) const {
    if (!is_fix(m)) state.plots[static_cast<std::size_t>(m.target)] = m;
    return {};
  }
  std::optional<TrackEstimate> fused(const State& state, int target, std::optional<Time> at) const {
    const auto& plot = state.plots[static_cast<std::size_t>(target)];
    if (!plot) return std::nullopt;
    TrackEstimate e;
    e.epoch = at.value_or(plot->epoch);
    e.data_epoch = plot->epoch;
    e.mean.head<3>() = settings_.radars[static_cast<std::size_t>(plot->source)]
                           .site.ecef_of(enu_from_polar(plot_of(plot->measured).measured))
                           .m;
    e.cov.setIdentity();
    return e;
  }
  BiasEstimate bias(const State&, int) const { return {}; }
  const SourceAccount& account(const State& state, int) const { return state.account; }
  const MethodSettings& settings() const { return settings_; }

 private:
  MethodSettings settings_;
};

std::unique_ptr<Method> make_last_plot(const MethodSettings& settings) { return rewound(LastPlot(settings)); }

class Trajectories final : public ResultSink {
 public:
  void emit(const Result& result) override {
    if (const auto* trajectory = std::get_if<Trajectory>(&result)) all.push_back(*trajectory);
  }
  std::vector<Trajectory> all;
};

TEST(MethodTable, ARegisteredMethodStandsBehindThoseOfTheHouse) {
  const std::vector<std::string_view> before = method_names();
  register_method("stands-behind", make_last_plot, {.most_radars = 3});
  std::vector<std::string_view> expected = before;
  expected.push_back("stands-behind");
  EXPECT_EQ(method_names(), expected);
  EXPECT_EQ(capabilities_of("stands-behind").most_radars, 3);
  EXPECT_NE(make_method("stands-behind", {}), nullptr);
  // What was known before a registration stays valid after many.
  const std::string_view first = method_names().front();
  for (const char* name : {"m1", "m2", "m3", "m4", "m5", "m6", "m7", "m8", "m9"}) register_method(name, make_last_plot);
  EXPECT_EQ(first, "joint");
  EXPECT_EQ(before.front().data(), method_names().front().data());
}

TEST(MethodTable, ANameIsTakenOnceAndIsOneThatAConfigurationCanSay) {
  register_method("once", make_last_plot);
  for (const char* name : {"once", "joint", "", "two words", "slash/ed", "a234567890123456789012345678901x"})
    EXPECT_THROW(register_method(name, make_last_plot), std::invalid_argument) << name;
  EXPECT_THROW(static_cast<void>(make_method("never-registered", {})), std::invalid_argument);
}

TEST(MethodTable, TheEngineRunsARegisteredMethodByItsName) {
  register_method("last-plot", make_last_plot);
  RangeConfig range = test::small_range();
  range.fuse.methods = {"last-plot"};
  Trajectories sink;
  Engine engine(range, StageSet{}, sink);
  for (std::uint64_t i = 1; i <= 3; ++i) {
    const RadarTspi plot = test::plot_at(range.radars.front(), 20 + 0.1 * static_cast<double>(i), i);
    engine.handle(engine.admit(plot));
  }
  ASSERT_EQ(sink.all.size(), 3u);
  EXPECT_EQ(sink.all.back().method, Name("last-plot"));
  const Position<Ecef> truth = test::vehicle_at(20.3);
  for (Eigen::Index axis = 0; axis < 3; ++axis)
    EXPECT_NEAR(sink.all.back().state[static_cast<std::size_t>(axis)], truth.m[axis], 1e-6);  // rounding at 6400 km
}

}  // namespace
}  // namespace downrange
