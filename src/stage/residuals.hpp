#pragma once
/// How far the sources are from the track that slaving follows, in metres and radians.

#include <downrange/est/method/method.hpp>
#include <downrange/stage/event.hpp>
#include <downrange/stage/source_table.hpp>
#include <vector>

namespace downrange {

/// Root mean squares per axis over about `memory`, each beside what the track's covariance, the bias's and the noise
/// as learnt let expect (their correlation neglected, which makes it rather too large). 0: nothing of that kind was
/// seen.
struct ResidualSize {
  double m = 0;  ///< a radar's range, a fix's position
  double expected_m = 0;
  double rad = 0;  ///< a radar's or tracker's angles, on the sky
  double expected_rad = 0;
};

/// Compares each observation with the track as it was before, bias and refraction included: the same for every method,
/// whatever its own innovations are made of. A sample per source and `spacing` is enough for people, and cheap.
class Residuals {
 public:
  static constexpr Duration memory = milliseconds(10'000);
  static constexpr Duration spacing = milliseconds(200);

  /// `radars`: radars and trackers behind them, as methods are told of them.
  Residuals(std::size_t sources, std::vector<RadarModel> radars);

  /// An accepted observation, not older than any of its target before it; `method` has not seen it yet.
  void note(SourceId source, int target, const Observation& o, const Method& method);

  [[nodiscard]] ResidualSize of(SourceId source) const;

 private:
  /// One observation against the track, squared.
  struct Squares {
    double m2 = 0;
    double expected_m2 = 0;
    double rad2 = 0;
    double expected_rad2 = 0;
  };
  struct Account {
    Time newest;
    int samples = 0;
    Squares mean;
  };
  [[nodiscard]] Squares squares(const Fix& fix, const TrackEstimate& track) const;
  [[nodiscard]] Squares squares(const RadarModel& radar, const Plot& plot, const TrackEstimate& track,
                                const BiasEstimate& bias, const NoiseScale& noise) const;

  std::vector<RadarModel> radars_;
  std::vector<Account> accounts_;  ///< by SourceId
};

}  // namespace downrange
