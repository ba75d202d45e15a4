// What watch shows of a service that died: nothing of it may look alive.

#include <gtest/gtest.h>

#include "app/downrange/board.hpp"

namespace downrange::app {
namespace {

using std::chrono::milliseconds;

constexpr Time utc{1'800'000'000'000'000'000};
const Board::Clock::time_point start = Board::Clock::now();

bool shows(const std::string& lines, const std::string& text) { return lines.find(text) != std::string::npos; }

dds::ServiceStatus status(const Name& node, Time last_tick = {}) {
  dds::ServiceStatus s;
  s.node = node;
  s.state = "running";
  s.last_tick = last_tick;
  return s;
}

SlavingCommand command(Time tick) {
  SlavingCommand c;
  c.antenna = "dish";
  c.tick = tick;
  c.apply_at = tick;
  c.valid_until = tick + seconds(0.5);
  return c;
}

Trajectory track(Time epoch) {
  Trajectory t;
  t.target = "rocket";
  t.epoch = epoch;
  return t;
}

SourceHealth health(const Name& sensor, Time time, std::uint64_t accepted) {
  SourceHealth h;
  h.sensor = sensor;
  h.time = time;
  h.count[0] = accepted;
  return h;
}

TEST(WatchBoard, WhatAnAntennaMissesAndHowFarThePlanIs) {
  constexpr double deg = 3.14159265358979 / 180;
  Board board(dds::ClockMode::Wall);
  SlavingCommand c = command(utc);
  board.add(c, start);
  EXPECT_FALSE(shows(board.lines(start, utc), "in beam"));
  EXPECT_FALSE(shows(board.lines(start, utc), "  off "));
  c.source = SlavingSource::Nominal;
  c.off_target_rad = 0.53 * deg;
  c.probability_in_beam = 0.934;
  c.probability_valid = true;
  c.limits = LimitKeyhole;
  board.add(c, start);
  Trajectory t = track(utc);
  board.add(t, start);
  EXPECT_TRUE(shows(board.lines(start, utc), "nominal  age 0.00 s  off 0.53 deg  in beam 93 % keyhole"))
      << board.lines(start, utc);
  EXPECT_FALSE(shows(board.lines(start, utc), "plan"));
  t.deviation_m = {120, -30, 15};
  t.deviation_valid = true;
  board.add(t, start);
  EXPECT_TRUE(shows(board.lines(start, utc), "  off plan 120 along, -30 across, 15 m up"));
}

TEST(WatchBoard, ASilentNodeIsNotRunning) {
  Board board(dds::ClockMode::Wall);
  board.add(status("dead"), start);
  board.add(status("alive"), start + milliseconds(4000));
  EXPECT_FALSE(shows(board.lines(start + milliseconds(2900), utc), "SILENT"));
  const std::string lines = board.lines(start + milliseconds(5000), utc);
  EXPECT_TRUE(shows(lines, "node dead         all    SILENT 5 s")) << lines;
  EXPECT_TRUE(shows(lines, "node alive        all    running")) << lines;
}

TEST(WatchBoard, OnTheWallClockUtcTellsTheAge) {
  Board board(dds::ClockMode::Wall);
  board.add(Result(command(utc)), start);
  board.add(Result(track(utc)), start);
  board.add(health("radar", utc, 1), "node", start);
  const std::string fresh = board.lines(start, utc + seconds(0.5));
  EXPECT_FALSE(shows(fresh, "EXPIRED") || shows(fresh, "old")) << fresh;
  const std::string expired = board.lines(start, utc + seconds(0.6));
  EXPECT_TRUE(shows(expired, "EXPIRED") && !shows(expired, "old")) << expired;
  const std::string later = board.lines(start, utc + seconds(7));
  EXPECT_TRUE(shows(later, "NIS  0.00  old 7 s")) << later;
  EXPECT_TRUE(shows(later, "NOT qualified  old 7 s")) << later;
}

TEST(WatchBoard, ANameCannotGiveOrdersToTheTerminal) {
  Board board(dds::ClockMode::Wall);
  Trajectory t = track(utc);
  t.target = "\x1b[2Jrocket\r";
  board.add(t, start);
  EXPECT_TRUE(shows(board.lines(start, utc), "\\x1b[2Jrocket\\x0d"));
}

TEST(WatchBoard, WhoDoesNotMatchIsNamed) {
  Board board(dds::ClockMode::Wall);
  dds::ServiceStatus s = status("node", utc);
  board.add(s, start);
  EXPECT_FALSE(shows(board.lines(start, utc), "DOES NOT MATCH"));
  s.mismatch = "1 of others: range/gps: writer 'tgs' at 10.0.0.2";
  board.add(s, start);
  EXPECT_TRUE(shows(board.lines(start, utc), "DOES NOT MATCH  1 of others: range/gps: writer 'tgs' at 10.0.0.2"));
}

TEST(WatchBoard, OnTheRangeClockTheNewestRangeTimeDoes) {
  Board board(dds::ClockMode::Range);
  board.add(Result(command(utc)), start);
  board.add(Result(track(utc)), start);
  const Time years_later = utc + seconds(1e8);
  const std::string paused = board.lines(start + milliseconds(60'000), years_later);
  EXPECT_FALSE(shows(paused, "EXPIRED") || shows(paused, "old")) << paused;
  board.add(status("node", utc + seconds(4)), start);
  const std::string later = board.lines(start, years_later);
  EXPECT_TRUE(shows(later, "EXPIRED") && shows(later, "old 4 s")) << later;
}

TEST(WatchBoard, NothingAtAllIsIdleToo) {
  const Board board(dds::ClockMode::Wall);
  EXPECT_FALSE(board.idle_for(10, Board::Clock::now()));
  EXPECT_TRUE(board.idle_for(10, Board::Clock::now() + milliseconds(10'100)));
}

TEST(WatchBoard, EachNodeHasItsOwnAccountOfASource) {
  Board board(dds::ClockMode::Wall);
  board.add(health("radar", utc, 11), "site-a", start);
  EXPECT_FALSE(shows(board.lines(start, utc), "site-a")) << "one node needs no name";
  board.add(health("radar", utc, 22), "site-b", start);
  const std::string lines = board.lines(start, utc);
  EXPECT_TRUE(shows(lines, "      11") && shows(lines, "at site-a")) << lines;
  EXPECT_TRUE(shows(lines, "      22") && shows(lines, "at site-b")) << lines;
}

TEST(WatchBoard, ASourceTellsItsShareOfNisAndWhyItIsNotQualified) {
  Board board(dds::ClockMode::Wall);
  SourceHealth h = health("radar", utc, 1);
  h.qualified = true;
  board.add(h, "node", start);
  EXPECT_TRUE(shows(board.lines(start, utc), "in 95 %       -  qualified\n")) << board.lines(start, utc);
  h.nis_count = 1000;
  h.nis_inside_95 = 0.929;
  h.mismatch = true;
  board.add(h, "node", start);
  EXPECT_TRUE(shows(board.lines(start, utc), "in 95 %  92.9 %  qualified  MISMATCH\n")) << board.lines(start, utc);
  h.nis_inside_95 = 1;
  h.mismatch = false;
  h.qualified = false;
  h.why = Disqualification::Silent;
  board.add(h, "node", start);
  EXPECT_TRUE(shows(board.lines(start, utc), "in 95 % 100.0 %  NOT qualified: silent\n")) << board.lines(start, utc);
  h.why = Disqualification::Rejected;
  h.rejected_for = Reason::NotTracking;
  board.add(h, "node", start);
  EXPECT_TRUE(shows(board.lines(start, utc), "NOT qualified: not_tracking\n")) << board.lines(start, utc);
}

TEST(WatchBoard, WhoSaysSinceWhenASourceIsNotUsed) {
  Board board(dds::ClockMode::Wall);
  Integrity integrity;
  integrity.target = "rocket";
  integrity.time = utc;
  integrity.liftoff = utc - seconds(300);
  integrity.liftoff_valid = true;
  board.add(integrity, start);
  SourceHealth h = health("radar", utc, 1);
  h.why = Disqualification::Inhibited;
  h.since = utc - seconds(60);
  h.by = "kim";
  h.reason = "spent stage in the beam";
  board.add(h, "node", start);
  EXPECT_TRUE(
      shows(board.lines(start, utc), "NOT qualified: inhibited since T+240.0 by kim (spent stage in the beam)\n"))
      << board.lines(start, utc);
  h = health("radar", utc, 1);
  h.qualified = h.suspect = true;
  h.since = utc - seconds(50);
  h.by = "integrity";
  board.add(h, "node", start);
  EXPECT_TRUE(shows(board.lines(start, utc), "  SUSPECT since T+250.0 by integrity\n")) << board.lines(start, utc);
  h.suspect = false;
  h.forced = true;
  h.by = "kim";
  board.add(h, "node", start);
  EXPECT_TRUE(shows(board.lines(start, utc), "  qualified, FORCED since T+250.0 by kim\n")) << board.lines(start, utc);
}

TEST(WatchBoard, AResidualStandsBesideWhatIsToBeExpected) {
  Board board(dds::ClockMode::Wall);
  SourceHealth h = health("radar", utc, 1);
  h.residual_m = 40;
  h.expected_m = 25;
  h.residual_rad = 0.01 * 3.14159265358979 / 180;
  h.expected_rad = 0.012 * 3.14159265358979 / 180;
  board.add(h, "node", start);
  EXPECT_TRUE(shows(board.lines(start, utc), "  off 40.0 m of 25.0, 0.010 deg of 0.012  ")) << board.lines(start, utc);
  h.expected_m = 0;
  board.add(h, "node", start);
  EXPECT_TRUE(shows(board.lines(start, utc), "  off 0.010 deg of 0.012  ")) << board.lines(start, utc);
}

TEST(WatchBoard, IntegrityIsToldInSentences) {
  Board board(dds::ClockMode::Wall);
  Integrity integrity;
  integrity.target = "rocket";
  integrity.time = utc;
  integrity.chain = "without-GPS";
  integrity.bound_valid = true;
  integrity.bound_m = 120;
  integrity.sources = {
      {.sensor = "radar"},
      {.sensor = "station", .verdict = IntegrityVerdict::Excluded, .against = 1, .apart_m = 5000, .by = "integrity"}};
  board.add(integrity, start);
  const std::string lines = board.lines(start, utc + seconds(1));
  EXPECT_TRUE(shows(lines, "rocket follows chain without-GPS, bound 120 m\n")) << lines;
  EXPECT_TRUE(shows(lines, "  station disagrees with radar by 5.0 km; excluded by integrity\n")) << lines;
  EXPECT_FALSE(shows(lines, "radar agrees")) << lines;
  EXPECT_TRUE(shows(board.lines(start, utc + seconds(7)), "bound 120 m  old 7 s\n"));
}

ImpactPoint impact(const Name& chain, double latitude_deg) {
  ImpactPoint i;
  i.target = "rocket";
  i.chain = chain;
  i.epoch = utc;
  i.impact_valid = true;
  i.point = {latitude_deg * 3.14159265358979 / 180, 2.2, 0};
  i.time_to_impact_s = 312.44;
  i.covariance_m2 = {1e6, 0, 4e6};
  i.data_age_s = i.data_loss_timer_s = 0.15;
  return i;
}

TEST(WatchBoard, WhatIsOrderedOfAnAntennaAndWhenItSeesItsTarget) {
  Board board(dds::ClockMode::Wall);
  AntennaAccount account;
  account.antenna = "jeju-tm";
  account.target = "rocket";
  account.tick = utc;
  board.add(account, start);
  EXPECT_FALSE(shows(board.lines(start, utc), "jeju-tm"));
  account.orders = "stopped by kim (wind)";
  board.add(account, start);
  EXPECT_TRUE(shows(board.lines(start, utc), "jeju-tm          ORDERED: stopped by kim (wind)\n"));
  account.orders = {};
  account.pass_valid = true;
  board.add(account, start);
  EXPECT_TRUE(shows(board.lines(start, utc), "jeju-tm          not seen within 15 min (free fall)\n"));
  account.basis = PassBasis::PlannedLiftoff;
  account.acquisition_valid = account.loss_valid = account.highest_valid = true;
  account.acquisition = Time{(10LL * 3600 + 120) * 1'000'000'000};
  account.acquisition_azimuth_rad = 1.5 * 3.14159265358979;
  account.highest = account.acquisition + seconds(61.9);
  account.highest_elevation_rad = 0.5;
  account.loss = account.acquisition + seconds(300);
  board.add(account, start);
  EXPECT_TRUE(shows(board.lines(start, utc),
                    "jeju-tm          rises 10:02:00 (az 270.0) to 10:07:00 (az 0.0), highest 28.6 deg at 10:03:01 "
                    "(planned lift-off)\n"))
      << board.lines(start, utc);
  account.in_view = true;
  account.acquisition_valid = account.loss_valid = false;
  account.basis = PassBasis::Plan;
  board.add(account, start);
  EXPECT_TRUE(shows(board.lines(start, utc), "jeju-tm          in view, highest 28.6 deg at 10:03:01 (planned)\n"));
  EXPECT_TRUE(shows(board.lines(start, utc + seconds(7)), "(planned)  old 7 s\n"));
}

TEST(WatchBoard, WhereATargetFallsFitsOnAScreen) {
  Board board(dds::ClockMode::Wall);
  ImpactPoint selected = impact({}, 30);
  selected.data_loss_limit_valid = true;
  selected.data_loss_limit_s = 10;
  for (int k = 0; k < 5; ++k)
    selected.boundaries.push_back({.boundary = ("corridor-" + std::to_string(k)).c_str(),
                                   .distance_m = 1000.0 * (5 - k) - 2500,
                                   .present_distance_m = 123'456,
                                   .time_s = 17.5,
                                   .time_valid = k != 4,
                                   .probability_outside = 1.2e-5});
  board.add(selected, start);
  ImpactPoint other = impact("only-goheung", 30.1);
  board.add(other, start);
  other.chain = "only-GPS";
  other.impact_valid = false;
  board.add(other, start);
  std::string lines = board.lines(start, utc);
  EXPECT_TRUE(shows(lines, "rocket     vacuum impact  30.0000  126.0507 in  312.4 s  sigma 2.0 km x 1.0 km\n"))
      << lines;
  EXPECT_TRUE(shows(lines, "  corridor-4     1.5 km OUTSIDE P(out) 1.2e-05 now  123 km inside\n")) << lines;
  EXPECT_TRUE(shows(lines, "  corridor-2      500 m inside  P(out) 1.2e-05 in  17.5 s now  123 km inside\n")) << lines;
  EXPECT_FALSE(shows(lines, "corridor-1")) << "the three nearest";
  EXPECT_TRUE(shows(lines, "  and 2 boundaries that it is farther inside of\n")) << lines;
  EXPECT_TRUE(shows(lines, "  only-GPS none, only-goheung 11.1 km off\n")) << lines;
  EXPECT_FALSE(shows(lines, "no data")) << lines;
  std::size_t longest = 0;
  for (std::size_t at = 0, end = 0; (end = lines.find('\n', at)) != std::string::npos; at = end + 1)
    longest = std::max(longest, end - at);
  EXPECT_LE(longest, 80u);
  EXPECT_LE(std::count(lines.begin(), lines.end(), '\n'), 8);

  selected.data_loss_timer_s = 3.2;
  board.add(selected, start);
  EXPECT_TRUE(shows(board.lines(start, utc), "  no data for 3.2 s, allowed: 10.0 s\n")) << board.lines(start, utc);
  selected.data_loss_timer_s = 12;
  board.add(selected, start);
  EXPECT_TRUE(shows(board.lines(start, utc), "  DATA LOST for 12.0 s, allowed: 10.0 s\n")) << board.lines(start, utc);
  selected.impact_valid = false;
  board.add(selected, start);
  EXPECT_TRUE(shows(board.lines(start, utc), "rocket     vacuum impact none: it does not come down\n"));
  selected.data_age_s = 0;
  selected.boundaries.clear();
  board.add(selected, start);
  EXPECT_TRUE(shows(board.lines(start, utc), "rocket     vacuum impact none: there is no track\n"));
  EXPECT_TRUE(shows(board.lines(start, utc + seconds(7)), "  the impact point is  old 7 s\n"));
}

}  // namespace
}  // namespace downrange::app
