/// Polygons on the ellipsoid: which side is inside, how far, over the date line and around a pole.
#include <gtest/gtest.h>

#include <GeographicLib/Geodesic.hpp>
#include <GeographicLib/GeodesicLine.hpp>
#include <algorithm>
#include <cmath>
#include <downrange/geo/ground_polygon.hpp>
#include <limits>
#include <numbers>
#include <random>

namespace downrange {
namespace {

using GeographicLib::Geodesic;
constexpr double deg = std::numbers::pi / 180;

GroundPoint at(double latitude_deg, double longitude_deg) { return {latitude_deg * deg, longitude_deg * deg}; }

using Vertices = std::vector<GroundPoint>;

Vertices corridor() { return {at(34.6, 127.3), at(34.6, 127.8), at(10, 135), at(-12, 139), at(-12, 126), at(10, 125)}; }
Vertices over_the_date_line() { return {at(-20, 170), at(-20, -170), at(15, -165), at(15, 172)}; }
Vertices around_the_pole() { return {at(70, 0), at(75, 60), at(68, 120), at(72, 180), at(70, 240), at(74, 300)}; }
Vertices small_pad() { return {at(34.43, 127.53), at(34.43, 127.54), at(34.44, 127.535)}; }

/// The shortest of the geodesics to many points of the edges.
double brute_force_distance(const Vertices& vertices, const GroundPoint& p) {
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < vertices.size(); ++i) {
    const GroundPoint& a = vertices[i];
    const GroundPoint& b = vertices[(i + 1) % vertices.size()];
    const auto edge = Geodesic::WGS84().InverseLine(a.latitude_rad / deg, a.longitude_rad / deg, b.latitude_rad / deg,
                                                    b.longitude_rad / deg);
    const auto to = [&](double s) {
      double lat = 0;
      double lon = 0;
      double d = 0;
      edge.Position(s, lat, lon);
      Geodesic::WGS84().Inverse(p.latitude_rad / deg, p.longitude_rad / deg, lat, lon, d);
      return d;
    };
    constexpr int samples = 200;
    double best = 0;
    double nearest = std::numeric_limits<double>::infinity();
    for (int k = 0; k <= samples; ++k) {
      const double s = edge.Distance() * k / samples;
      if (const double d = to(s); d < nearest) {
        nearest = d;
        best = s;
      }
    }
    double low = std::max(0.0, best - edge.Distance() / samples);
    double high = std::min(edge.Distance(), best + edge.Distance() / samples);
    for (int k = 0; k < 60; ++k) {
      const double third = (high - low) / 3;
      (to(low + third) < to(high - third) ? high : low) =
          to(low + third) < to(high - third) ? high - third : low + third;
    }
    least = std::min(least, to((low + high) / 2));
  }
  return least;
}

TEST(GroundPolygon, DistanceIsThatOfTheNearestGeodesic) {
  std::mt19937_64 rng(7);
  std::uniform_real_distribution<double> azimuth(0, 360);
  std::uniform_real_distribution<double> log_distance(0, std::log(5e6));
  for (const Vertices& vertices : {corridor(), over_the_date_line(), around_the_pole(), small_pad()}) {
    const GroundPolygon polygon(vertices);
    for (int i = 0; i < 40; ++i) {
      const GroundPoint& from = vertices[static_cast<std::size_t>(i) % vertices.size()];
      GroundPoint p;
      Geodesic::WGS84().Direct(from.latitude_rad / deg, from.longitude_rad / deg, azimuth(rng),
                               std::exp(log_distance(rng)), p.latitude_rad, p.longitude_rad);
      p = at(p.latitude_rad, p.longitude_rad);
      const double exact = brute_force_distance(vertices, p);
      EXPECT_NEAR(std::abs(polygon.signed_distance_m(p)), exact, 1e-5 * exact + 0.03)
          << p.latitude_rad / deg << ' ' << p.longitude_rad / deg;
    }
  }
}

TEST(GroundPolygon, PositiveInsideEitherWayAround) {
  for (const bool reversed : {false, true}) {
    Vertices vertices = corridor();
    if (reversed) std::ranges::reverse(vertices);
    const GroundPolygon polygon(vertices);
    EXPECT_GT(polygon.signed_distance_m(at(20, 130)), 2e5);
    EXPECT_LT(polygon.signed_distance_m(at(20, 120)), -2e5);
    EXPECT_LT(polygon.signed_distance_m(at(40, 130)), -2e5);
    EXPECT_LT(polygon.signed_distance_m(at(-20, -50)), -9e6) << "the antipode's side";
    EXPECT_NEAR(polygon.signed_distance_m(vertices[2]), 0, 1e-3);
  }
  Vertices closed = corridor();
  closed.push_back(closed.front());
  EXPECT_EQ(GroundPolygon(closed).outline().size(), GroundPolygon(corridor()).outline().size());
}

TEST(GroundPolygon, TheSignChangesAtTheLine) {
  // Across the middle of each edge, a metre to both sides.
  for (const Vertices& vertices : {corridor(), over_the_date_line(), around_the_pole(), small_pad()}) {
    const GroundPolygon polygon(vertices);
    for (std::size_t i = 0; i < vertices.size(); ++i) {
      const GroundPoint& a = vertices[i];
      const GroundPoint& b = vertices[(i + 1) % vertices.size()];
      const auto edge = Geodesic::WGS84().InverseLine(a.latitude_rad / deg, a.longitude_rad / deg, b.latitude_rad / deg,
                                                      b.longitude_rad / deg);
      double lat = 0;
      double lon = 0;
      double azimuth = 0;
      edge.Position(edge.Distance() / 2, lat, lon, azimuth);
      std::array<double, 2> side{};
      for (int k = 0; k < 2; ++k) {
        double x = 0;
        double y = 0;
        Geodesic::WGS84().Direct(lat, lon, azimuth + 90 - 180 * k, 1, x, y);
        side[static_cast<std::size_t>(k)] = polygon.signed_distance_m(at(x, y));
      }
      EXPECT_LT(side[0] * side[1], 0) << i;
      EXPECT_NEAR(std::abs(side[0]), 1, 0.03) << i;  // a geodesic is a great arc of geocentric directions to this
      EXPECT_NEAR(std::abs(side[1]), 1, 0.03) << i;
    }
  }
}

TEST(GroundPolygon, OverTheDateLineAndAroundThePole) {
  const GroundPolygon date(over_the_date_line());
  for (const double longitude : {179.9, -179.9, 180.0, 180.1, -180.0})
    EXPECT_GT(date.signed_distance_m(at(0, longitude)), 5e5) << longitude;
  EXPECT_LT(date.signed_distance_m(at(0, 160)), 0);
  EXPECT_LT(date.signed_distance_m(at(0, -150)), 0);
  EXPECT_LT(date.signed_distance_m(at(0, 0)), 0);
  const GroundPolygon pole(around_the_pole());
  EXPECT_GT(pole.signed_distance_m(at(90, 0)), 1.5e6);
  EXPECT_NEAR(pole.signed_distance_m(at(90, 0)), pole.signed_distance_m(at(90, 123)), 1e-3);
  for (double longitude = -180; longitude < 360; longitude += 17) {
    EXPECT_GT(pole.signed_distance_m(at(80, longitude)), 0) << longitude;
    EXPECT_LT(pole.signed_distance_m(at(60, longitude)), 0) << longitude;
  }
  EXPECT_LT(pole.signed_distance_m(at(-90, 0)), -1e7);
}

TEST(GroundPolygon, DistanceAhead) {
  const GroundPolygon polygon({at(-1, -1), at(-1, 1), at(1, 1), at(1, -1)});
  // From the middle of the equator to the meridian at 1 deg: a geodesic of one degree of the equator.
  const double degree = 6378137.0 * deg;
  EXPECT_NEAR(polygon.distance_ahead_m(at(0, 0), 90 * deg).value(), degree, 0.01);
  EXPECT_NEAR(polygon.distance_ahead_m(at(0, 0), -90 * deg).value(), degree, 0.01);
  EXPECT_NEAR(polygon.distance_ahead_m(at(0, 0.5), 90 * deg).value(), degree / 2, 0.01);
  EXPECT_NEAR(polygon.distance_ahead_m(at(0, 2), -90 * deg).value(), degree, 0.01) << "from outside, to the near side";
  EXPECT_FALSE(polygon.distance_ahead_m(at(0, 2), 90 * deg)) << "away from it";
  EXPECT_FALSE(polygon.distance_ahead_m(at(5, 0), 90 * deg)) << "past it";
  // Over the pole and the date line.
  const GroundPolygon pole(around_the_pole());
  EXPECT_TRUE(pole.distance_ahead_m(at(89.99, 50), 0));
  const GroundPolygon date(over_the_date_line());
  EXPECT_TRUE(date.distance_ahead_m(at(0, 179), 90 * deg));
  EXPECT_NEAR(date.distance_ahead_m(at(0, 160), 90 * deg).value(), -date.signed_distance_m(at(0, 160)), 5e4);
}

TEST(GroundPolygon, DistanceAheadEndsOnTheLine) {
  std::mt19937_64 rng(3);
  std::uniform_real_distribution<double> azimuth(0, 360);
  for (const Vertices& vertices : {corridor(), over_the_date_line(), around_the_pole(), small_pad()}) {
    const GroundPolygon polygon(vertices);
    const GroundPoint from = vertices == around_the_pole() ? at(85, 30)
                             : vertices == small_pad()     ? at(34.433, 127.535)
                             : vertices == corridor()      ? at(5, 130)
                                                           : at(0, 180);
    ASSERT_TRUE(polygon.contains(from));
    for (int i = 0; i < 30; ++i) {
      const double a = azimuth(rng);
      const auto way = polygon.distance_ahead_m(from, a * deg);
      ASSERT_TRUE(way) << "from inside every way leads out";
      double lat = 0;
      double lon = 0;
      Geodesic::WGS84().Direct(from.latitude_rad / deg, from.longitude_rad / deg, a, *way, lat, lon);
      // Straight ahead in geocentric directions is not quite a geodesic: 1e-3 of the way beside it at most.
      EXPECT_LT(std::abs(polygon.signed_distance_m(at(lat, lon))), 1e-3 * *way + 0.01);
    }
  }
}

TEST(GroundPolygon, WhatIsNoPolygonIsNamed) {
  using P = GroundPolygon;
  EXPECT_EQ(P::defect_of(corridor()), "");
  EXPECT_EQ(P::defect_of(around_the_pole()), "");
  EXPECT_EQ(P::defect_of({at(0, 0), at(0, 1)}), "2 different vertices, where a polygon has at least 3");
  EXPECT_EQ(P::defect_of({at(0, 0), at(0, 1), at(0, 0)}), "2 different vertices, where a polygon has at least 3");
  EXPECT_EQ(P::defect_of({at(0, 0), at(0, 1), at(0, 1), at(1, 0)}), "vertices 2 and 3 are alike");
  EXPECT_EQ(P::defect_of({at(0, 0), at(0, 1), at(0, 361), at(1, 0)}), "vertices 2 and 3 are alike");
  EXPECT_EQ(P::defect_of({at(0, 0), at(95, 1), at(1, 1)}), "vertex 2 is no latitude and longitude");
  EXPECT_EQ(P::defect_of({at(0, 0), at(0, std::nan("")), at(1, 1)}), "vertex 2 is no latitude and longitude");
  EXPECT_EQ(P::defect_of({at(0, 0), at(1, 1), at(0, 1), at(1, 0)}), "edges 1-2 and 3-4 cross or touch");
  EXPECT_EQ(P::defect_of({at(0, 0), at(0, 2), at(0, 1)}), "edges 1-2 and 3-1 cross or touch");
  EXPECT_EQ(P::defect_of({at(0, 0), at(0, 2), at(0, 1), at(1, 1)}), "edges 1-2 and 2-3 cross or touch");
  EXPECT_EQ(P::defect_of({at(0, 0), at(0, 0.1), at(0, 0.05), at(1, 1)}), "edges 1-2 and 2-3 cross or touch");
  EXPECT_EQ(P::defect_of({at(0, 0), at(0, 4), at(2, 2), at(0, 2), at(2, 0)}), "edges 1-2 and 3-4 cross or touch");
  EXPECT_EQ(P::defect_of({at(0, 0), at(0, 90), at(0, 180), at(10, -90)}).substr(0, 20), "it reaches farther t");
  Vertices many;
  for (int i = 0; i < 501; ++i) many.push_back(at(10 * std::sin(i * 2 * std::numbers::pi / 501), i * 0.1));
  EXPECT_EQ(P::defect_of(many), "501 vertices, at most 500");
  EXPECT_THROW(P({at(0, 0), at(1, 1), at(0, 1), at(1, 0)}), std::invalid_argument);
  // Edges that cross where their ends are far apart, on the other side of the date line.
  EXPECT_EQ(P::defect_of({at(0, 170), at(10, -170), at(0, -170), at(10, 170)}), "edges 1-2 and 3-4 cross or touch");
}

}  // namespace
}  // namespace downrange
