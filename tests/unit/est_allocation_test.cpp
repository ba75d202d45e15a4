/// In steady state no method allocates: counted at malloc, which operator new and Eigen's matrices both come to.
#include <gtest/gtest.h>

#include <atomic>
#include <cstddef>
#include <memory>

#include "../support/drawn_flight.hpp"

namespace {

std::atomic<long> allocations{0};

}  // namespace

// A sanitizer has a malloc of its own.
#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
#define DOWNRANGE_COUNTS_ALLOCATIONS
extern "C" {
void* __libc_malloc(std::size_t size);
void* malloc(std::size_t size) {
  ++allocations;
  return __libc_malloc(size);
}
}
#endif

namespace downrange {
namespace {

struct Case {
  const char* method;
  Kinematics kinematics;
};

class AllocationCount : public testing::Test {
 protected:
  void SetUp() override {
#ifndef DOWNRANGE_COUNTS_ALLOCATIONS
    GTEST_SKIP() << "a sanitizer has a malloc of its own";
#endif
  }
};

class Allocation : public AllocationCount, public testing::WithParamInterface<Case> {};

INSTANTIATE_TEST_SUITE_P(Methods, Allocation,
                         testing::Values(Case{"joint", Kinematics::Cv}, Case{"joint", Kinematics::Ca},
                                         Case{"joint", Kinematics::Launch}, Case{"joint", Kinematics::Vdie},
                                         Case{"schmidt", Kinematics::Ca}, Case{"schmidt", Kinematics::Launch},
                                         Case{"song2015", Kinematics::Cv}, Case{"uncorrected", Kinematics::Cv}));

TEST_F(AllocationCount, IsCounted) {
  const long before = allocations;
  const auto p = std::make_unique<int>(1);
  const Eigen::MatrixXd m = Eigen::MatrixXd::Zero(3, *p + 2);
  EXPECT_GE(allocations - before, 2) << m;
}

/// Fixes come 0.5 to 1.5 s late, so that history is rewound all the time.
TEST_P(Allocation, NoneInTheSteadyState) {
  test::Flight f = test::draw_flight(3, 90, true);
  f.settings.kinematics = GetParam().kinematics;
  std::vector<std::pair<Time, const Measurement*>> arrival;
  for (std::size_t i = 0; i < f.measurements.size(); ++i) {
    const Measurement& m = f.measurements[i];
    const bool gps = m.kind == Measurement::Kind::Gps;
    arrival.push_back({m.epoch + milliseconds(gps ? 500 + static_cast<int>(i * 377 % 1000) : 40), &m});
  }
  std::sort(arrival.begin(), arrival.end());
  const auto method = make_method(GetParam().method, f.settings);
  long at_start = 0;
  for (const auto& [received, m] : arrival) {
    if (m->epoch < Time{} + seconds(60)) at_start = allocations;
    (void)method->process(*m, received);
    (void)method->fused(0, received);
    (void)method->bias(0);
  }
  EXPECT_EQ(allocations - at_start, 0);
}

}  // namespace
}  // namespace downrange
