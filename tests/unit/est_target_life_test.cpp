/// Who may change a target's mind: the rules that all methods share, without any method's algebra.
#include <gtest/gtest.h>
#include <downrange/est/method/target_life.hpp>

#include "../support/drawn_flight.hpp"

namespace downrange {
namespace {

using test::deg;

/// A vehicle that passes at 1 km/s, two radars without noise and a receiver; the track is where the test says.
class Rules : public testing::Test {
 protected:
  static MethodSettings two_radars() {
    MethodSettings s = test::draw_flight(1, 1, false).settings;
    s.arbitration.reopen_after = 20;
    return s;
  }
  [[nodiscard]] static Time at(double t) { return Time{} + seconds(1000 + t); }
  [[nodiscard]] static Vec<9> truth(double t) {
    static const Site below({34.0 * deg, 127.2 * deg, 0});
    Vec<9> x = Vec<9>::Zero();
    const auto position = [](double s) { return below.ecef_of({{-1000 * s, 0.0, 60'000.0}}).m; };
    x << position(t), position(t + 0.5) - position(t - 0.5), Vec<3>::Zero();
    return x;
  }
  [[nodiscard]] static Vec<3> up() { return truth(0).head<3>().normalized(); }
  /// The truth, displaced upwards.
  [[nodiscard]] static Vec<9> off(double t, double metres) {
    Vec<9> x = truth(t);
    x.head<3>() += metres * up();
    return x;
  }
  [[nodiscard]] Measurement fix(double t, double off_m = 0) {
    Measurement m;
    m.source = static_cast<int>(settings.radars.size());
    m.measured = Fix{};
    m.epoch = at(t);
    m.sequence = ++sequence;
    test::fix(m).position.m = off(t, off_m).head<3>();
    test::fix(m).velocity.m_s = truth(t).segment<3>(3);
    test::fix(m).velocity_valid = true;
    test::fix(m).sigma_horizontal_m = 5;
    test::fix(m).sigma_vertical_m = 8;
    test::fix(m).sigma_velocity_m_s = 0.2;
    return m;
  }
  [[nodiscard]] Measurement plot(double t, int radar, double off_m = 0) {
    Measurement m;
    m.epoch = at(t);
    m.sequence = ++sequence;
    m.source = radar;
    test::polar(m) =
        polar_from_enu(settings.radars[static_cast<std::size_t>(radar)].site.enu_of({Vec<3>(off(t, off_m).head<3>())}));
    return m;
  }
  void accept(const Measurement& m) { rules.accepted(life, m); }
  Remedy reject(const Measurement& m, double track_off_m = 0) {
    return rejected(m, off((m.epoch - at(0)).seconds(), track_off_m));
  }
  /// The track is told with 10 m per axis.
  Remedy rejected(const Measurement& m, const Vec<9>& track, Verdict verdict = Verdict::Gated) {
    return rules.rejected(life, m, verdict, {.mean = track, .cov = 100 * Mat<9, 9>::Identity()});
  }
  /// Fixes at 1 Hz and plots of `radars` radars ten times as often, all of them used, in [from, to).
  void all_well(double from, double to, int radars, bool gps = true) {
    for (int i = 0; from + 0.1 * i < to - 0.01; ++i) {
      const double t = from + 0.1 * i;
      for (int r = 0; r < radars; ++r) accept(plot(t, r));
      if (gps && i % 10 == 0) accept(fix(t));
    }
  }

  MethodSettings settings = two_radars();
  Arbitration rules{settings};
  TargetLife life = rules.unborn();
  std::uint64_t sequence = 0;
};

TEST_F(Rules, ATrackThatNobodyFollowsStartsAnewAfterItsTimeAndNotByCount) {
  all_well(0, 20, 2, false);
  std::optional<double> restarted;
  for (int i = 0; i < 1000 && !restarted; ++i) {  // 200 plots a second: a thousand in those 5 s
    const double t = 20 + 0.005 * i;
    if (reject(plot(t, i % 2, 3000)) == Remedy::Restart) restarted = t;
  }
  EXPECT_FALSE(restarted);
  EXPECT_EQ(reject(plot(25.01, 0, 3000)), Remedy::Restart);
}

TEST_F(Rules, OneAcceptedFixKeepsTheTrackAgainstAllRadars) {
  all_well(0, 20, 2);
  for (int i = 0; i < 1000; ++i) {
    const double t = 20 + 0.1 * i;
    for (int radar = 0; radar < 2; ++radar) ASSERT_NE(reject(plot(t, radar, 3000)), Remedy::Restart) << t;
    if (i % 10 == 0) accept(fix(t));
  }
}

TEST_F(Rules, AnOutlierIsNotWhatALostTrackStartsWith) {
  all_well(0, 20, 1, false);
  for (int i = 0; i < 52; ++i)
    EXPECT_NE(reject(plot(20 + 0.1 * i, 0, i % 2 == 0 ? 200'000 : -30'000)), Remedy::Restart);
  EXPECT_NE(reject(plot(25.3, 0)), Remedy::Restart);  // the first that may be right
  EXPECT_EQ(reject(plot(25.4, 0)), Remedy::Restart);
}

TEST_F(Rules, ALostTrackWaitsForTheReceiverThatIsThere) {
  all_well(0, 20, 1);
  for (int i = 0; i < 60; ++i) {
    const double t = 20 + 0.1 * i;
    const Remedy of_plot = reject(plot(t, 0), 50'000);
    EXPECT_NE(of_plot, Remedy::Restart) << t;
    if (i % 10 == 5) {
      // Two seconds of fixes that agree are enough for union: nobody contradicts them.
      const Remedy of_fix = reject(fix(t), 50'000);
      if (of_fix == Remedy::None) continue;
      EXPECT_EQ(of_fix, Remedy::Unite);
      EXPECT_GE(t, 22);
      return;
    }
  }
  FAIL() << "the receiver was never believed";
}

TEST_F(Rules, AReceiverThatIsNowhereDoesNotKeepALostTrackWaiting) {
  all_well(0, 20, 1);
  std::optional<double> restarted;
  for (int i = 0; i < 60 && !restarted; ++i) {
    const double t = 20 + 0.1 * i;
    if (reject(plot(t, 0), 50'000) == Remedy::Restart) restarted = t;
    if (i % 10 == 5) {
      EXPECT_EQ(reject(fix(t, 10'000.0 * (i % 20)), 50'000), Remedy::None);
    }
  }
  ASSERT_TRUE(restarted);
  EXPECT_NEAR(*restarted, 25, 0.2);
}

/// Fixes without velocity, and a track whose own is far off: they agree with each other nevertheless.
TEST_F(Rules, AReceiverWithoutVelocityIsJudgedByItsOwnMotion) {
  all_well(0, 20, 0);
  Remedy last = Remedy::None;
  for (int i = 0; i < 3; ++i) {
    Measurement m = fix(80 + i);
    test::fix(m).velocity_valid = false;
    Vec<9> track = off(80 + i, 20'000);
    track.segment<3>(3) *= -1;
    EXPECT_EQ(last, Remedy::None);
    last = rejected(m, track);
  }
  EXPECT_EQ(last, Remedy::Unite);
}

TEST_F(Rules, ABiasThatWasOpenedInVainStaysClosedForAMinute) {
  all_well(0, 20, 2);
  std::vector<double> opened;
  for (int i = 0; i < 700; ++i) {
    const double t = 20 + 0.1 * i;
    accept(plot(t, 0));
    if (reject(plot(t, 1, 300)) == Remedy::OpenBias) opened.push_back(t);
  }
  ASSERT_EQ(opened.size(), 2u);
  EXPECT_NEAR(opened[0], 22, 0.2);
  EXPECT_NEAR(opened[1], opened[0] + 60, 2.1);
}

/// Folded ranges, feet, another vehicle: what the radar knows of its bias is kept for when they are over.
TEST_F(Rules, ABiasIsNotOpenedForWhatNoBiasExplains) {
  all_well(0, 20, 2);
  for (int i = 0; i < 600; ++i) {
    const double t = 20 + 0.1 * i;
    accept(plot(t, 0));
    EXPECT_EQ(reject(plot(t, 1, 3000)), Remedy::None);
  }
  // Nor by the first of those that it would explain.
  for (int i = 0; i < 19; ++i) {
    const double t = 80 + 0.1 * i;
    accept(plot(t, 0));
    EXPECT_EQ(reject(plot(t, 1, 300)), Remedy::None);
  }
  EXPECT_EQ(reject(plot(82, 1, 300)), Remedy::OpenBias);
}

TEST_F(Rules, ABiasThatWasFoundMayBeOpenedAgain) {
  all_well(0, 20, 2);
  const auto refuse_for_two_seconds = [&](double from) {
    int opened = 0;
    for (int i = 0; i < 21; ++i) {
      accept(plot(from + 0.1 * i, 0));
      opened += reject(plot(from + 0.1 * i, 1, 300)) == Remedy::OpenBias;
    }
    return opened;
  };
  EXPECT_EQ(refuse_for_two_seconds(20), 1);
  all_well(22.2, 30, 2);
  EXPECT_EQ(refuse_for_two_seconds(30), 1);
}

TEST_F(Rules, TheOnlySourceHasNoBiasToOpen) {
  all_well(0, 20, 1, false);
  for (int i = 0; i < 49; ++i) EXPECT_EQ(reject(plot(20 + 0.1 * i, 0, 300)), Remedy::None);
}

TEST_F(Rules, AReceiverThatJumpsIsNotBelievedAgainstTwoRadars) {
  all_well(0, 20, 2);
  for (int i = 0; i < 600; ++i) {
    const double t = 20 + 0.1 * i;
    for (int radar = 0; radar < 2; ++radar) accept(plot(t, radar));
    if (i % 10 == 0) {
      EXPECT_EQ(reject(fix(t, i < 300 ? 5000 : 200)), Remedy::None) << t;
    }
  }
}

TEST_F(Rules, AReceiverThatJumpsIsNotBelievedAgainstOneRadarEither) {
  all_well(0, 20, 1);
  for (int i = 0; i < 600; ++i) {
    const double t = 20 + 0.1 * i;
    accept(plot(t, 0));
    if (i % 10 == 0) {
      EXPECT_EQ(reject(fix(t, 300)), Remedy::None) << t;
    }
  }
}

TEST_F(Rules, OfTwoThatPartTheOneRadarIsWrongWhereTheReceiverDidNotJump) {
  all_well(0, 20, 1);
  // The track has been pulled away bit by bit: 100 m off when the first fix is refused.
  EXPECT_EQ(reject(fix(20), -100), Remedy::None);
  accept(plot(20.5, 0, -100));
  EXPECT_EQ(reject(fix(21), -110), Remedy::None);
  accept(plot(21.5, 0, -110));
  EXPECT_EQ(reject(fix(22), -120), Remedy::Unite);
}

TEST_F(Rules, AReturningReceiverIsUnitedWithAtItsThirdFixThatAgrees) {
  all_well(0, 20, 2);
  all_well(20, 80, 2, false);
  EXPECT_EQ(reject(fix(80), 150), Remedy::None);
  EXPECT_EQ(reject(fix(81, 4000), 150), Remedy::None);  // an outlier between them
  EXPECT_EQ(reject(fix(82), 150), Remedy::None);
  EXPECT_EQ(reject(fix(83), 150), Remedy::None);
  all_well(83, 84, 2, false);
  EXPECT_EQ(reject(fix(84), 150), Remedy::Unite);
}

TEST_F(Rules, AReturningReceiverBeyondWhatTwoRadarsCouldErrIsNotBelieved) {
  all_well(0, 20, 2);
  for (int i = 0; i < 300; ++i) {
    const double t = 80 + 0.1 * i;
    for (int radar = 0; radar < 2; ++radar) accept(plot(t, radar));
    if (i % 10 == 0) {
      EXPECT_EQ(reject(fix(t, 5000)), Remedy::None) << t;
    }
  }
}

TEST_F(Rules, ATrackThatALiarLedAstrayComesBackWithTheReceiver) {
  all_well(0, 20, 2);
  // The radars' biases were bent to a lie of 3 km; their plots, as measured, never were.
  EXPECT_EQ(reject(fix(20), 3000), Remedy::None);
  EXPECT_EQ(reject(fix(21), 3000), Remedy::None);
  all_well(21, 22, 2, false);
  EXPECT_EQ(reject(fix(22), 3000), Remedy::Unite);
}

/// One radar follows and its bias was bent to a track 3 km off; its plots, as measured, agree with who returns.
TEST_F(Rules, ARadarThatReturnsToATrackLedAstrayIsUnitedWith) {
  all_well(0, 20, 1, false);
  std::optional<double> united;
  for (int i = 0; i < 20 && !united; ++i) {
    const double t = 20 + 0.1 * i;
    accept(plot(t, 0));
    if (reject(plot(t + 0.05, 1), 3000) == Remedy::Unite) united = t + 0.05 - 20;
  }
  ASSERT_TRUE(united);
  EXPECT_NEAR(*united, 1.05, 0.02) << "a second of one vehicle";
}

TEST_F(Rules, ARadarThatReturnsWithALieIsNot) {
  all_well(0, 20, 1, false);
  for (int i = 0; i < 50; ++i) {
    const double t = 20 + 0.1 * i;
    accept(plot(t, 0));
    EXPECT_NE(reject(plot(t + 0.05, 1, 3000)), Remedy::Unite) << t;
  }
}

TEST_F(Rules, ARadarIsNotUnitedWithThatWasHeardAllTheTimeOrBesideAReceiver) {
  for (const bool gps : {false, true}) {
    life = rules.unborn();
    all_well(0, 20, gps ? 1 : 2, gps);
    for (int i = 0; i < 50; ++i) {
      const double t = 20 + 0.1 * i;
      accept(plot(t, 0));
      if (gps && i % 10 == 0) accept(fix(t));
      EXPECT_NE(reject(plot(t + 0.05, 1), 3000), Remedy::Unite) << t;
    }
  }
}

/// Plots that tell no position, or come seldom, can show no vehicle that returns: the radar's bias is opened as ever.
TEST_F(Rules, ARadarThatCannotReturnAsOneVehicleHasItsBiasOpened) {
  for (const bool seldom : {false, true}) {
    life = rules.unborn();
    all_well(0, 20, 1, false);
    const double period_s = seldom ? 2 : 0.1;
    bool opened = false;
    for (int i = 0; i < 2 * settings.arbitration.reopen_after && !opened; ++i) {
      const double t = 20 + period_s * i;
      accept(plot(t, 0));
      Measurement other = plot(t + 0.05, 1);
      std::get<Plot>(other.measured).angles_valid = seldom;
      opened = reject(other, 150) == Remedy::OpenBias;
    }
    EXPECT_TRUE(opened) << (seldom ? "every two seconds" : "range alone");
  }
}

TEST_F(Rules, ABiasThatIsNoneIsTheMotionsOnceAMinute) {
  constexpr double one_in_a_million = 40.52;  // chi2 with 7 degrees of freedom
  EXPECT_FALSE(rules.led_astray(life, plot(0, 0), one_in_a_million - 0.1, 7));
  EXPECT_TRUE(rules.led_astray(life, plot(0.1, 0), one_in_a_million + 0.1, 7));
  EXPECT_FALSE(rules.led_astray(life, plot(59, 0), 1000, 7));
  EXPECT_TRUE(rules.led_astray(life, plot(61, 0), 1000, 7));
  Measurement angles_alone = plot(200, 0);
  std::get<Plot>(angles_alone.measured).range_valid = false;
  EXPECT_FALSE(rules.led_astray(life, angles_alone, 1000, 7)) << "a motion cannot begin by it";
}

TEST_F(Rules, FirstFixesMustAgreeAndBePossible) {
  all_well(0, 20, 2, false);
  const auto first = [&](const Measurement& m) {
    return rules.first_fixes(life, m, truth((m.epoch - at(0)).seconds()));
  };
  EXPECT_EQ(first(fix(20, 8000)), FirstFixes::Wait);
  all_well(20, 21, 2, false);
  EXPECT_EQ(first(fix(21, 8000)), FirstFixes::Contradicted);
  all_well(21, 22, 2, false);
  EXPECT_EQ(first(fix(22)), FirstFixes::Wait);  // differs from the one before
  all_well(22, 23, 2, false);
  EXPECT_EQ(first(fix(23)), FirstFixes::Hold);
}

TEST_F(Rules, AgainstOneRadarFirstFixesMustInsist) {
  all_well(0, 20, 1, false);
  double held = 0;
  for (int i = 0; i < 10 && held == 0; ++i) {
    const double t = 20 + i;
    all_well(t - 0.5, t, 1, false);
    if (rules.first_fixes(life, fix(t, 8000), truth(t)) == FirstFixes::Hold) held = t;
  }
  EXPECT_EQ(held, 25);
}

TEST_F(Rules, AFrozenFixSaysNothing) {
  all_well(0, 20, 2);
  for (int i = 0; i < 100; ++i) EXPECT_EQ(rejected(fix(20 + i), truth(20 + i), Verdict::Frozen), Remedy::None);
  EXPECT_TRUE(rules.was_silent(life, fix(120)));
}

TEST_F(Rules, OneRadarIsAloneAgainstGpsAndTwoAreNot) {
  all_well(0, 20, 2);
  EXPECT_TRUE(rules.alone_against_gps(life, plot(20, 0), true));
  for (int i = 0; i < 3; ++i) (void)rules.alone_against_gps(life, plot(20 + 0.1 * i, 1), true);
  EXPECT_FALSE(rules.alone_against_gps(life, plot(20.3, 0), true));
  EXPECT_FALSE(rules.alone_against_gps(life, plot(20.4, 0), false));
}

TEST(CovarianceUnion, CoversBothAndNoMore) {
  Vec<6> nu;
  nu << 300, 0, 0, 0, 10, 0;
  const Mat<6, 6> term = Arbitration::union_term(nu);
  EXPECT_DOUBLE_EQ(term(0, 0), 300 * 300 * (1 + 1 / 3.0));
  EXPECT_DOUBLE_EQ(term(1, 1), 300 * 300 / 3.0);
  EXPECT_DOUBLE_EQ(term(4, 4), 10 * 10 * (1 + 1 / 3.0));
  EXPECT_TRUE((term.topRightCorner<3, 3>()).isZero());
}

/// A fix that repeats the position before, `dt` after it.
struct Repeats {
  LastFix last;
  Measurement m;
  TrackVelocity track{.m_s = Vec<3>::Zero(), .sigma_m_s = 0.1};

  Repeats() {
    m.measured = Fix{};
    test::fix(m).position.m = Vec<3>(-3.2e6, 4.2e6, 3.6e6);
    test::fix(m).velocity_valid = true;
    test::fix(m).sigma_horizontal_m = test::fix(m).sigma_vertical_m = 5;
    test::fix(m).sigma_velocity_m_s = 0.2;
  }
  bool frozen_after(double dt) {
    m.epoch = m.epoch + seconds(dt);
    return is_frozen(last, m, track);
  }
};

TEST(FrozenReceiver, AtRestOnThePadItMayRepeatItself) {
  Repeats r;
  for (int i = 0; i < 100; ++i) EXPECT_FALSE(r.frozen_after(1)) << i;
}

TEST(FrozenReceiver, TheThirdFixOfAVehicleInFlightIsFrozenWhateverWasRemembered) {
  Repeats r;
  for (int i = 0; i < 5; ++i) EXPECT_FALSE(r.frozen_after(1));
  r.m.in_flight = true;
  EXPECT_TRUE(r.frozen_after(1));
}

TEST(FrozenReceiver, TheThirdFixIsFrozenWhereItsOwnVelocityLives) {
  Repeats r;
  test::fix(r.m).velocity.m_s.x() = 8;
  EXPECT_FALSE(r.frozen_after(1));
  test::fix(r.m).velocity.m_s.x() = 9;
  EXPECT_FALSE(r.frozen_after(1));
  test::fix(r.m).velocity.m_s.x() = 10;
  EXPECT_TRUE(r.frozen_after(1));
  test::fix(r.m).position.m.x() += 30;
  EXPECT_FALSE(r.frozen_after(1));  // it lives again
}

TEST(FrozenReceiver, TheThirdFixIsFrozenWhereTheTrackMoves) {
  Repeats r;
  test::fix(r.m).velocity_valid = false;
  EXPECT_FALSE(r.frozen_after(1));
  EXPECT_FALSE(r.frozen_after(1));
  r.track.m_s.z() = 5;  // radars have seen it go
  EXPECT_TRUE(r.frozen_after(1));
}

TEST(FrozenReceiver, TheSecondFixIsFrozenWhereTheVehicleMustBeElsewhere) {
  Repeats r;
  r.track.m_s.z() = 100;
  EXPECT_FALSE(r.frozen_after(1));
  EXPECT_TRUE(r.frozen_after(1));
}

TEST(FrozenReceiver, ASlowVehicleMayBeFasterThanItsReceiverResolves) {
  Repeats r;
  test::fix(r.m).velocity.m_s.x() = 2;
  r.track.m_s.x() = 2;
  for (int i = 0; i < 4; ++i) EXPECT_FALSE(r.frozen_after(0.1));  // 0.6 m: below a metre
}

}  // namespace
}  // namespace downrange
