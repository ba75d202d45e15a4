#pragma once
/// Which target a source's track belongs to, when the source gives no identifier (spatial paper, section 4).

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <downrange/est/filter/consistency.hpp>
#include <downrange/est/track/assignment.hpp>
#include <limits>
#include <optional>
#include <span>
#include <vector>

namespace downrange {

struct AssociationSettings {
  double gate_probability = 0.9999;  ///< of chi2(N)
  int confirm = 3;                   ///< an association is confirmed by so many hits ...
  int of = 5;                        ///< ... in the last so many looks (1 to 32), and lost with fewer
};

/// A track or target with its number.
template <int N>
struct NumberedTrack {
  std::uint64_t number = 0;
  Gaussian<N> state;
};

/// Sequential association of the tracks of *one* source with the targets. A confirmed pair is only checked, by its
/// gate, and takes no part in the assignment; the others are gated by Mahalanobis distance and assigned globally, one
/// to one, by d^2 + ln det(P_track + P_target); m hits of n looks confirm. The cross-covariance of track and target is
/// not used: it is positive, so the gate is on the wide side. States at one instant, in one frame.
template <int N>
class SequentialAssociation {
 public:
  explicit SequentialAssociation(const AssociationSettings& settings)
      : settings_(settings), gate_(chi2_quantile(settings.gate_probability, N)) {}

  /// One look. A track that is not in it has missed.
  void look(std::span<const NumberedTrack<N>> tracks, std::span<const NumberedTrack<N>> targets) {
    for (Candidate& c : candidates_) c.history <<= 1;
    check_confirmed(tracks, targets);
    assign_others(tracks, targets);
    for (Candidate& c : candidates_) {
      const int hits = hits_of(c);
      if (c.confirmed || hits >= settings_.confirm) c.confirmed = hits >= settings_.confirm;
    }
    std::erase_if(candidates_, [this](const Candidate& c) { return hits_of(c) == 0; });
  }

  /// The target of a source's track; none while it is not confirmed.
  [[nodiscard]] std::optional<std::uint64_t> target_of(std::uint64_t track) const {
    for (const Candidate& c : candidates_) {
      if (c.track == track && c.confirmed) return c.target;
    }
    return std::nullopt;
  }

 private:
  struct Candidate {
    std::uint64_t track = 0;
    std::uint64_t target = 0;
    std::uint32_t history = 0;  ///< bit 0: the latest look
    bool confirmed = false;
  };

  static const NumberedTrack<N>* find(std::span<const NumberedTrack<N>> all, std::uint64_t number) {
    const auto it = std::find_if(all.begin(), all.end(), [&](const auto& t) { return t.number == number; });
    return it == all.end() ? nullptr : &*it;
  }

  Candidate* candidate_of(std::uint64_t track) {
    const auto it =
        std::find_if(candidates_.begin(), candidates_.end(), [&](const auto& c) { return c.track == track; });
    return it == candidates_.end() ? nullptr : &*it;
  }

  int hits_of(const Candidate& c) const {
    const std::uint32_t looks = settings_.of >= 32 ? ~0u : (1u << settings_.of) - 1;
    return std::popcount(c.history & looks);
  }

  /// d^2 + ln det S inside the gate, else infinity.
  double cost(const Gaussian<N>& track, const Gaussian<N>& target) const {
    const Eigen::LLT<Mat<N, N>> llt(track.cov + target.cov);
    if (llt.info() != Eigen::Success) return std::numeric_limits<double>::infinity();
    const double d2 = llt.matrixL().solve(track.mean - target.mean).squaredNorm();
    if (!(d2 <= gate_)) return std::numeric_limits<double>::infinity();
    double log_det = 0;
    for (int i = 0; i < N; ++i) log_det += 2 * std::log(llt.matrixLLT()(i, i));
    return d2 + log_det;
  }

  void check_confirmed(std::span<const NumberedTrack<N>> tracks, std::span<const NumberedTrack<N>> targets) {
    for (Candidate& c : candidates_) {
      if (!c.confirmed) continue;
      const NumberedTrack<N>* track = find(tracks, c.track);
      const NumberedTrack<N>* target = find(targets, c.target);
      if (track != nullptr && target != nullptr && cost(track->state, target->state) < infinity) c.history |= 1;
    }
  }

  bool is_confirmed(std::uint64_t number, std::uint64_t Candidate::*which) const {
    return std::any_of(candidates_.begin(), candidates_.end(),
                       [&](const Candidate& c) { return c.confirmed && c.*which == number; });
  }

  void assign_others(std::span<const NumberedTrack<N>> tracks, std::span<const NumberedTrack<N>> targets) {
    costs_.assign(tracks.size() * targets.size(), infinity);
    double dearest = 0;
    for (std::size_t i = 0; i < tracks.size(); ++i) {
      if (is_confirmed(tracks[i].number, &Candidate::track)) continue;
      for (std::size_t j = 0; j < targets.size(); ++j) {
        if (is_confirmed(targets[j].number, &Candidate::target)) continue;
        double& c = costs_[i * targets.size() + j];
        c = cost(tracks[i].state, targets[j].state);
        if (c < infinity) dearest = std::max(dearest, c);
      }
    }
    // Whatever is inside its gate is better than no partner.
    const double miss = dearest + gate_;
    const auto partner =
        assignment_.solve(costs_, static_cast<int>(tracks.size()), static_cast<int>(targets.size()), miss);
    for (std::size_t i = 0; i < tracks.size(); ++i) {
      if (partner[i] == Assignment::none) continue;
      const std::uint64_t target = targets[static_cast<std::size_t>(partner[i])].number;
      Candidate* c = candidate_of(tracks[i].number);
      if (c == nullptr) c = &candidates_.emplace_back(Candidate{.track = tracks[i].number, .target = target});
      if (c->target != target) *c = {.track = c->track, .target = target};  // another target: its looks start anew
      c->history |= 1;
    }
  }

  static constexpr double infinity = std::numeric_limits<double>::infinity();

  AssociationSettings settings_;
  double gate_;
  Assignment assignment_;
  std::vector<Candidate> candidates_;
  std::vector<double> costs_;
};

}  // namespace downrange
