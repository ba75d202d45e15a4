#pragma once
/// Time tags without GPS, for joint and schmidt. Stamps that are late alike show the target elsewhere along its path,
/// and nothing else: no plot can tell the two apart. A filter linearised about its own estimate learns something of it
/// all the same, from the noise of the velocity that it multiplies a tag with; so what all tags have in common is
/// considered (Schmidt): it keeps its variance, and what it has in common with the motion.
///
/// While the velocity is not known a tag has no direction. Until it is, the motion alone is corrected and the tags are
/// left out; then they are put in, with what the motion owes to them.

#include <algorithm>
#include <cstdint>
#include <downrange/est/filter/hypothesis.hpp>

namespace downrange {

/// Bit i: radar i has told something of the target, or is `radar`.
template <class Target>
[[nodiscard]] std::uint64_t radars_heard(const Target& t, std::size_t radar) {
  std::uint64_t heard = std::uint64_t{1} << radar;
  for (std::size_t i = 0; i < t.radars.size(); ++i) heard |= std::uint64_t{t.radars[i].samples > 0} << i;
  return heard;
}

/// The part of `W` (P H' L^-T) that may correct nothing: all biases until the filter `learns_biases`, else
/// the common part of the time tags of the radars `heard`, each weighted by its prior.
template <int M>
[[nodiscard]] Columns<M> considered_without_gps(const BiasLayout& layout, bool learns_biases, std::uint64_t heard,
                                                const Columns<M>& W) {
  Columns<M> part = Columns<M>::Zero(W.rows(), M);
  if (!learns_biases) {
    part.bottomRows(layout.size) = W.bottomRows(layout.size);
    return part;
  }
  const auto is_heard = [heard](const BiasLayout::TimeTag& tag) { return (heard >> tag.radar & 1) != 0; };
  double information = 0;
  for (const BiasLayout::TimeTag& tag : layout.time_tags) information += is_heard(tag) ? 1 / tag.variance : 0;
  Eigen::Matrix<double, 1, M> common = Eigen::Matrix<double, 1, M>::Zero();
  for (const BiasLayout::TimeTag& tag : layout.time_tags) {
    if (is_heard(tag)) common += 1 / tag.variance / information * W.row(tag.at);
  }
  for (const BiasLayout::TimeTag& tag : layout.time_tags) {
    if (is_heard(tag)) part.row(tag.at) = common;
  }
  return part;
}

/// Well enough for a tag to put the target where it belongs, to a few metres?
[[nodiscard]] inline bool knows_velocity(const Bank& bank, int motion_at, const BiasLayout& layout) {
  constexpr double displaced_m = 10;
  const Hypothesis& h = bank.mode[static_cast<std::size_t>(likeliest(bank))];
  const double variance = h.P.diagonal().segment<3>(motion_at + 3).sum();
  return std::ranges::all_of(layout.time_tags, [&](const BiasLayout::TimeTag& tag) {
    return variance * tag.variance <= displaced_m * displaced_m;
  });
}

/// As if the tags were known: no variance, nothing in common with them.
inline void forget_time_tags(Hypothesis& h, const BiasLayout& layout) {
  for (const BiasLayout::TimeTag& tag : layout.time_tags) {
    h.P.row(tag.at).setZero();
    h.P.col(tag.at).setZero();
  }
}

/// The motion starts by a plot, with a velocity that is not known. Before it is tied to the bias of the plot's radar.
template <class Target>
void leave_time_tags_out(Target& t, const BiasLayout& layout) {
  if (layout.time_tags.empty()) return;
  t.learns_biases = false;
  for (auto& radar : t.radars) radar.blind = 0;
  for (int i = 0; i < t.bank.count; ++i) forget_time_tags(t.bank.mode[static_cast<std::size_t>(i)], layout);
}

/// Until the velocity is known one radar alone tells the motion, as long as it is heard: of two whose stamps differ
/// nothing could explain how far apart they see the target.
template <class Target>
[[nodiscard]] bool waits_for_velocity(const Target& t, const Measurement& plot) {
  if (t.learns_biases || t.radars[static_cast<std::size_t>(plot.source)].blind > 0) return false;
  return std::ranges::any_of(
      t.radars, [&](const auto& radar) { return radar.blind > 0 && plot.epoch - radar.epoch <= milliseconds(1000); });
}

/// After a plot of `radar` was used, its first included: once the velocity is known the tags get their priors. The
/// motion at `motion_at` was told by so many plots of each radar until now: it is off by the mean of their tags, times
/// velocity.
template <class Target>
void put_time_tags_in(Target& t, int motion_at, const BiasLayout& layout, std::size_t radar) {
  if (t.learns_biases) return;
  ++t.radars[radar].blind;
  if (!knows_velocity(t.bank, motion_at, layout)) return;
  t.learns_biases = true;
  int plots = 0;
  for (const auto& other : t.radars) plots += other.blind;
  for (int i = 0; i < t.bank.count; ++i) {
    Hypothesis& h = t.bank.mode[static_cast<std::size_t>(i)];
    const Vec<3> v = h.x.segment<3>(motion_at + 3);
    forget_time_tags(h, layout);  // a bias that was opened in the meantime has its tag's prior already
    for (const BiasLayout::TimeTag& tag : layout.time_tags) {
      const Vec<3> off = static_cast<double>(t.radars[tag.radar].blind) / plots * v;
      h.P(tag.at, tag.at) = tag.variance;
      h.P.block<3, 3>(motion_at, motion_at) += tag.variance * off * off.transpose();
      h.P.block<3, 1>(motion_at, tag.at) = tag.variance * off;
      h.P.block<1, 3>(tag.at, motion_at) = h.P.block<3, 1>(motion_at, tag.at).transpose();
    }
  }
}

}  // namespace downrange
