#pragma once
/// The rules of track_fusion.hpp over one nearly-constant-velocity track per radar, ECEF, as many radars as there are.
///
/// A rule is a value: it holds the radars' tracks and the fused one, all at one instant. Assigning one to another of as
/// many tracks allocates nothing, nor does anything but construction. What all of them offer:
///
/// - `start(x)`: every track and the fused one are `x`: the error is common to all;
/// - `predict(dt, q)`: to the next instant, white acceleration q (m^2/s^3), the same motion in all of them;
/// - `update(i, z, R, gate)`: track i by a position its radar measured; nothing changes unless accepted;
/// - `designate(i)`: track i starts anew from the fused one, as a radar does that is pointed at the target;
/// - `fuse(live)`: the tracks whose bit is set in `live`, at least one, into `fused()`, which stays as it was where
/// they
///   cannot be fused (Singular).

#include <downrange/est/track/track_fusion.hpp>
#include <vector>

namespace downrange {

/// Most tracks of one target: what a covariance of all of them may take of the stack.
inline constexpr int max_fused_tracks = 16;

/// What the rules have in common: one track per radar, each knowing its own radar's plots only.
class RadarTracks {
 public:
  /// 1 to max_fused_tracks.
  explicit RadarTracks(int tracks) : local_(static_cast<std::size_t>(tracks)) {}

  void start(const Gaussian<6>& x);
  void predict(double dt, double q);
  Update<6, 3> update(int i, const Vec<3>& z, const Mat<3, 3>& R, double gate);
  void designate(int i) { local_[static_cast<std::size_t>(i)] = fused_; }

  [[nodiscard]] const Gaussian<6>& local(int i) const { return local_[static_cast<std::size_t>(i)]; }
  [[nodiscard]] const Gaussian<6>& fused() const { return fused_; }

 protected:
  void keep(const FusedTrack<6>& fused) {
    if (fused.verdict == Verdict::Accepted) fused_ = fused.state;
  }

  std::vector<Gaussian<6>> local_;
  Gaussian<6> fused_;
};

/// Convex combination: the tracks as if they were independent. Over-confident.
class ConvexRule : public RadarTracks {
 public:
  using RadarTracks::RadarTracks;
  void fuse(std::uint64_t live);
};

/// Information with memory: what a track learns from a plot is added to the fused track at once.
class InformationRule : public RadarTracks {
 public:
  using RadarTracks::RadarTracks;
  Update<6, 3> update(int i, const Vec<3>& z, const Mat<3, 3>& R, double gate);
  void fuse(std::uint64_t) {}  ///< is done by every update
};

/// The rules that know the joint covariance of all tracks: CampoFusion and MapFusion.
template <class Fusion>
class CorrelatedRule : public RadarTracks {
 public:
  explicit CorrelatedRule(int tracks) : RadarTracks(tracks), fusion_(Gaussian<6>{}, tracks) {}

  void start(const Gaussian<6>& x);
  void predict(double dt, double q);
  Update<6, 3> update(int i, const Vec<3>& z, const Mat<3, 3>& R, double gate);
  void designate(int i);
  void fuse(std::uint64_t live);

 private:
  Fusion fusion_;
};

using CampoRule = CorrelatedRule<CampoFusion<6>>;
using MapRule = CorrelatedRule<MapFusion<6, max_fused_tracks>>;
extern template class CorrelatedRule<CampoFusion<6>>;
extern template class CorrelatedRule<MapFusion<6, max_fused_tracks>>;

/// Federated filter with equal shares. The local tracks are the filter's, each with its share of the fused one since
/// the last `end_batch`: they need no designation, and all of them are fused.
class FederatedRule {
 public:
  explicit FederatedRule(int tracks) : tracks_(tracks), filter_(Gaussian<6>{}, tracks) {}

  void start(const Gaussian<6>& x);
  void predict(double dt, double q);
  Update<6, 3> update(int i, const Vec<3>& z, const Mat<3, 3>& R, double gate);
  void designate(int) {}
  void fuse(std::uint64_t) { fused_ = filter_.fused_now().state; }
  /// The instant of fusion-reset: gives each local track its share of what all of them know.
  void end_batch() { (void)filter_.fuse(); }

  [[nodiscard]] const Gaussian<6>& fused() const { return fused_; }

 private:
  int tracks_;
  FederatedFilter<6, max_fused_tracks> filter_;
  Gaussian<6> fused_;
};

}  // namespace downrange
