/// Mission time: count, hold, recycle, lift-off announced and found.
#include <gtest/gtest.h>

#include "../support/small_range.hpp"
#include "stage/ingest.hpp"
#include "stage/mission_clock.hpp"

namespace downrange {
namespace {

using test::liftoff;

Time at(double t) { return liftoff + seconds(t); }

MissionEvent event(MissionEventKind kind, double t, const Name& label = {}) {
  MissionEvent e;
  e.mission = "flight-3";
  e.kind = kind;
  e.label = label;
  e.epoch = e.received = at(t);
  e.simulated = true;
  return e;
}

/// T+ in seconds; far below any when none is known.
double t_plus(const MissionClock& clock, double t) {
  return static_cast<double>(clock.t_plus(at(t)).value_or(seconds(-1e6)).ns) / 1e9;
}

TEST(MissionClock, KnowsNothingAtFirst) {
  const MissionClock clock(test::small_range());
  EXPECT_FALSE(clock.t_plus(at(0)) || clock.liftoff() || clock.planned_liftoff() || clock.hold_since());
  EXPECT_FALSE(clock.in_flight(at(0)));
}

TEST(MissionClock, CountsDownHoldsAndGoesOnWithANewPlan) {
  MissionClock clock(test::small_range());
  clock.note(event(MissionEventKind::PlannedLiftoff, 0));
  EXPECT_EQ(t_plus(clock, -100), -100);
  clock.note(event(MissionEventKind::Hold, -60));
  EXPECT_EQ(t_plus(clock, -60), -60);
  EXPECT_EQ(t_plus(clock, 500), -60) << "the count stands";
  EXPECT_EQ(clock.hold_since(), at(-60));
  EXPECT_FALSE(clock.in_flight(at(500)));
  clock.note(event(MissionEventKind::PlannedLiftoff, 600));
  EXPECT_EQ(t_plus(clock, 500), -100);
  EXPECT_FALSE(clock.hold_since());
}

TEST(MissionClock, TheAnnouncedLiftoffOverrulesThePlanAndTheMotion) {
  MissionClock clock(test::small_range());
  clock.note(event(MissionEventKind::PlannedLiftoff, 0));
  clock.note_motion(at(3));
  clock.note_motion(at(50));  // a second vehicle's
  EXPECT_EQ(clock.liftoff(), at(3));
  EXPECT_FALSE(clock.liftoff_announced());
  EXPECT_EQ(t_plus(clock, 13), 10);
  clock.note(event(MissionEventKind::Liftoff, 1));
  EXPECT_EQ(t_plus(clock, 13), 12);
  EXPECT_TRUE(clock.liftoff_announced());
  EXPECT_TRUE(clock.in_flight(at(1)) && !clock.in_flight(at(0.9)));
  clock.note(event(MissionEventKind::Liftoff, 2));  // corrected
  EXPECT_EQ(t_plus(clock, 13), 11);
  clock.note(event(MissionEventKind::Hold, 20));
  EXPECT_FALSE(clock.hold_since()) << "a flight is not held";
  EXPECT_EQ(clock.refusal(event(MissionEventKind::Hold, 20)), "no hold after lift-off: recycle first");
}

TEST(MissionClock, ARecycleForgetsTheAttempt) {
  MissionClock clock(test::small_range());
  clock.note(event(MissionEventKind::PlannedLiftoff, 0));
  clock.note(event(MissionEventKind::Liftoff, 0));
  clock.note(event(MissionEventKind::Staging, 120, "second stage"));
  clock.note_motion(at(1));
  clock.note(event(MissionEventKind::Recycle, 200));
  EXPECT_FALSE(clock.t_plus(at(300)) || clock.liftoff() || clock.planned_liftoff());
  EXPECT_TRUE(clock.marks().empty());
}

TEST(MissionClock, KeepsTheNewestMarks) {
  MissionClock clock(test::small_range());
  clock.note(event(MissionEventKind::Staging, 100, "second stage"));
  ASSERT_EQ(clock.marks().size(), 1u);
  EXPECT_EQ(clock.marks()[0].label, Name("second stage"));
  EXPECT_EQ(clock.marks()[0].kind, MissionEventKind::Staging);
  for (int i = 0; i < 40; ++i) clock.note(event(MissionEventKind::Mark, 200 + i));
  ASSERT_EQ(clock.marks().size(), MissionClock::max_marks);
  EXPECT_EQ(clock.marks().back().epoch, at(239));
}

TEST(MissionClock, AnotherKindOfFlightIsNotHeard) {
  MissionClock clock(test::small_range());
  MissionEvent real = event(MissionEventKind::Liftoff, 0);
  real.simulated = false;
  clock.note(real);
  EXPECT_FALSE(clock.liftoff());
  EXPECT_EQ(clock.refusal(real), "this node flies simulated missions only");
  MissionEvent timeless = event(MissionEventKind::Liftoff, 0);
  timeless.epoch = {-1};
  EXPECT_NE(clock.refusal(timeless), "");
}

TEST(MissionClock, IngestFindsLiftoffFromMotionAndARecyclePutsTheVehicleBack) {
  RangeConfig range = test::small_range();
  range.pad = PadConfig{.site = test::pad()};
  Ingest ingest(range);
  std::uint64_t sequence = 0;
  for (int i = 0; i < 6; ++i) static_cast<void>(ingest.judge(test::fix_at("goheung-tgs", i, ++sequence)));
  ASSERT_TRUE(ingest.mission().liftoff());
  EXPECT_FALSE(ingest.mission().liftoff_announced());
  EXPECT_LE(*ingest.mission().liftoff(), at(3));
  EXPECT_TRUE(ingest.left_pad("kslv", at(5)));
  EXPECT_FALSE(ingest.left_pad("another", at(5)));
  ingest.note(event(MissionEventKind::Recycle, 6));
  EXPECT_FALSE(ingest.mission().liftoff());
  EXPECT_FALSE(ingest.left_pad("kslv", at(6)));
}

}  // namespace
}  // namespace downrange
