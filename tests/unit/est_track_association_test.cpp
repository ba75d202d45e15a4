/// Association without identifiers: confirmed after m of n, kept and lost, crossing targets, two tracks for one target.
#include <gtest/gtest.h>

#include <downrange/est/track/track_association.hpp>
#include <random>

namespace downrange {
namespace {

using Track = NumberedTrack<2>;

Track at(std::uint64_t number, double position, double velocity, double variance = 1) {
  return {number, {Vec<2>(position, velocity), Vec<2>(variance, 0.01).asDiagonal()}};
}

TEST(TrackAssociation, ConfirmsByMOfNAndLosesByTheSame) {
  SequentialAssociation<2> association({.gate_probability = 0.999, .confirm = 3, .of = 5});
  const std::vector<Track> targets{at(7, 0, 1), at(8, 100, 1)};
  const std::vector<Track> near{at(1, 0.5, 1)};
  const std::vector<Track> far{at(1, 50, 1)};
  association.look(near, targets);
  association.look(far, targets);
  association.look(near, targets);
  EXPECT_FALSE(association.target_of(1));  // 2 of 3
  association.look(near, targets);
  EXPECT_EQ(association.target_of(1), 7u);  // 3 of 4
  association.look(far, targets);
  EXPECT_EQ(association.target_of(1), 7u);  // 3 of 5
  association.look({}, targets);            // the source says nothing of it
  EXPECT_FALSE(association.target_of(1));
  EXPECT_FALSE(association.target_of(2));
}

TEST(TrackAssociation, AConfirmedPairIsRememberedWhereTracksCross) {
  // Two targets cross; at the crossing positions and velocities alone would swap nothing, but noise might.
  std::mt19937_64 rng(3);
  std::normal_distribution<double> normal;
  SequentialAssociation<2> association({.gate_probability = 0.9999, .confirm = 3, .of = 5});
  for (int k = 0; k < 100; ++k) {
    const double x1 = -50 + k;
    const double x2 = 50 - k;
    const std::vector<Track> targets{at(1, x1, 0.05, 4), at(2, x2, -0.05, 4)};
    const std::vector<Track> tracks{at(20, x2 + 2 * normal(rng), -0.05 + 0.1 * normal(rng), 4),
                                    at(10, x1 + 2 * normal(rng), 0.05 + 0.1 * normal(rng), 4)};
    association.look(tracks, targets);
    if (k < 3) continue;
    EXPECT_EQ(association.target_of(10), 1u) << k;
    EXPECT_EQ(association.target_of(20), 2u) << k;
  }
}

TEST(TrackAssociation, ATargetGoesToOneTrackOfASource) {
  SequentialAssociation<2> association({});
  const std::vector<Track> targets{at(7, 0, 1), at(8, 3, 1)};
  const std::vector<Track> tracks{at(1, 1, 1), at(2, 1.2, 1), at(3, 1.1, 1)};
  for (int k = 0; k < 5; ++k) association.look(tracks, targets);
  EXPECT_EQ(association.target_of(1), 7u);
  EXPECT_EQ(association.target_of(2), 8u);  // globally: 1 + 3.24 rather than any pair with the track between
  EXPECT_FALSE(association.target_of(3));
}

TEST(TrackAssociation, AVagueTargetDoesNotDrawEveryTrack) {
  // d^2 alone prefers the target of which nothing is known.
  SequentialAssociation<2> association({});
  const std::vector<Track> targets{at(7, 0, 1, 1), at(8, 0, 1, 1e6)};
  const std::vector<Track> tracks{at(1, 1.5, 1)};
  for (int k = 0; k < 5; ++k) association.look(tracks, targets);
  EXPECT_EQ(association.target_of(1), 7u);
}

TEST(TrackAssociation, WhatIsNotANumberIsNobodys) {
  SequentialAssociation<2> association({});
  const std::vector<Track> targets{at(7, 0, 1)};
  const std::vector<Track> tracks{at(1, std::nan(""), 1)};
  for (int k = 0; k < 5; ++k) association.look(tracks, targets);
  EXPECT_FALSE(association.target_of(1));
}

}  // namespace
}  // namespace downrange
