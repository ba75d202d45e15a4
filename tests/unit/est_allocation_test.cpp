/// In steady state no method allocates: counted at malloc, which operator new and Eigen's matrices both come to.
#include <gtest/gtest.h>

#include <memory>

#include "../support/allocations.hpp"
#include "../support/drawn_flight.hpp"
#include "../support/method_cases.hpp"

namespace downrange {
namespace {

class AllocationCount : public testing::Test {
 protected:
  void SetUp() override {
#ifndef DOWNRANGE_COUNTS_ALLOCATIONS
    GTEST_SKIP() << "a sanitizer has a malloc of its own";
#endif
  }
};

class Allocation : public AllocationCount, public testing::WithParamInterface<test::MethodCase> {};

INSTANTIATE_TEST_SUITE_P(Methods, Allocation, testing::ValuesIn(test::method_cases()),
                         [](const auto& method_case) { return method_case.param.label; });

TEST_F(AllocationCount, IsCounted) {
  EXPECT_GE(test::allocations_of([] {
              const auto p = std::make_unique<int>(1);
              const Eigen::MatrixXd m = Eigen::MatrixXd::Zero(3, *p + 2);
              EXPECT_EQ(m.size(), 9);
            }),
            2u);
}

/// Fixes come 0.5 to 1.5 s late, so that history is rewound all the time. By a receiver alone it takes five minutes
/// until the history has its size.
TEST_P(Allocation, NoneInTheSteadyState) {
  for (auto [sources, f] : test::flights_of_all_kinds(3, 400)) {
    f.settings.motion.kinematics = GetParam().kinematics;
    f.settings.gps.alignment.smooth = GetParam().smooth;
    std::vector<std::pair<Time, const Measurement*>> arrival;
    for (std::size_t i = 0; i < f.measurements.size(); ++i) {
      const Measurement& m = f.measurements[i];
      const bool gps = is_fix(m);
      arrival.push_back({m.epoch + milliseconds(gps ? 500 + static_cast<int>(i * 377 % 1000) : 40), &m});
    }
    std::sort(arrival.begin(), arrival.end());
    const auto method = make_method(GetParam().method, f.settings);
    std::size_t allocated = 0;
    for (const auto& [received, m] : arrival) {
      const std::size_t now = test::allocations_of([&, at = received, &one = *m] {
        (void)method->process(one, at);
        (void)method->fused(0, at);
        if (!is_fix(one)) (void)method->bias(one.source);
      });
      if (m->epoch >= Time{} + seconds(300)) allocated += now;
    }
    EXPECT_EQ(allocated, 0u) << sources;
  }
}

}  // namespace
}  // namespace downrange
