/// The mismatch alarm on whole flights: health announces it for the radar whose model lacks what is wrong with it, and
/// for no other source (est/THEORY.md section 3).
#include <gtest/gtest.h>

#include <algorithm>
#include <downrange/stage/engine.hpp>
#include <map>
#include <source_dir.hpp>

#include "config/load.hpp"
#include "sim/simulation.hpp"

namespace downrange {
namespace {

/// What the health records of one source came to.
struct Told {
  int rang_s = 0;
  double least_share = 1;  ///< of full windows
  bool qualified_while_ringing = true;
  SourceHealth last;
};

/// The reference launch (white noise, polar biases) to 440 s, the first radar's clock fast by `time_tag_s`, judged by
/// joint. When the upper stage cuts off at 453 s, the late radar has upset the track, and whatever is measured against
/// it rings as well.
std::map<Name, Told> fly(double time_tag_s, std::vector<BiasBlock> blocks_of_first) {
  const std::string root = DOWNRANGE_SOURCE_DIR;
  RangeConfig range = config::load(root + "/config/naro.toml", {{"ingest.expect_simulated", "true", "test"}}).range;
  range.fuse.methods = {"joint"};
  range.integrity.enabled = false;  // it would exclude the radar: this is the method's own alarm
  range.antennas.clear();
  for (RadarConfig& radar : range.radars) radar.angle_inflation = 1;  // the simulated noise is what is configured
  range.radars[0].bias.blocks = std::move(blocks_of_first);
  sim::Scenario scenario = sim::load_scenario(root + "/tools/scenarios/paper.toml", range);
  scenario.radars[0].bias.time_tag_s = time_tag_s;

  struct Sink final : ResultSink {
    void emit(const Result& result) override {
      const auto* h = std::get_if<SourceHealth>(&result);
      if (h == nullptr) return;
      Told& t = told[h->sensor];
      t.last = *h;
      if (h->nis_count == 1000) t.least_share = std::min(t.least_share, h->nis_inside_95);
      if (!h->mismatch) return;
      ++t.rang_s;
      t.qualified_while_ringing = t.qualified_while_ringing && h->qualified;
    }
    std::map<Name, Told> told;
  } sink;
  Engine engine(range, {}, sink);
  const sim::Simulation flight(scenario, 1);
  for (const Event& event : flight.events()) {
    if (received_of(event) > scenario.liftoff + seconds(440.0)) break;
    engine.handle(engine.admit(event));
  }
  return sink.told;
}

TEST(MismatchAlarm, RingsForALateClockThatTheModelLacks) {
  const auto told = fly(0.1, {BiasBlock::Polar, BiasBlock::SezOffset});
  const Told& late = told.at("goheung");
  EXPECT_GT(late.rang_s, 60) << "least share " << late.least_share;
  EXPECT_LT(late.least_share, MismatchAlarm::threshold);
  EXPECT_TRUE(late.qualified_while_ringing);
  EXPECT_EQ(told.at("jeju").rang_s, 0) << told.at("jeju").least_share;
}

TEST(MismatchAlarm, IsSilentWhereTheModelIsRight) {
  for (const double time_tag_s : {0.0, 0.1}) {
    for (const auto& [source, t] : fly(time_tag_s, {BiasBlock::Polar, BiasBlock::SezOffset, BiasBlock::Time})) {
      EXPECT_EQ(t.rang_s, 0) << source.view() << " with " << time_tag_s << " s: least share " << t.least_share;
      if (why_not_qualified(t.last) == "silent since start") continue;
      EXPECT_GT(t.last.nis_count, 300) << source.view();
    }
  }
}

}  // namespace
}  // namespace downrange
