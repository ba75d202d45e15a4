#include <algorithm>
#include <array>
#include <downrange/est/model/motion.hpp>
#include <downrange/est/track/track_rules.hpp>

namespace downrange {
namespace {

const Mat<3, 6> H = (Mat<3, 6>() << Mat<3, 3>::Identity(), Mat<3, 3>::Zero()).finished();

}  // namespace

void RadarTracks::start(const Gaussian<6>& x) {
  std::ranges::fill(local_, x);
  fused_ = x;
}

void RadarTracks::predict(double dt, double q) {
  for (Gaussian<6>& x : local_) x = cv::predict(x, dt, q);
  fused_ = cv::predict(fused_, dt, q);
}

Update<6, 3> RadarTracks::update(int i, const Vec<3>& z, const Mat<3, 3>& R, double gate) {
  Gaussian<6>& x = local_[static_cast<std::size_t>(i)];
  auto u = kalman_update<6, 3>(x, z - H * x.mean, H, R, gate);
  x = u.posterior;
  return u;
}

void ConvexRule::fuse(std::uint64_t live) {
  std::array<Gaussian<6>, max_fused_tracks> taken;
  std::size_t n = 0;
  for (std::size_t i = 0; i < local_.size(); ++i)
    if ((live >> i & 1) != 0) taken[n++] = local_[i];
  keep(fuse_convex<6>(std::span<const Gaussian<6>>(taken.data(), n)));
}

Update<6, 3> InformationRule::update(int i, const Vec<3>& z, const Mat<3, 3>& R, double gate) {
  const Gaussian<6> predicted = local(i);
  auto u = RadarTracks::update(i, z, R, gate);
  if (u.verdict != Verdict::Accepted) return u;
  const TrackReport<6> report{.predicted = predicted, .updated = u.posterior};
  keep(fuse_information<6>(fused_, std::span(&report, 1)));
  return u;
}

template <class Fusion>
void CorrelatedRule<Fusion>::start(const Gaussian<6>& x) {
  RadarTracks::start(x);
  fusion_.start(x);
}

template <class Fusion>
void CorrelatedRule<Fusion>::predict(double dt, double q) {
  RadarTracks::predict(dt, q);
  fusion_.predict(cv::transition(dt), cv::process_noise(dt, q));
}

template <class Fusion>
Update<6, 3> CorrelatedRule<Fusion>::update(int i, const Vec<3>& z, const Mat<3, 3>& R, double gate) {
  auto u = RadarTracks::update(i, z, R, gate);
  if (u.verdict == Verdict::Accepted) fusion_.template updated<3>(i, u.K, H, R);
  return u;
}

template <class Fusion>
void CorrelatedRule<Fusion>::designate(int i) {
  RadarTracks::designate(i);
  fusion_.designated(i);
}

template <class Fusion>
void CorrelatedRule<Fusion>::fuse(std::uint64_t live) {
  std::array<Vec<6>, max_fused_tracks> means;
  for (std::size_t i = 0; i < local_.size(); ++i) means[i] = local_[i].mean;
  keep(fusion_.fuse(std::span<const Vec<6>>(means.data(), local_.size()), live));
}

template class CorrelatedRule<CampoFusion<6>>;
template class CorrelatedRule<MapFusion<6, max_fused_tracks>>;

void FederatedRule::start(const Gaussian<6>& x) {
  filter_ = FederatedFilter<6, max_fused_tracks>(x, tracks_);
  fused_ = x;
}

void FederatedRule::predict(double dt, double q) {
  filter_.predict(cv::transition(dt), cv::process_noise(dt, q));
  fused_ = cv::predict(fused_, dt, q);
}

Update<6, 3> FederatedRule::update(int i, const Vec<3>& z, const Mat<3, 3>& R, double gate) {
  return filter_.update<3>(i, z - H * filter_.local(i).mean, H, R, gate);
}

}  // namespace downrange
