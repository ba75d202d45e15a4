/// A command's turn in a rotator's travel: no turn of the mount that nothing asks for.
#include "rotctl/turns.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace downrange::rotctl {
namespace {

constexpr double deg = std::numbers::pi / 180;
constexpr Travel half_turns{-180 * deg, 180 * deg, 0, 90 * deg};
constexpr Travel one_turn{0, 360 * deg, 0, 90 * deg};
constexpr Travel with_overlap{0, 450 * deg, 0, 180 * deg};

double azimuth(Turns& turns, double azimuth_deg, std::optional<double> measured_deg = {}) {
  const Placed placed =
      turns.place(azimuth_deg * deg, 45 * deg, measured_deg ? std::optional(*measured_deg * deg) : std::nullopt);
  return placed.azimuth_rad / deg;
}

TEST(Turns, TheCommandsOwnAzimuthWhereTheTravelHasIt) {
  Turns turns(with_overlap);
  EXPECT_NEAR(azimuth(turns, 10, 370), 10, 1e-9);  // SLAVE plans the turns, wherever the mount is
  EXPECT_NEAR(azimuth(turns, 359), 359, 1e-9);
  EXPECT_NEAR(azimuth(turns, 361), 361, 1e-9);
  EXPECT_NEAR(azimuth(turns, 20), 20, 1e-9);  // it goes around, as SLAVE says
}

TEST(Turns, ElseTheTurnNearestToWhereItPoints) {
  EXPECT_NEAR(azimuth(*std::make_unique<Turns>(with_overlap), -330, 400), 390, 1e-9);
  EXPECT_NEAR(azimuth(*std::make_unique<Turns>(with_overlap), -330, 20), 30, 1e-9);
  EXPECT_NEAR(azimuth(*std::make_unique<Turns>(half_turns), 270), -90, 1e-9);
  EXPECT_NEAR(azimuth(*std::make_unique<Turns>(one_turn), -90), 270, 1e-9);
}

TEST(Turns, AreWholeAndTold) {
  Turns turns(half_turns);
  const Placed placed = turns.place(200 * deg, 45 * deg, std::nullopt);
  EXPECT_NEAR(placed.azimuth_rad / deg, -160, 1e-9);
  EXPECT_NEAR(placed.turn_rad / deg, -360, 1e-9);
  EXPECT_FALSE(placed.held);
}

// A pass through the end of a half-turn travel: one turn, where it is needed.
TEST(Turns, OnePassTurnsOnce) {
  Turns turns(half_turns);
  double last = azimuth(turns, 100);
  int turned = 0;
  for (double a = 100; a < 300; a += 0.25) {
    const double now = azimuth(turns, a);
    turned += std::abs(now - last) > 1.5;
    last = now;
    EXPECT_LE(std::abs(now), 180 + 1e-9);
    EXPECT_LE(std::abs(std::remainder(now - a, 360)), 1 + 1e-9) << a;
  }
  EXPECT_EQ(turned, 1);
}

// 60 s at 40 Hz within half a degree of the end: no step above 1 deg.
TEST(Turns, HoveringAtTheEndTurnsNothing) {
  for (const double begin : {179.0, 182.0}) {  // from either side of it
    Turns turns(half_turns);
    azimuth(turns, begin);
    double last = azimuth(turns, begin < 180 ? 179.6 : 180.4);
    for (int i = 0; i < 2400; ++i) {
      const double now = azimuth(turns, 180 + 0.5 * std::sin(0.37 * i));
      ASSERT_LE(std::abs(now - last), 1.0) << begin << " step " << i;
      last = now;
    }
  }
}

TEST(Turns, HeldAtTheEndIsTold) {
  Turns turns(half_turns);
  azimuth(turns, 179.5);
  const Placed placed = turns.place(180.6 * deg, 95 * deg, std::nullopt);
  EXPECT_NEAR(placed.azimuth_rad / deg, 180, 1e-9);
  EXPECT_NEAR(placed.elevation_rad / deg, 90, 1e-9);
  EXPECT_TRUE(placed.held);
  EXPECT_NEAR(placed.turn_rad, 0, 1e-12);  // what is measured is compared with the command, not with the end
  Turns low(half_turns);
  EXPECT_TRUE(low.place(0, -1 * deg, std::nullopt).held);
  EXPECT_EQ(low.place(0, -1 * deg, std::nullopt).elevation_rad, 0);
}

// A sector: a direction that no turn has is held at the nearer end, and a target that is equally far from both does not
// send the mount from one to the other.
TEST(Turns, ASectorHoldsAtTheNearerEnd) {
  constexpr Travel sector{-90 * deg, 90 * deg, 0, 90 * deg};
  EXPECT_NEAR(azimuth(*std::make_unique<Turns>(sector), 130), 90, 1e-9);
  EXPECT_NEAR(azimuth(*std::make_unique<Turns>(sector), 240), -90, 1e-9);
  Turns turns(sector);
  const double first = azimuth(turns, 179.8);
  for (int i = 0; i < 200; ++i) ASSERT_EQ(azimuth(turns, 180 + 0.5 * std::sin(i)), first);
  EXPECT_NEAR(azimuth(turns, 200), -90, 1e-9);
}

TEST(Turns, AnyAzimuthLandsInTheTravel) {
  for (const Travel& travel : {half_turns, one_turn, with_overlap}) {
    Turns turns(travel);
    for (double a = -1080; a <= 1080; a += 7.3) {
      const double now = azimuth(turns, a);
      EXPECT_GE(now, travel.azimuth_min_rad / deg - 1e-9);
      EXPECT_LE(now, travel.azimuth_max_rad / deg + 1e-9);
      EXPECT_LE(std::abs(std::remainder(now - a, 360)), 1 + 1e-9) << a;
    }
  }
}

}  // namespace
}  // namespace downrange::rotctl
