/// The state of a method, saved and restored: what INTEGRITY undoes a lie with.
#include <gtest/gtest.h>

#include <downrange/est/method/method_table.hpp>

#include "../support/drawn_flight.hpp"
#include "../support/method_cases.hpp"

namespace downrange {
namespace {

RestorableMethod& restorable(Method& method) { return dynamic_cast<RestorableMethod&>(method); }

class MethodStates : public testing::TestWithParam<test::MethodCase> {
 protected:
  static test::Flight flight() {
    test::Flight f = test::draw_flight(5, 30, true);
    f.settings.motion.kinematics = GetParam().kinematics;
    f.settings.gps.alignment.smooth = GetParam().smooth;
    return f;
  }
  static std::unique_ptr<Method> made(const test::Flight& f) { return make_method(GetParam().method, f.settings); }
  static void expect_same(const Method& a, const Method& b) {
    const auto x = a.fused(0);
    const auto y = b.fused(0);
    ASSERT_EQ(x.has_value(), y.has_value());
    if (x) {
      EXPECT_EQ(x->epoch, y->epoch);
      EXPECT_EQ(x->mean, y->mean);
      EXPECT_EQ(x->cov, y->cov);
      EXPECT_EQ(x->nis, y->nis);
    }
    for (int radar = 0; radar < 2; ++radar) {
      EXPECT_EQ(a.bias(radar).value, b.bias(radar).value);
      EXPECT_EQ(a.bias(radar).cov, b.bias(radar).cov);
    }
  }
};

INSTANTIATE_TEST_SUITE_P(Methods, MethodStates, testing::ValuesIn(test::method_cases()),
                         [](const auto& method_case) { return method_case.param.label; });

constexpr Time before = Time{} + seconds(33.0);

/// To the bit: the one that never heard radar 1 after the instant, and the one that heard it and went back.
TEST_P(MethodStates, RestoredItGoesOnAsIfItHadHeardNothingElse) {
  const test::Flight f = flight();
  const auto heard_all = made(f);
  const auto never_heard = made(f);
  const auto state = restorable(*heard_all).make_state();
  for (const Measurement& m : f.measurements) {
    if (m.epoch > before + seconds(4.0)) break;  // inside the history of 5 s
    (void)heard_all->process(m, m.epoch);
  }
  restorable(*heard_all).save(before, *state);
  const auto again = made(f);
  restorable(*again).restore(*state);
  restorable(*heard_all).restore(*state);
  for (const Measurement& m : f.measurements) {
    const bool of_radar_1 = m.source == 1;
    if (m.epoch >= before && of_radar_1) continue;
    (void)never_heard->process(m, m.epoch);
    if (m.epoch < before) continue;
    (void)again->process(m, m.epoch);
    (void)heard_all->process(m, m.epoch);
  }
  expect_same(*again, *never_heard);
  expect_same(*heard_all, *never_heard);
}

TEST_P(MethodStates, ASavedStateIsAValueOfItsOwn) {
  const test::Flight f = flight();
  const auto method = made(f);
  const auto state = restorable(*method).make_state();
  std::size_t i = 0;
  for (; f.measurements[i].epoch < before; ++i) (void)method->process(f.measurements[i], f.measurements[i].epoch);
  restorable(*method).save(before, *state);
  const auto then = made(f);
  restorable(*then).restore(*state);
  for (; i < f.measurements.size(); ++i) (void)method->process(f.measurements[i], f.measurements[i].epoch);
  const auto later = made(f);
  restorable(*later).restore(*state);
  expect_same(*later, *then);
}

TEST(MethodState, OfAnotherKindOfMethodIsRefused) {
  const test::Flight f = test::draw_flight(1, 1, true);
  const auto joint = make_method("joint", f.settings);
  const auto of_ts = restorable(*make_method("ts", f.settings)).make_state();
  EXPECT_THROW(restorable(*joint).restore(*of_ts), std::bad_cast);
  EXPECT_THROW(restorable(*joint).save(before, *of_ts), std::bad_cast);
}

}  // namespace
}  // namespace downrange
