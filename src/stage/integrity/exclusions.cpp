#include "stage/integrity/exclusions.hpp"

#include <algorithm>
#include <bit>
#include <limits>

namespace downrange {
namespace {

constexpr Time end_of_time{std::numeric_limits<std::int64_t>::max()};

}  // namespace

void Exclusions::open(int target, SourceId source, Time from) {
  intervals_.push_back({.target = target, .source = source, .from = from, .until = end_of_time});
}

void Exclusions::close(int target, SourceId source, Time until) {
  for (Interval& i : intervals_) {
    if (i.target == target && i.source == source) i.until = std::min(i.until, until);
  }
}

bool Exclusions::cover(int target, SourceId source, Time epoch) const {
  return std::ranges::any_of(intervals_, [&](const Interval& i) {
    return i.target == target && i.source == source && i.from <= epoch && epoch < i.until;
  });
}

bool Exclusions::leave(const LoggedMeasurement& measurement) const {
  const Measurement& m = measurement.m;
  for (SourceSet left = measurement.copies_before; left != 0; left &= left - 1) {
    if (!cover(m.target, std::countr_zero(left), m.epoch)) return false;
  }
  return !cover(m.target, m.source, m.epoch);
}

void Exclusions::forget_before(Time time) {
  std::erase_if(intervals_, [&](const Interval& i) { return i.until <= time; });
}

}  // namespace downrange
