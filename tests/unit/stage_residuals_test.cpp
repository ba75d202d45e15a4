/// Residuals in units: what a source differs from the track by, beside what is to be expected.
#include <gtest/gtest.h>

#include <cmath>

#include "../support/small_range.hpp"
#include "stage/ingest.hpp"
#include "stage/methods.hpp"

namespace downrange {
namespace {

/// A method whose track is the truth, off by nothing and known to a metre.
class Truth final : public Method {
 public:
  void start(int, Time, const Gaussian<9>&) override {}
  Outcome process(const Measurement&, Time) override { return {}; }
  std::optional<TrackEstimate> fused(int, std::optional<Time> at) const override {
    TrackEstimate e;
    e.epoch = e.data_epoch = at.value_or(test::liftoff);
    const double t = (e.epoch - test::liftoff).seconds();
    e.mean.head<3>() = test::vehicle_at(t).m;
    e.cov.setIdentity();
    return e;
  }
  std::optional<TrackEstimate> gps_track(int, Time) const override { return {}; }
  BiasEstimate bias(int) const override { return known_bias; }
  const SourceAccount& account(int) const override { return account_; }

  BiasEstimate known_bias;

 private:
  SourceAccount account_;
};

constexpr SourceId goheung = 0;
constexpr SourceId station = 2;

class ResidualsTest : public testing::Test {
 protected:
  ResidualsTest() {
    range.radars[0].angle_inflation = 1;
    range.radars[0].rate_hz = 1;
  }
  /// A hundred plots whose range and elevation are off by this.
  ResidualSize after_plots(double range_m, double elevation_rad) {
    Ingest ingest(range);
    Residuals residuals(4, radar_models(range));
    for (int i = 0; i < 100; ++i) {
      RadarTspi plot = test::plot_at(range.radars[0], 30 + 0.25 * i, static_cast<std::uint64_t>(i));
      plot.measured.range_m += range_m;
      plot.measured.elevation_rad += elevation_rad;
      residuals.note(goheung, 0, ingest.judge(plot), truth);
    }
    return residuals.of(goheung);
  }

  RangeConfig range = test::small_range();
  Truth truth;
};

TEST_F(ResidualsTest, OfARadarInRangeAndOnTheSky) {
  const ResidualSize size = after_plots(40, 0.001);
  EXPECT_NEAR(size.m, 40, 0.01);
  EXPECT_NEAR(size.rad, 0.001 / std::sqrt(2.0), 1e-5) << "of two axes one is off";
  EXPECT_NEAR(size.expected_m, std::hypot(25, 1), 0.01);
  EXPECT_NEAR(size.expected_rad, 0.01 * test::deg, 0.002 * test::deg);
}

TEST_F(ResidualsTest, WhatIsKnownOfTheBiasIsTakenOutAndItsSigmaExpected) {
  truth.known_bias.terms = 1;
  truth.known_bias.term[0] = BiasTerm::OffsetRange;
  truth.known_bias.value[0] = 40;
  truth.known_bias.cov(0, 0) = 100;
  const ResidualSize size = after_plots(40, 0);
  EXPECT_NEAR(size.m, 0, 0.01);
  EXPECT_NEAR(size.expected_m, std::sqrt(25.0 * 25 + 1 + 100), 0.01);
}

TEST_F(ResidualsTest, OfAFixPerAxis) {
  range.gps.sigma_horizontal_m = range.gps.sigma_vertical_m = 1;
  Ingest ingest(range);
  Residuals residuals(4, radar_models(range));
  for (int i = 0; i < 20; ++i) {
    GpsFix fix = test::fix_at("goheung-tgs", 30 + i, static_cast<std::uint64_t>(i));
    fix.position.m += Eigen::Vector3d(3, 0, -3);
    fix.sigma_horizontal_m = fix.sigma_vertical_m = 2;
    residuals.note(station, 0, ingest.judge(fix), truth);
  }
  EXPECT_NEAR(residuals.of(station).m, std::sqrt(6.0), 1e-6);
  EXPECT_NEAR(residuals.of(station).expected_m, std::sqrt(5.0), 1e-6);
  EXPECT_EQ(residuals.of(station).rad, 0);
  EXPECT_EQ(residuals.of(goheung).m, 0) << "nothing was seen of it";
}

TEST_F(ResidualsTest, ForgetsWhatWasLongAgo) {
  Ingest ingest(range);
  Residuals residuals(4, radar_models(range));
  for (int i = 0; i < 400; ++i) {
    RadarTspi plot = test::plot_at(range.radars[0], 30 + 0.25 * i, static_cast<std::uint64_t>(i));
    plot.measured.range_m += i < 100 ? 1000 : 0;
    residuals.note(goheung, 0, ingest.judge(plot), truth);
  }
  EXPECT_LT(residuals.of(goheung).m, 40) << "75 s after: e^-3.75 of the root mean square";
}

}  // namespace
}  // namespace downrange
