/// What people read of INTEGRITY.
#include <gtest/gtest.h>

#include "stage/integrity_text.hpp"

namespace downrange {
namespace {

constexpr Time liftoff{1'700'000'000'000'000'000};

Integrity record() {
  Integrity r;
  r.target = "kslv";
  r.liftoff = liftoff;
  r.liftoff_valid = true;
  r.sources = {{.sensor = "goheung"}, {.sensor = "jeju"}, {.sensor = "jeju-tgs"}};
  return r;
}

TEST(IntegrityText, WhoDisagreesWithWhomByHowMuchSinceWhen) {
  Integrity r = record();
  r.sources[2] = {.sensor = "jeju-tgs",
                  .verdict = IntegrityVerdict::Excluded,
                  .why = Finding::FinePosition,
                  .since = liftoff + seconds(243.2),
                  .onset = liftoff + seconds(241),
                  .test_value = 40,
                  .against = 0b011,
                  .apart_m = 5000,
                  .agree_m = 12,
                  .by = "integrity"};
  EXPECT_EQ(sentence(r, 2),
            "jeju-tgs disagrees with goheung and jeju by 5.0 km since T+241.0; these agree within 12 m; excluded by "
            "integrity since T+243.2 (fine position)");
  r.liftoff_valid = false;
  r.sources[2].against = 0b001;
  EXPECT_EQ(sentence(r, 2),
            "jeju-tgs disagrees with goheung by 5.0 km since 22:17:21; excluded by integrity since 22:17:23 (fine "
            "position)");
}

TEST(IntegrityText, EveryVerdictHasItsWord) {
  Integrity r = record();
  EXPECT_EQ(sentence(r, 0), "goheung agrees");
  r.sources[0].verdict = IntegrityVerdict::Suspect;
  r.sources[0].why = Finding::ImplausibleBias;
  EXPECT_EQ(sentence(r, 0), "goheung suspect, used (implausible bias)");
  r.sources[0].verdict = IntegrityVerdict::Ambiguous;
  r.sources[0].against = 0b110;
  r.sources[0].apart_m = 8.25;
  EXPECT_EQ(sentence(r, 0),
            "goheung disagrees with jeju and jeju-tgs by 8.3 m; which of them is right cannot be told (implausible "
            "bias)");
}

TEST(IntegrityText, AStationThatRelaysTwoReceiversDisagreesWithItself) {
  Integrity r = record();
  r.sources[2].verdict = IntegrityVerdict::Ambiguous;
  r.sources[2].why = Finding::FinePosition;
  r.sources[2].against = 0b100;
  r.sources[2].apart_m = 50;
  EXPECT_EQ(sentence(r, 2),
            "jeju-tgs relays two receivers that differ by 50 m; which of them is right cannot be told (fine position)");
}

TEST(IntegrityText, EveryFindingSaysWhatSpeaksAgainstTheSource) {
  Integrity r = record();
  const auto said = [&](Finding why, double apart, std::uint64_t against) {
    r.sources[2].verdict = IntegrityVerdict::Excluded;
    r.sources[2].why = why;
    r.sources[2].apart_m = apart;
    r.sources[2].against = against;
    r.sources[2].onset = liftoff + seconds(5);
    return sentence(r, 2);
  };
  EXPECT_EQ(said(Finding::OffPad, 28, 0), "jeju-tgs is 28 m off the pad since T+5.0; excluded (off the pad)");
  EXPECT_EQ(said(Finding::CoarseVelocity, 41.24, 0),
            "jeju-tgs does not move as its own velocity says, by 41.2 m/s since T+5.0; excluded (coarse velocity)");
  EXPECT_EQ(said(Finding::Clock, 0.964, 0b011),
            "jeju-tgs disagrees with goheung and jeju as by a clock that is 0.96 s off since T+5.0; excluded (clock)");
  EXPECT_EQ(said(Finding::Impossible, 0, 0),
            "jeju-tgs repeats one position in flight, to the bit, since T+5.0; excluded (impossible)");
  EXPECT_EQ(said(Finding::Impossible, 200, 0),
            "jeju-tgs leapt, and is 200 m off its own path since T+5.0; excluded (impossible)");
  EXPECT_EQ(said(Finding::DifferingCopy, 20, 0b001),
            "jeju-tgs relays another fix than goheung, 20 m off, since T+5.0; excluded (differing copy)");
  EXPECT_EQ(said(Finding::CommonBias, 480, 0),
            "jeju-tgs disagrees with all radars in the same way by 480 m since T+5.0; excluded (common bias)");
  EXPECT_EQ(said(Finding::ImplausibleBias, 900, 0),
            "jeju-tgs would be biased beyond what is configured by 900 m since T+5.0; excluded (implausible bias)");
}

TEST(IntegrityText, WhatIsFollowed) {
  Integrity r = record();
  EXPECT_EQ(selection(r), "kslv follows all sources, UNBOUNDED");
  r.chain = "without-jeju";
  r.held_by = "kim";
  r.bound_valid = true;
  r.bound_m = 75;
  EXPECT_EQ(selection(r), "kslv follows chain without-jeju, held there by kim, bound 75 m");
}

}  // namespace
}  // namespace downrange
