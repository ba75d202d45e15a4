#include <algorithm>
#include <cmath>
#include <downrange/est/filter/consistency.hpp>
#include <downrange/est/filter/two_stage.hpp>
#include <limits>
#include "experiment/exx.hpp"
#include "experiment/pseudo_measurement.hpp"

#include "experiment/augmented_filter.hpp"
#include "experiment/kim2011_methods.hpp"

namespace downrange::experiment::kim2011 {
namespace {

constexpr double no_gate = std::numeric_limits<double>::infinity();

Mat<2, 4> position_rows() { return (Mat<2, 4>() << Mat<2, 2>::Identity(), Mat<2, 2>::Zero()).finished(); }

TrackError error_of(const Vec<4>& x, const Vec<4>& truth) {
  return {(x - truth).head<2>().squaredNorm(), (x - truth).tail<2>().squaredNorm()};
}

void note_biases(Trace::Scan& scan, const Vec<biases>& estimate, const Mat<biases, biases>& cov) {
  static const double quantile95 = chi2_quantile(0.95, biases);
  Vec<biases> error;
  error << estimate.head<terms>() - true_bias(), estimate.tail<terms>() - true_bias();
  scan.square = error.cwiseAbs2();
  scan.variance = cov.diagonal();
  scan.nees = error.dot(cov.llt().solve(error));
  scan.inside = scan.nees <= quantile95 ? 1 : 0;
}

Vec<terms> of_sensor(const Vec<biases>& b, int sensor) { return b.segment<terms>(terms * sensor); }

using Shared = SharedBias<biases>;
using Track = BiasFreeTrack<4, biases>;

/// A track from one plot and nothing else: any velocity of a few 100 m/s.
Track track_from_plot(int sensor, const Vec<2>& plot) {
  const BiasedPosition<2, terms> z = converted(sensor, plot);
  Track track;
  track.estimate.mean << z.z, 0, 0;
  track.estimate.cov.setZero();
  track.estimate.cov.topLeftCorner<2, 2>() = z.R;
  track.estimate.cov.bottomRightCorner<2, 2>().diagonal().setConstant(300.0 * 300.0);
  track.V.setZero();
  track.V.block<2, terms>(0, terms * sensor) = z.BC;
  // z = p + BC b + w: given b, p is z - BC b.
  track.V *= -1;
  return track;
}

std::array<Track, targets> bias_free_starts(const Draw& draw) {
  std::array<Track, targets> tracks;
  for (std::size_t t = 0; t < targets; ++t) {
    tracks[t].estimate = {(draw.start[0][t] + draw.start[1][t]) / 2, start_covariance() / 2};
    tracks[t].V.setZero();
  }
  return tracks;
}

/// Predicts all targets to the next scan.
void predict_all(std::array<Track, targets>& tracks) {
  const Mat<4, 4> Phi = transition(scan_s);
  const Mat<4, 4> Q = process_noise(scan_s);
  for (Track& track : tracks)
    predict(
        track, [&](auto& X) { X = (Phi * X).eval(); }, Q);
}

/// One plot by `ts`, linearised at the compensated estimate.
void update_ts(Shared& bias, Track& track, int sensor, const Vec<2>& plot) {
  const PlanarPlot p = predict_plot(sensor, compensated_mean(track, bias), of_sensor(bias.mean(), sensor));
  (void)update(bias, track, residual(plot, p.q), p.d_state, p.d_bias, terms * sensor, plot_noise(), no_gate);
}

Shared prior() { return {bias_prior().mean, bias_prior().cov}; }

void add(TrackError& sum, const TrackError& e) {
  sum.position += e.position;
  sum.velocity += e.velocity;
}

}  // namespace

Trace& Trace::operator+=(const Trace& other) {
  for (std::size_t k = 0; k < scan.size(); ++k) {
    Scan& s = scan[k];
    const Scan& o = other.scan[k];
    s.square += o.square;
    s.variance += o.variance;
    s.nees += o.nees;
    s.inside += o.inside;
    for (std::size_t i = 0; i < shown_tracks.size(); ++i) {
      add(s.biased[i], o.biased[i]);
      add(s.compensated[i], o.compensated[i]);
    }
  }
  return *this;
}

Trace run_pm(const Draw& draw, Start start, double noise_factor) {
  using Tracks = LocalTracks<4, terms, sensors>;
  const Mat<4, 4> Phi = transition(scan_s);
  const Mat<4, 4> Q = process_noise(scan_s);
  const Mat<2, 4> H = position_rows();
  std::vector<Tracks> tracks(targets);
  Gaussian<biases> beta = bias_prior();
  if (start == Start::BiasFree) {
    for (std::size_t t = 0; t < targets; ++t) {
      for (int s = 0; s < sensors; ++s)
        tracks[t].start(s, {{draw.start[static_cast<std::size_t>(s)][t], start_covariance()}, Mat<4, terms>::Zero()});
    }
  }

  Trace trace;
  for (int k = 1; k <= scans; ++k) {
    const int i = sensor_of(k);
    for (std::size_t t = 0; t < targets; ++t) {
      const BiasedPosition<2, terms> z = converted(i, draw.plots[k][t]);
      predict(tracks[t], Phi, Q);
      beta = estimate_bias(beta, pseudo_measurement(tracks[t], i, z.z, H, z.BC, z.R), noise_factor, no_gate).posterior;
      if (tracks[t].started[static_cast<std::size_t>(i)]) {
        (void)update(tracks[t], i, z.z, H, z.BC, z.R, no_gate);
      } else if (k > sensors) {
        const BiasedPosition<2, terms> before = converted(i, draw.plots[k - sensors][t]);
        tracks[t].start(i, two_point_start(before, z, sensors * scan_s, q_m2_s3));
      }
    }
    Trace::Scan& scan = trace.scan[k];
    note_biases(scan, beta.mean, beta.cov);
    for (std::size_t shown = 0; shown < shown_tracks.size(); ++shown) {
      const std::size_t t = shown_tracks[shown];
      if (!tracks[t].started[0]) continue;
      const BiasedTrack<4, terms>& track = tracks[t].track[0];
      const Gaussian<terms> beta_1{beta.mean.head<terms>(), beta.cov.topLeftCorner<terms, terms>()};
      scan.biased[shown] = error_of(track.estimate.mean, draw.truth[k][t]);
      scan.compensated[shown] = error_of(compensate(track, beta_1).mean, draw.truth[k][t]);
    }
  }
  return trace;
}

Trace run_exx(const Draw& draw) {
  constexpr int slot = 2 * sensors;
  const Mat<4, 4> Phi = transition(scan_s);
  const Mat<4, 4> Q = process_noise(scan_s);
  std::vector<ParitySlot<4, 2, terms, sensors, slot>> slots(targets);
  Gaussian<biases> beta = bias_prior();
  Trace trace;
  for (int k = 1; k <= scans; ++k) {
    const int i = sensor_of(k);
    for (std::size_t t = 0; t < targets; ++t) {
      const BiasedPosition<2, terms> z = converted(i, draw.plots[k][t]);
      slots[t].add(Phi, Q, i, z.z, position_rows(), z.BC, z.R);
      if (!slots[t].complete()) continue;
      const auto p = slots[t].parity();
      constexpr int rows = decltype(slots)::value_type::rows;
      beta = kalman_update<biases, rows>(beta, p.z - p.J * beta.mean, p.J, p.R, no_gate).posterior;
      slots[t].clear();
    }
    note_biases(trace.scan[k], beta.mean, beta.cov);
  }
  return trace;
}

Trace run_ts(const Draw& draw, Start start) {
  Shared bias = prior();
  std::array<Track, targets> tracks = bias_free_starts(draw);
  Trace trace;
  for (int k = 1; k <= scans; ++k) {
    const int i = sensor_of(k);
    predict_all(tracks);
    for (std::size_t t = 0; t < targets; ++t) {
      const Vec<2>& plot = draw.plots[k][t];
      if (k == 1 && start == Start::Data) {
        tracks[t] = track_from_plot(i, plot);
      } else {
        update_ts(bias, tracks[t], i, plot);
      }
    }
    Trace::Scan& scan = trace.scan[k];
    note_biases(scan, bias.mean(), bias.covariance());
    for (std::size_t shown = 0; shown < shown_tracks.size(); ++shown) {
      const std::size_t t = shown_tracks[shown];
      scan.compensated[shown] = error_of(compensated_mean(tracks[t], bias), draw.truth[k][t]);
    }
  }
  return trace;
}

Trace run_bound(const Draw& draw, Start start) {
  const Mat<4, 4> Phi = transition(scan_s);
  const Mat<4, 4> Q = process_noise(scan_s);
  // Targets that start from their first plot know nothing before it; large for a position, and harmless to rounding.
  const Mat<4, 4> P0 = start == Start::BiasFree ? Mat<4, 4>(start_covariance() / 2)
                                                : Mat<4, 4>(Vec<4>(1e12, 1e12, 9e4, 9e4).asDiagonal());
  AugmentedFilter<4> filter(std::vector<Gaussian<4>>(targets, {Vec<4>::Zero(), P0}), bias_prior().mean,
                            bias_prior().cov);
  Trace trace;
  for (int k = 1; k <= scans; ++k) {
    const int i = sensor_of(k);
    filter.predict(Phi, Q);
    for (int t = 0; t < targets; ++t) {
      const PlanarPlot p = predict_plot(i, draw.truth[k][t], true_bias());
      filter.update<2, terms>(t, Vec<2>::Zero(), p.d_state, p.d_bias, terms * i, plot_noise());
    }
    trace.scan[k].variance = filter.bias_covariance().diagonal();
    for (std::size_t shown = 0; shown < shown_tracks.size(); ++shown) {
      const Mat<4, 4> P = filter.covariance(static_cast<int>(shown_tracks[shown]));
      trace.scan[k].compensated[shown] = {P.topLeftCorner<2, 2>().trace(), P.bottomRightCorner<2, 2>().trace()};
    }
  }
  return trace;
}

double ts_against_augmented(const Draw& draw) {
  const Mat<4, 4> Phi = transition(scan_s);
  const Mat<4, 4> Q = process_noise(scan_s);
  Shared bias = prior();
  std::array<Track, targets> tracks = bias_free_starts(draw);
  std::vector<Gaussian<4>> starts;
  for (const Track& track : tracks) starts.push_back(track.estimate);
  AugmentedFilter<4> augmented(starts, bias_prior().mean, bias_prior().cov);

  double worst = 0;
  const auto compare = [&worst](const auto& x, const auto& P, const auto& y, const auto& P_y) {
    const auto sigma = P.diagonal().array().sqrt();
    const auto sigma_y = P_y.diagonal().array().sqrt();
    worst = std::max(worst, ((x - y).array().abs() / sigma).maxCoeff());
    worst = std::max(worst, ((sigma_y - sigma).abs() / sigma).maxCoeff());
  };
  for (int k = 1; k <= scans; ++k) {
    const int i = sensor_of(k);
    predict_all(tracks);
    augmented.predict(Phi, Q);
    for (int t = 0; t < targets; ++t) {
      const Vec<2>& plot = draw.plots[k][t];
      update_ts(bias, tracks[t], i, plot);
      const PlanarPlot p = predict_plot(i, augmented.target(t), of_sensor(augmented.bias(), i));
      augmented.update<2, terms>(t, residual(plot, p.q), p.d_state, p.d_bias, terms * i, plot_noise());
    }
    compare(augmented.bias(), augmented.bias_covariance(), bias.mean(), bias.covariance());
    for (int t = 0; t < targets; ++t) {
      const Gaussian<4> x = compensated(tracks[t], bias);
      compare(augmented.target(t), augmented.covariance(t), x.mean, x.cov);
    }
  }
  return worst;
}

}  // namespace downrange::experiment::kim2011
