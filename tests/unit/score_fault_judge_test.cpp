/// A flight with a fault, judged: results whose errors, verdicts and bounds are known by construction.
#include <gtest/gtest.h>

#include <numbers>

#include "score/fault_judge.hpp"

namespace downrange::score {
namespace {

constexpr double deg = std::numbers::pi / 180;
constexpr Time liftoff{1'772'352'000'000'000'000};

Time at(double t_s) { return liftoff + seconds(t_s); }

RangeConfig range() {
  RangeConfig range;
  range.targets = {{"kslv"}};
  for (const char* id : {"goheung", "jeju"}) {
    RadarConfig radar;
    radar.id = id;
    range.radars.push_back(radar);
  }
  range.telemetry = {{"tgs", Site({34.4 * deg, 127.5 * deg, 100})}};
  AntennaConfig antenna;
  antenna.id = "dish";
  antenna.site = Site({34.0 * deg, 127.0 * deg, 50});
  range.antennas = {antenna};
  return range;
}

TrueState truth(double t_s) {
  const Eigen::Vector3d v(900, 400, -700);
  return {{ecef_from_geodetic({33.5 * deg, 127.2 * deg, 80e3}).m + v * t_s}, {v}};
}

/// A fault from 100 to 160 s, of goheung; judged until 240 s.
class Judged : public ::testing::Test {
 protected:
  FaultCase fault{.target = "kslv",
                  .truth = [](Time t) { return std::optional(truth((t - liftoff).seconds())); },
                  .begin = at(100),
                  .end = at(160),
                  .liars = {"goheung"},
                  .recovered_m = 20};

  /// On every tenth of a second: the position that is `error_m(t)` off.
  template <class ErrorAt>
  static void fly(FaultJudge& judge, const ErrorAt& error_m, std::optional<double> bound_m = {}) {
    for (int i = 0; i <= 2400; ++i) {
      const double t_s = i / 10.0;
      const std::optional<double> error = error_m(t_s);
      if (error) judge.emit(position(t_s, *error, bound_m));
    }
  }

  static Trajectory position(double t_s, double error_m, std::optional<double> bound_m) {
    Trajectory t;
    t.target = "kslv";
    t.primary = true;
    t.epoch = at(t_s);
    Eigen::Vector3d::Map(t.state.data()) = truth(t_s).position.m + Eigen::Vector3d(error_m, 0, 0);
    t.covariance[0] = t.covariance[6] = t.covariance[11] = 4;
    t.bound_valid = bound_m.has_value();
    t.bound_m = bound_m.value_or(0);
    return t;
  }

  /// Elevation off by `error_deg`, both axes of 1-sigma `sigma_deg`.
  static SlavingCommand command(double t_s, double error_deg, double sigma_deg, std::optional<double> bound_deg = {}) {
    SlavingCommand c;
    c.antenna = "dish";
    c.target = "kslv";
    c.tick = c.apply_at = at(t_s);
    const Polar look = polar_from_enu(range().antennas[0].site.enu_of(truth(t_s).position));
    c.azimuth_rad = look.azimuth_rad;
    c.elevation_rad = look.elevation_rad + error_deg * deg;
    c.range_m = look.range_m;
    c.sigma_azimuth_rad = 0;
    c.sigma_elevation_rad = sigma_deg * deg;
    c.bound_valid = bound_deg.has_value();
    c.bound_rad = bound_deg.value_or(0) * deg;
    return c;
  }

  static SourceHealth health(double t_s, const Name& sensor, bool rejected, bool mismatch = false) {
    SourceHealth h;
    h.sensor = sensor;
    h.time = at(t_s);
    h.qualified = !rejected;
    h.why = rejected ? Disqualification::Rejected : Disqualification::None;
    h.mismatch = mismatch;
    return h;
  }

