#include "identification.hpp"

#include <algorithm>
#include <array>
#include <bit>

namespace downrange::integrity {
namespace {

/// What it costs to accuse one more, one who was named before, and to leave a doubt as large as a threshold.
constexpr double cost_of_new = 1;
constexpr double cost_of_named = 0.1;
constexpr double cost_of_doubt = 0.5;
/// Of cost: explanations nearer to each other than this are tied. Of doubt 0.4, a chi2 of 12: a likelihood ratio of
/// 400.
constexpr double decisive = 0.2;
/// A break with the own past counts beside another one from a third of it on.
constexpr double comparable = 1.0 / 3;
/// A break that no vote excuses: ten times the distance at which the test fails, squared.
constexpr double overwhelming = 100;
constexpr std::size_t most_covers = 256;
constexpr int most_accused = 3;

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

/// All sets of at most `left` further witnesses, those named before not counted, that touch every failing edge: the
/// first edge not touched needs one of its ends.
void extend(std::span<const Edge> edges, WitnessSet innocent, WitnessSet named, WitnessSet so_far, int left,
            Covers& found) {
  for (const Edge& edge : edges) {
    if (!edge.fails || covers(so_far, edge)) continue;
    for (const int end : {edge.first, edge.second}) {
      const int needs = (named & only(end)) != 0 ? 0 : 1;
      if ((innocent & only(end)) == 0 && needs <= left)
        extend(edges, innocent, named, so_far | only(end), left - needs, found);
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

/// Keeps the explanations whose witnesses broke with their own past. Of those that all explanations share nothing is
/// asked; where one who broke by far is settled, smaller breaks decide what is left.
void keep_those_who_broke(Covers& covers, std::span<const Character> characters) {
  for (std::size_t before = 0; covers.count > 1 && covers.count != before;) {
    before = covers.count;
    const WitnessSet common = common_of(covers);
    double most = 0;
    for (std::size_t i = 0; i < covers.count; ++i) {
      for (std::size_t w = 0; w < characters.size(); ++w) {
        if ((covers.set[i] & ~common & only(static_cast<int>(w))) != 0) most = std::max(most, characters[w].own_break);
      }
    }
    if (most < 1) return;
    const double least = std::max(1.0, comparable * most);
    keep_best(covers, [&](WitnessSet set) {
      return total(set, common, characters, [&](const Character& c) { return c.own_break >= least ? 1.0 : 0.0; });
    });
  }
}

/// Who broke overwhelmingly with its own past when it began to disagree with one who did not break at all. However many
/// do so at once: two radars that fold alike are no majority.
WitnessSet overwhelmed(std::span<const Edge> edges, std::span<const Character> characters) {
  WitnessSet set = 0;
  const auto consider = [&](int broke, int steady) {
    if (characters[static_cast<std::size_t>(broke)].own_break >= overwhelming &&
        characters[static_cast<std::size_t>(steady)].own_break < 1)
      set |= only(broke);
  };
  for (const Edge& edge : edges) {
    if (!edge.fails) continue;
    consider(edge.first, edge.second);
    consider(edge.second, edge.first);
  }
  return set;
}

}  // namespace

Accusation identify(std::span<const Edge> edges, std::span<const Character> characters, WitnessSet alone,
                    WitnessSet innocent, WitnessSet named) {
  const WitnessSet certain = (alone | overwhelmed(edges, characters)) & ~innocent;
  Covers covers;
  for (int size = 0; size <= most_accused && covers.count == 0; ++size)
    extend(edges, innocent, named, certain, size, covers);
  if (covers.count == 0) {
    Accusation lost{.guilty = certain, .tied = 0};
    for (const Edge& edge : edges) {
      if (edge.fails) lost.tied |= (only(edge.first) | only(edge.second)) & ~innocent & ~lost.guilty;
    }
    return lost;
  }
  const auto cost = [&](WitnessSet set) {
    return cost_of_new * std::popcount(set & ~named) + cost_of_named * std::popcount(set & named) +
           cost_of_doubt *
               (doubt_without(edges, set) + total(set, 0, characters, [](const Character& c) { return c.acquittal; }));
  };
  double least = cost(covers.set[0]);
  for (std::size_t i = 1; i < covers.count; ++i) least = std::min(least, cost(covers.set[i]));
  keep_best(covers, [&](WitnessSet set) { return cost(set) < least + decisive ? 1.0 : 0.0; });

  keep_those_who_broke(covers, characters);
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
