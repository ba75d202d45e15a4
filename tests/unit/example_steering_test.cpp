/// What the consumers of tools/examples do with commands: interpolate, stop, report.
#include "../../tools/examples/steering.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace {

constexpr std::int64_t ms = 1'000'000;
constexpr std::int64_t start = 1'700'000'000'000 * ms;

steering_command command(std::int64_t apply_ms, double azimuth_rad = 1, double rate = 0) {
  steering_command c{};
  c.tick_ns = start + (apply_ms - 100) * ms;
  c.apply_at_ns = start + apply_ms * ms;
  c.valid_until_ns = c.apply_at_ns + 200 * ms;
  c.azimuth_rad = azimuth_rad;
  c.elevation_rad = 0.5;
  c.azimuth_rate_rad_s = rate;
  return c;
}

void take(steering& s, const steering_command& c) { steering_take(&s, c, c.apply_at_ns - 100 * ms); }

TEST(Steering, StopsAtValidUntil) {
  steering s{};
  steering_aim aim{};
  EXPECT_FALSE(steering_at(&s, start, &aim));
  take(s, command(0, 1, 0.1));
  EXPECT_FALSE(steering_at(&s, start - 1, &aim));
  ASSERT_TRUE(steering_at(&s, start + 200 * ms, &aim));
  EXPECT_NEAR(aim.azimuth_rad, 1.02, 1e-9);
  EXPECT_EQ(aim.tick_ns, start - 100 * ms);
  EXPECT_FALSE(steering_at(&s, start + 200 * ms + 1, &aim));
  take(s, command(500));
  EXPECT_FALSE(steering_at(&s, start + 400 * ms, &aim));
}

// 20 deg/s^2 and more: the figures are those of the derivation in stage_slave_command_book_test.
TEST(Steering, InterpolatesToSecondOrderWhereTheAccelerationIsValid) {
  const double w = 2;
  for (const bool second_order : {false, true}) {
    steering s{};
    double worst = 0;
    for (int t = 0; t <= 1000; t += 100) {
      const double phase = w * t * 1e-3;
      steering_command c = command(t, 0.3 * std::sin(phase), 0.3 * w * std::cos(phase));
      c.acceleration_valid = second_order;
      c.azimuth_acceleration_rad_s2 = second_order ? -0.3 * w * w * std::sin(phase) : NAN;
      take(s, c);
      for (int between = 0; t > 0 && between < 100; between += 7) {
        steering_aim aim{};
        ASSERT_TRUE(steering_at(&s, start + (t - 100 + between) * ms, &aim));
        worst = std::max(worst, std::abs(aim.azimuth_rad - 0.3 * std::sin(w * (t - 100 + between) * 1e-3)));
      }
    }
    if (second_order)
      EXPECT_LT(worst, 5e-5);
    else
      EXPECT_NEAR(worst, 1.5e-3, 0.2e-3);
  }
}

TEST(Steering, GoesAroundAtOnce) {
  steering s{};
  steering_aim aim{};
  take(s, command(0, 4.7));
  take(s, command(25, -1.58));
  ASSERT_TRUE(steering_at(&s, start + 24 * ms, &aim));
  EXPECT_NEAR(aim.azimuth_rad, 4.7, 1e-12);
  ASSERT_TRUE(steering_at(&s, start + 25 * ms, &aim));
  EXPECT_NEAR(aim.azimuth_rad, -1.58, 1e-12);
}

TEST(Steering, TakesNoOldNewsNoFutureAndNothingThatIsNotFinite) {
  steering s{};
  take(s, command(50));
  take(s, command(50, 2));
  take(s, command(25, 2));
  take(s, command(75, std::numeric_limits<double>::quiet_NaN()));
  take(s, command(75, 2, std::numeric_limits<double>::infinity()));
  steering_command c = command(75, 2);
  c.acceleration_valid = true;
  c.elevation_acceleration_rad_s2 = NAN;
  take(s, c);
  steering_take(&s, command(3'600'000, 2), start);
  EXPECT_EQ(s.count, 1);
  EXPECT_EQ(s.command[0].azimuth_rad, 1);
}

TEST(Steering, KeepsTheNewestOfManyCommands) {
  steering s{};
  for (int t = 0; t < 10'000; t += 25) take(s, command(t, t * 1e-3));
  steering_aim aim{};
  ASSERT_TRUE(steering_at(&s, start + 9'975 * ms, &aim));
  EXPECT_NEAR(aim.azimuth_rad, 9.975, 1e-12);
  ASSERT_TRUE(steering_at(&s, start + 8'500 * ms, &aim));
}

// On a ramp a servo that is told what will be when it is there has no lag.
TEST(Mount, LeadsItsServoAndTellsWhichCommandItFollows) {
  steering s{};
  mount m{};
  int step = 1;
  for (int t = 0; t < 2'000; t += servo_step_ms, ++step) {
    if (t % 20 == 0) steering_take(&s, command(t + 100, 0.2 * (t + 100) * 1e-3, 0.2), start + t * ms);
    mount_step(&m, &s, start + t * ms, step);
    if (t < 500) continue;
    EXPECT_TRUE(m.follows);
    EXPECT_NEAR(m.azimuth_rad, 0.2 * t * 1e-3, 0.4e-3 * static_cast<double>(servo_step_ms)) << t;
    EXPECT_GT(m.tick_ns, start + (t - 100) * ms);
  }
  const double last = m.azimuth_rad;
  mount_step(&m, &s, start + 3'000 * ms, step);
  EXPECT_FALSE(m.follows);
  EXPECT_EQ(m.tick_ns, 0);
  EXPECT_EQ(m.azimuth_rad, last);  // it stands still
}

}  // namespace
