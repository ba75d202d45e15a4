#include "identification.hpp"

#include <algorithm>
#include <array>
#include <bit>

namespace downrange::integrity {
namespace {

/// Of the doubt that two explanations leave: chi2 of 12 is a likelihood ratio of 400.
constexpr double decisive = 0.4;
constexpr double clearly = 3;
constexpr std::size_t most_covers = 256;

bool covers(WitnessSet set, const Edge& edge) { return (set & (only(edge.first) | only(edge.second))) != 0; }

struct Covers {
  std::array<WitnessSet, most_covers> set{};
  std::size_t count = 0;

  void add(WitnessSet cover) {
    const auto* end = set.data() + count;
    if (count < most_covers && std::find(static_cast<const WitnessSet*>(set.data()), end, cover) == end)
      set[count++] = cover;
  }
};

/// All sets of at most `left` further witnesses that touch every failing edge: the first edge not touched needs one of
/// its ends.
void extend(std::span<const Edge> edges, WitnessSet innocent, WitnessSet so_far, int left, Covers& found) {
  for (const Edge& edge : edges) {
    if (!edge.fails || covers(so_far, edge)) continue;
    if (left == 0) return;
    for (const int end : {edge.first, edge.second}) {
      if ((innocent & only(end)) == 0) extend(edges, innocent, so_far | only(end), left - 1, found);
    }
    return;
  }
  found.add(so_far);
}

/// What the tests that stay when `set` is removed still say.
double doubt_without(std::span<const Edge> edges, WitnessSet set) {
  double sum = 0;
  for (const Edge& edge : edges) {
    if (!covers(set, edge)) sum += edge.doubt;
  }
  return sum;
}

/// Keeps those of the highest rank. There is one at least.
template <class Rank>
void keep_best(Covers& covers, const Rank& rank) {
  double best = rank(covers.set[0]);
  for (std::size_t i = 1; i < covers.count; ++i) best = std::max(best, rank(covers.set[i]));
  std::size_t kept = 0;
  for (std::size_t i = 0; i < covers.count; ++i) {
    if (rank(covers.set[i]) >= best) covers.set[kept++] = covers.set[i];
  }
  covers.count = kept;
}

/// A total over the witnesses of a set that are not in every cover.
template <class Value>
double total(WitnessSet set, WitnessSet common, std::span<const Character> characters, const Value& value) {
  double sum = 0;
  for (std::size_t w = 0; w < characters.size(); ++w) {
    if ((set & ~common & only(static_cast<int>(w))) != 0) sum += value(characters[w]);
  }
  return sum;
}

WitnessSet common_of(const Covers& covers) {
  WitnessSet common = ~WitnessSet{0};
  for (std::size_t i = 0; i < covers.count; ++i) common &= covers.set[i];
  return common;
}

}  // namespace

Accusation identify(std::span<const Edge> edges, std::span<const Character> characters, WitnessSet alone,
                    WitnessSet innocent, WitnessSet prefer) {
  Covers covers;
  for (int size = 0; size <= 3 && covers.count == 0; ++size) extend(edges, innocent, alone & ~innocent, size, covers);
  if (covers.count == 0) {
    Accusation lost{.guilty = alone & ~innocent, .tied = 0};
    for (const Edge& edge : edges) {
      if (edge.fails) lost.tied |= (only(edge.first) | only(edge.second)) & ~innocent & ~lost.guilty;
    }
    return lost;
  }
  keep_best(covers, [&](WitnessSet set) { return static_cast<double>(std::popcount(set & prefer)); });

  // The explanation that leaves clearly less doubt than any other.
  double least = doubt_without(edges, covers.set[0]);
  for (std::size_t i = 1; i < covers.count; ++i) least = std::min(least, doubt_without(edges, covers.set[i]));
  keep_best(covers, [&](WitnessSet set) { return doubt_without(edges, set) < least + decisive ? 1.0 : 0.0; });

  // Who broke with its own past.
  if (covers.count > 1) {
    const WitnessSet common = common_of(covers);
    const auto broke = [&](WitnessSet set) {
      return total(set, common, characters, [](const Character& c) { return c.own_break; });
    };
    double first = 0;
    double second = 0;
    for (std::size_t i = 0; i < covers.count; ++i) {
      const double value = broke(covers.set[i]);
      second = std::max(second, std::min(first, value));
      first = std::max(first, value);
    }
    if (first >= 1 && first >= clearly * second) keep_best(covers, broke);
  }
  // Physics; the nominal trajectory; the configured order of trust.
  if (covers.count > 1) {
    const WitnessSet common = common_of(covers);
    keep_best(covers, [&](WitnessSet set) {
      return total(set, common, characters, [](const Character& c) { return c.impossible ? 1.0 : 0.0; });
    });
    keep_best(covers, [&](WitnessSet set) {
      return total(set, common, characters, [](const Character& c) { return c.off_nominal >= 1 ? 1.0 : 0.0; });
    });
    keep_best(covers, [&](WitnessSet set) {
      return total(set, common, characters, [](const Character& c) { return static_cast<double>(c.distrust); });
    });
  }
  Accusation accusation;
  accusation.guilty = common_of(covers);
  for (std::size_t i = 0; i < covers.count; ++i) accusation.tied |= covers.set[i] & ~accusation.guilty;
  return accusation;
}

}  // namespace downrange::integrity