  static Integrity integrity(double t_s, const Name& sensor, IntegrityVerdict verdict) {
    Integrity i;
    i.target = "kslv";
    i.time = at(t_s);
    SourceIntegrity source;
    source.sensor = sensor;
    source.verdict = verdict;
    i.sources = {source};
    return i;
  }
};

TEST_F(Judged, TheErrorWhileItLastsIsOfItsWindowAlone) {
  FaultJudge judge(range(), fault);
  fly(judge, [](double t) { return t >= 100 && t < 160 ? 30 : t >= 160 ? 70.0 : 5; });
  const FaultScore score = judge.score();
  EXPECT_NEAR(score.during.worst, 30, 1e-6);
  EXPECT_NEAR(score.during.rms, 30, 1e-6);
  EXPECT_EQ(score.during.count, 600u);
  EXPECT_NEAR(score.whole.worst, 70, 1e-6);
}

TEST_F(Judged, RecoveryIsTheLastErrorThatIsTooLarge) {
  FaultJudge judge(range(), fault);
  // Good at once, bad once more from 165 to 168 s.
  fly(judge, [](double t) { return t >= 100 && t < 160 ? 500.0 : t >= 165 && t <= 168 ? 21 : 19; });
  ASSERT_TRUE(judge.score().recovery_s);
  EXPECT_NEAR(*judge.score().recovery_s, 8, 1e-6);
}

TEST_F(Judged, AHoleInTheTrackIsNoRecovery) {
  FaultJudge late(range(), fault);
  fly(late, [](double t) { return t >= 160 && t < 164 ? std::nullopt : std::optional(5.0); });
  EXPECT_NEAR(*late.score().recovery_s, 4, 1e-6);
  FaultJudge never(range(), fault);
  fly(never, [](double t) { return t >= 160 ? std::nullopt : std::optional(5.0); });
  EXPECT_FALSE(never.score().recovery_s);
  FaultJudge wrong(range(), fault);
  fly(wrong, [](double) { return 25.0; });
  EXPECT_FALSE(wrong.score().recovery_s);
}

TEST_F(Judged, ACommandIsConfidentlyWrongBeyondLimitSigmaAndBound) {
  FaultJudge judge(range(), fault);
  const auto wrong_after = [&](const SlavingCommand& c) {
    judge.emit(c);
    return std::pair(judge.score().confidently_wrong, judge.score().wrong_by_sigma);
  };
  EXPECT_EQ(wrong_after(command(110, 0.24, 0.01)), std::pair(0L, 0L));       // not far
  EXPECT_EQ(wrong_after(command(110, 0.30, 0.07)), std::pair(0L, 0L));       // not sure of itself
  EXPECT_EQ(wrong_after(command(110, 0.30, 0.05)), std::pair(1L, 1L));       // nothing bounds it
  EXPECT_EQ(wrong_after(command(110, 0.30, 0.05, 0.4)), std::pair(1L, 2L));  // the bound says so
  EXPECT_EQ(wrong_after(command(110, 0.30, 0.05, 0.2)), std::pair(2L, 3L));
  SlavingCommand held = command(110, 3, 0.01);
  held.limits = LimitElevation;
  EXPECT_EQ(wrong_after(held), std::pair(2L, 3L));
  EXPECT_EQ(judge.score().commands, 5);
  EXPECT_EQ(judge.score().pointing_bound.count, 2);
  EXPECT_EQ(judge.score().pointing_bound.inside, 1);
}

TEST_F(Judged, TheFirstAccusedAfterTheBeginCounts) {
  FaultJudge judge(range(), fault);
  judge.emit(health(99, "jeju", true));  // stood before
  judge.emit(health(101, "jeju", true));
  judge.emit(health(102, "goheung", false));
  EXPECT_FALSE(judge.score().accusation);
  judge.emit(health(103, "goheung", true));
  judge.emit(health(104, "jeju", false, true));
  ASSERT_TRUE(judge.score().accusation);
  EXPECT_EQ(judge.score().accusation->source, Name("goheung"));
  EXPECT_TRUE(judge.score().accusation->right);
  EXPECT_NEAR(judge.score().accusation->delay_s, 3, 1e-9);

  FaultJudge other(range(), fault);
  other.emit(health(103, "jeju", false, true));
  other.emit(health(104, "goheung", true));
  EXPECT_FALSE(other.score().accusation->right);
}

TEST_F(Judged, WhereIntegritySpeaksHealthsModelIsNotAsked) {
  FaultJudge judge(range(), fault);
  judge.emit(integrity(90, "jeju", IntegrityVerdict::Agrees));
  judge.emit(health(101, "jeju", false, true));
  judge.emit(integrity(102, "goheung", IntegrityVerdict::Ambiguous));
  EXPECT_FALSE(judge.score().accusation);
  judge.emit(integrity(103, "goheung", IntegrityVerdict::Suspect));
  judge.emit(integrity(104, "goheung", IntegrityVerdict::Excluded));
  ASSERT_TRUE(judge.score().accusation);
  EXPECT_NEAR(judge.score().accusation->delay_s, 3, 1e-9);
  EXPECT_TRUE(judge.score().accusation->right);
}

TEST_F(Judged, WhoseMessagesAreAllRejectedIsAccusedWhateverIntegritySays) {
  FaultJudge judge(range(), fault);
  judge.emit(integrity(90, "goheung", IntegrityVerdict::Agrees));
  judge.emit(health(102, "goheung", true));
  judge.emit(integrity(102.1, "goheung", IntegrityVerdict::Agrees));
  judge.emit(position(103, 0, {}));
  ASSERT_TRUE(judge.score().accusation);
  EXPECT_NEAR(judge.score().accusation->delay_s, 2, 1e-9);
  EXPECT_EQ(judge.score().seconds.back().accused, std::vector<Name>{"goheung"});
  judge.emit(health(104, "goheung", false));
  judge.emit(position(105, 0, {}));
  EXPECT_TRUE(judge.score().seconds.back().accused.empty());
}

TEST_F(Judged, SilenceAccusesNobody) {
  FaultJudge judge(range(), fault);
  SourceHealth silent = health(103, "goheung", true);
  silent.why = Disqualification::Silent;
  judge.emit(silent);
  EXPECT_FALSE(judge.score().accusation);
}

TEST_F(Judged, TheBoundIsHeldAgainstThePositionsSentWithIt) {
  FaultJudge judge(range(), fault);
  fly(
      judge, [](double t) { return t < 60 ? 51.0 : 10; }, 50);
  EXPECT_EQ(judge.score().bound.count, 2401);
  EXPECT_EQ(judge.score().bound.inside, 1801);
  FaultJudge without(range(), fault);
  fly(without, [](double) { return 10.0; });
  EXPECT_EQ(without.score().bound.count, 0);
  EXPECT_EQ(without.score().unbounded, 2401);
}

TEST_F(Judged, WhatIsMissedIsSaid) {
  FaultScore score;
  score.recovers = true;
  score.recovery_s = 1;
  score.during = {.count = 10, .rms = 5, .p95 = 9, .worst = 10};
  score.accusation = Accusation{"goheung", 4, true};
  score.bound = {999, 1000};
  const FaultLimits limits{.error_m = 10, .recovery_s = 2, .accusation_s = 4};
  EXPECT_TRUE(missed(score, limits).empty());

  const auto first = [&](auto&& change) {
    FaultScore other = score;
    change(other);
    const std::vector<std::string> all = missed(other, limits);
    return all.size() == 1 ? all[0] : std::to_string(all.size()) + " sentences";
  };
  EXPECT_EQ(first([](FaultScore& s) { s.during.worst = 812; }), "worst 812 m, allowed 10 m");
  EXPECT_EQ(first([](FaultScore& s) { s.recovery_s = 3; }), "recovers after 3.0 s, allowed 2 s");
  EXPECT_EQ(first([](FaultScore& s) { s.recovery_s.reset(); }), "does not recover");
  EXPECT_EQ(first([](FaultScore& s) { s.accusation.reset(); }), "accuses nobody");
  EXPECT_EQ(first([](FaultScore& s) { s.accusation->right = false; }), "accuses goheung");
  EXPECT_EQ(first([](FaultScore& s) { s.accusation->delay_s = 5; }), "accuses after 5.0 s, allowed 4 s");
  EXPECT_EQ(first([](FaultScore& s) { s.confidently_wrong = 7; }), "7 commands confidently wrong");
  EXPECT_EQ(first([](FaultScore& s) { s.bound.inside = 998; }), "bound covers 99.80 %, at least 99.9 % expected");

  // A lying majority is believed; nobody can tell who is right.
  score.confidently_wrong = 7;
  score.accusation->right = false;
  score.bound.inside = 0;
  EXPECT_TRUE(missed(score, {.majority_lies = true}).empty());
}

}  // namespace
}  // namespace downrange::score
