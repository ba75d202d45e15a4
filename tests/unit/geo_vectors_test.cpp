/// Geodesy and conversions against vectors computed elsewhere (tolerance 1e-9 relative as their README states).
#include <gtest/gtest.h>

#include <downrange/geo/earth.hpp>
#include <downrange/geo/polar.hpp>
#include <downrange/geo/site.hpp>
#include <numbers>

#include "../support/vectors.hpp"

namespace downrange {
namespace {

using test::matrix_of;
using test::relative_error;
using test::vector_of;

TEST(GeodesyVectors, PublishedPoints) {
  // NIMA TR8350.2 (WGS-84), table 3.1: semi-axes; the poles and the equator are exact.
  EXPECT_NEAR(ecef_from_geodetic({std::numbers::pi / 2, 0, 0}).m.z(), 6356752.3142, 5e-5);
  EXPECT_NEAR(ecef_from_geodetic({0, 0, 0}).m.x(), 6378137.0, 1e-9);
  // EPSG Guidance Note 7-2 (2012), section 2.2.1: 53 48 33.820 N, 2 07 46.380 E, 73.0 m -> to the printed millimetre.
  const double deg = std::numbers::pi / 180;
  const Geodetic g{(53 + 48 / 60.0 + 33.820 / 3600) * deg, (2 + 7 / 60.0 + 46.380 / 3600) * deg, 73.0};
  const Eigen::Vector3d p = ecef_from_geodetic(g).m;
  EXPECT_NEAR(p.x(), 3771793.968, 1e-3);
  EXPECT_NEAR(p.y(), 140253.342, 1e-3);
  EXPECT_NEAR(p.z(), 5124304.349, 1e-3);
}

TEST(GeodesyVectors, Wgs84) {
  DOWNRANGE_VECTOR_CASES(cases, "wgs84.json");
  for (const auto& c : cases) {
    const Geodetic g{c["lat"], c["lon"], c["h"]};
    const Position<Ecef> p = ecef_from_geodetic(g);
    EXPECT_LT(relative_error(p.m, vector_of(c["ecef"])), 1e-9);
    EXPECT_LT(relative_error(enu_from_ecef_at(g).R, matrix_of(c["R_ecef2enu"])), 1e-9);
    EXPECT_LT(relative_error(Site(g).R_sez_ecef().R, matrix_of(c["R_ecef2sez"])), 1e-9);
    const Geodetic back = geodetic_from_ecef({vector_of(c["ecef"])});
    EXPECT_NEAR(back.latitude_rad, g.latitude_rad, 1e-12);
    EXPECT_NEAR(back.height_m, g.height_m, 1e-6);
  }
}

TEST(GeodesyVectors, LaunchGeometry) {
  DOWNRANGE_VECTOR_CASES(cases, "launch_geometry.json");
  for (const auto& c : cases) {
    const Eigen::Vector3d lla = vector_of(c["site_lla"]);
    const Site site({lla[0], lla[1], lla[2]});
    const Position<Ecef> target{vector_of(c["target_ecef"])};
    const Displacement<Enu> enu = site.enu_of(target);
    EXPECT_LT(relative_error((site.R_sez_ecef() * (target - site.ecef())).m, vector_of(c["sez"])), 1e-9);

    const Polar q = polar_from_enu(enu);
    const Eigen::Vector3d rae = vector_of(c["rae"]);
    EXPECT_NEAR(q.range_m, rae[0], 1e-9 * rae[0]);
    // The papers' azimuth is atan2(E, S) = pi - (clockwise from north).
    EXPECT_NEAR(wrap_pi(std::numbers::pi - q.azimuth_rad - rae[1]), 0, 1e-12);
    EXPECT_NEAR(q.elevation_rad, rae[2], 1e-12);

    // Columns from (S, E, Z) to (E, N, U): d/dE is column 1, d/dN is minus column 0; the azimuth row changes sign.
    const Eigen::MatrixXd jac_sez = matrix_of(c["jac_rae"]);
    Eigen::Matrix3d expected;
    expected << jac_sez.col(1), -jac_sez.col(0), jac_sez.col(2);
    expected.row(1) *= -1;
    for (int row = 0; row < 3; ++row)
      EXPECT_LT(relative_error(d_polar_d_enu(enu).row(row), expected.row(row)), 1e-9) << "row " << row;

    const Eigen::Vector3d accel = free_fall_acceleration(target, {vector_of(c["target_vel_ecef"])});
    EXPECT_LT(relative_error(accel, vector_of(c["accel_grav_coriolis_centrifugal_ecef"])), 1e-9);
  }
}

/// The vectors hold (south, east, up) with azimuth pi - ours; reorder ours.
Polar from_paper(const Eigen::Vector3d& rae) { return {rae[0], wrap_two_pi(std::numbers::pi - rae[1]), rae[2]}; }

TEST(ConversionVectors, AllThreeForms) {
  DOWNRANGE_VECTOR_CASES(cases, "debiased_conversion.json");
  const Eigen::Matrix3d R_sez_enu = sez_from_enu().R;
  for (const auto& c : cases) {
    const Eigen::Vector3d s = vector_of(c["sigma"]);
    const PolarSigma sigma{s[0], s[1], s[2]};
    const Polar q = from_paper(vector_of(c["rae"]));
    // The vectors subtract products of size range^2 in double precision: they carry eps range^2 / R themselves
    // (1e-8 at 300 km; their README grants 1e-6 at 1000 km). Ours are formed without that subtraction.
    const double tolerance = q.range_m >= 1e6 ? 1e-6 : q.range_m >= 3e5 ? 2e-8 : 1e-9;
    const auto check = [&](const ConvertedMeasurement& m, const char* z, const char* R) {
      EXPECT_LT(relative_error(R_sez_enu * m.z.m, vector_of(c[z])), 1e-9) << z << " range " << q.range_m;
      EXPECT_LT(relative_error(R_sez_enu * m.R * R_sez_enu.transpose(), matrix_of(c[R])), tolerance)
          << R << " range " << q.range_m;
    };
    check(raw_conversion_statistics(q, sigma), "raw_mean_given_truth", "raw_cov_given_truth");
    check(convert_unbiased(q, sigma), "unbiased_z", "unbiased_R");
    check(convert_additive(q, sigma), "additive_debiased_z", "additive_debiased_R");
  }
}

}  // namespace
}  // namespace downrange
