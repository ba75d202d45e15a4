/// Where an antenna shall point at an instant, from the commands that it has.
#include "stage/slave/command_book.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace downrange {
namespace {

constexpr Time start{1'700'000'000'000'000'000};
constexpr Duration tick = milliseconds(25);
constexpr Duration ahead = milliseconds(100);
constexpr double nan = std::numeric_limits<double>::quiet_NaN();

Time at_ms(std::int64_t ms) { return start + milliseconds(ms); }

SlavingCommand command(std::int64_t apply_ms, double azimuth_rad = 1, double rate = 0) {
  SlavingCommand c;
  c.antenna = "dish";
  c.apply_at = at_ms(apply_ms);
  c.tick = c.apply_at - ahead;
  c.valid_until = c.apply_at + milliseconds(200);
  c.azimuth_rad = azimuth_rad;
  c.elevation_rad = 0.5;
  c.azimuth_rate_rad_s = rate;
  return c;
}

TEST(CommandBook, CarriesTheNewestOnByItsRateUntilItExpires) {
  CommandBook book(ahead);
  EXPECT_FALSE(book.at(at_ms(0)));
  EXPECT_FALSE(book.valid_until());
  ASSERT_TRUE(book.take(command(50, 1, 0.2), at_ms(0)));
  EXPECT_FALSE(book.at(at_ms(49)));  // not yet
  EXPECT_DOUBLE_EQ(book.at(at_ms(50))->azimuth_rad, 1);
  EXPECT_NEAR(book.at(at_ms(150))->azimuth_rad, 1.02, 1e-12);
  EXPECT_EQ(book.at(at_ms(150))->tick, at_ms(-50));
  EXPECT_TRUE(book.at(at_ms(250)));
  EXPECT_FALSE(book.at(at_ms(250) + Duration{1}));
  EXPECT_EQ(book.valid_until(), at_ms(250));
}

// On a circle of 20 deg/s^2: the second order is what a servo needs between 40 Hz commands, and much more at 10 Hz.
TEST(CommandBook, SecondOrderWhereTheAccelerationIsValid) {
  const double w = 2;
  const auto truth = [w](Time t) { return 0.3 * std::sin(w * (t - start).seconds()); };
  const auto worst = [&](bool second_order) {
    double error = 0;
    CommandBook book(ahead);
    for (int ms = 0; ms <= 1000; ms += 100) {
      SlavingCommand c = command(ms);
      const double s = (c.apply_at - start).seconds();
      c.azimuth_rad = 0.3 * std::sin(w * s);
      c.azimuth_rate_rad_s = 0.3 * w * std::cos(w * s);
      c.azimuth_acceleration_rad_s2 = second_order ? -0.3 * w * w * std::sin(w * s) : nan;  // not to be read
      c.elevation_acceleration_rad_s2 = second_order ? 0 : nan;
      c.acceleration_valid = second_order;
      EXPECT_TRUE(book.take(c, at_ms(ms)));
      for (int later = 0; ms > 0 && later < 100; later += 7) {
        const Time t = at_ms(ms - 100 + later);
        error = std::max(error, std::abs(book.at(t)->azimuth_rad - truth(t)));
      }
    }
    return error;
  };
  // Half of h^2 a / 4 = 1.5e-3 between, first order; h^3 w^3 / 6 at the ends, weighed to a fifth of it, second order.
  EXPECT_NEAR(worst(false), 1.5e-3, 0.2e-3);
  EXPECT_LT(worst(true), 5e-5);
}

TEST(CommandBook, BehindTheNewestSecondOrderToo) {
  CommandBook book(ahead);
  SlavingCommand c = command(0, 1, 0.1);
  c.azimuth_acceleration_rad_s2 = 0.4;
  c.elevation_acceleration_rad_s2 = -0.4;
  c.acceleration_valid = true;
  ASSERT_TRUE(book.take(c, at_ms(0)));
  EXPECT_NEAR(book.at(at_ms(100))->azimuth_rad, 1 + 0.01 + 0.002, 1e-12);
  EXPECT_NEAR(book.at(at_ms(100))->elevation_rad, 0.5 - 0.002, 1e-12);
}

TEST(CommandBook, GoesFromCommandToCommandWithoutAStep) {
  CommandBook book(ahead);
  for (std::int64_t i = 0; i < 20; ++i) {
    SlavingCommand c =
        command(25 * i, 1 + 0.001 * static_cast<double>(i % 3), 0.05 * static_cast<double>(i % 2));  // noisy
    c.azimuth_acceleration_rad_s2 = 0.1;
    c.acceleration_valid = i % 5 != 0;
    ASSERT_TRUE(book.take(c, at_ms(25 * i)));
  }
  double last = book.at(at_ms(0))->azimuth_rad;
  for (int ms = 1; ms < 475; ++ms) {
    const double now = book.at(at_ms(ms))->azimuth_rad;
    EXPECT_LT(std::abs(now - last), 3e-4) << ms;  // 2 mrad over 25 ms
    last = now;
  }
}

TEST(CommandBook, GoesAroundAtOnceAndNotByWayOfTheMiddle) {
  CommandBook book(ahead);
  ASSERT_TRUE(book.take(command(0, 4.7, 0.1), at_ms(0)));
  ASSERT_TRUE(book.take(command(25, -1.58, 0.1), at_ms(0)));
  EXPECT_NEAR(book.at(at_ms(24))->azimuth_rad, 4.7024, 1e-12);
  EXPECT_NEAR(book.at(at_ms(25))->azimuth_rad, -1.58, 1e-12);
}

TEST(CommandBook, AGapIsAGap) {
  CommandBook book(ahead);
  ASSERT_TRUE(book.take(command(0), at_ms(0)));
  ASSERT_TRUE(book.take(command(500), at_ms(450)));
  EXPECT_TRUE(book.at(at_ms(200)));
  EXPECT_FALSE(book.at(at_ms(201)));
  EXPECT_FALSE(book.at(at_ms(499)));
  EXPECT_TRUE(book.at(at_ms(500)));
}

TEST(CommandBook, TakesNoOldNewsNothingExpiredAndNothingThatIsNotFinite) {
  CommandBook book(ahead);
  ASSERT_TRUE(book.take(command(50, 1), at_ms(0)));
  EXPECT_FALSE(book.take(command(50, 2), at_ms(0)));
  EXPECT_FALSE(book.take(command(25, 2), at_ms(0)));
  EXPECT_FALSE(book.take(command(75), at_ms(276)));
  EXPECT_EQ(book.expired(), 1u);
  EXPECT_FALSE(book.take(command(75, nan), at_ms(0)));
  EXPECT_FALSE(book.take(command(75, 1, std::numeric_limits<double>::infinity()), at_ms(0)));
  SlavingCommand c = command(75);
  c.elevation_acceleration_rad_s2 = nan;
  c.acceleration_valid = true;
  EXPECT_FALSE(book.take(c, at_ms(0)));
  c = command(75);
  c.valid_until = c.apply_at - Duration{1};
  EXPECT_FALSE(book.take(c, at_ms(0)));
  EXPECT_DOUBLE_EQ(book.at(at_ms(60))->azimuth_rad, 1);
}

// A node whose clock was an hour fast for a moment must not silence all that follow.
TEST(CommandBook, ACommandFromTheFutureIsNotTaken) {
  CommandBook book(ahead);
  EXPECT_TRUE(book.take(command(1100), at_ms(0)));
  EXPECT_FALSE(book.take(command(3'600'000), at_ms(25)));
  EXPECT_EQ(book.from_future(), 1u);
  EXPECT_TRUE(book.take(command(1125), at_ms(50)));
}

TEST(CommandBook, DoesNotGrow) {
  CommandBook book(ahead);
  Time now = start;
  for (int i = 0; i < 100'000; ++i, now = now + tick) {
    SlavingCommand c = command(0);
    c.apply_at = now + ahead;
    c.valid_until = c.apply_at + milliseconds(200);
    ASSERT_TRUE(book.take(c, now));
  }
  EXPECT_TRUE(book.at(now - milliseconds(900)));
  EXPECT_FALSE(book.at(now - milliseconds(1300)));  // long gone
}

}  // namespace
}  // namespace downrange
