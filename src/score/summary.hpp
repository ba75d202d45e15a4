#pragma once
/// What a flight was judged to be worth, as numbers, as text and as JSON.

#include <array>
#include <cstddef>
#include <cstdint>
#include <downrange/est/filter/consistency.hpp>
#include <downrange/stage/result.hpp>
#include <downrange/stage/source_table.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "score/phase.hpp"

namespace downrange::score {

/// Position errors of one run and method within one phase: |estimate - truth|, or |fix - track just before it|. All
/// zero when there was none.
struct PositionScore {
  std::size_t samples = 0;
  double rms_m = 0;
  double p95_m = 0;  ///< smallest error that 95 % of the samples do not exceed
  double worst_m = 0;
  double inside_95 = 0;  ///< share of errors inside the 95 % ellipsoid: the track's, or track's and fix's together
};

struct TrajectoryScore {
  std::string label;                  ///< "fused (song2015)", "goheung alone"
  std::vector<PositionScore> phases;  ///< one per phase of the summary
};

/// Rms of the 10 s means of measured - true.
struct SystematicError {
  double range_m = 0;
  double azimuth_rad = 0;  ///< times cos elevation: on the sky
  double elevation_rad = 0;
};

/// Systematic error of one radar or angles-only tracker within the phases.
struct SystematicScore {
  Name sensor;
  SourceKind kind = SourceKind::Radar;
  bool has_range = true;  ///< the sensor measures it; else its errors are 0, the angles' likewise
  bool has_angles = true;
  std::size_t plots = 0;       ///< that the errors are of: within a phase, neither rejected nor an outlier
  std::uint64_t rejected = 0;  ///< as the source's account has it, in the whole flight
  SystematicError before;      ///< as measured
  SystematicError after;       ///< corrected for the bias known when the plot arrived, and for refraction
};

/// Angle between the commanded and the true direction at the instant of application.
struct PointingScore {
  Name antenna;
  SlavingSource source = SlavingSource::Fused;
  std::size_t commands = 0;
  std::size_t held = 0;    ///< of these, held at the end of the travel, the target being outside: counted, not scored
  std::size_t scored = 0;  ///< of these, those that the angles are of: neither held nor without truth
  double rms_rad = 0;
  double p95_rad = 0;
  double worst_rad = 0;
  double inside_2_sigma = 0;  ///< share of azimuth and elevation errors within 2 sigma (right: 0.954)
  double mean_age_s = 0;
  double worst_age_s = 0;
};

/// Who says which messages are outliers.
enum class OutlierOrigin : std::uint8_t {
  None,     ///< nobody
  Truth,    ///< the truth (OutlierFinder)
  Planted,  ///< who planted them
};

/// What became of one source's messages in the whole flight, whatever their target, and how they fit the first method.
struct SourceScore {
  Name sensor;
  SourceKind kind = SourceKind::Radar;
  /// By Reason: ingest's, and of the newest health record the method's. [Accepted] stood after both.
  std::array<std::uint64_t, reason_count> count{};
  std::uint64_t excluded = 0;  ///< neither: accepted by ingest and not used, for INTEGRITY had excluded the source
  std::size_t outliers = 0;    ///< delivered
  std::size_t good = 0;        ///< plots that are no outliers, delivered
  /// Of these, by ingest or, when they arrived, by the method. None: not told, for the first method told no bias of the
  /// source.
  std::optional<std::size_t> outliers_rejected = 0;
  std::optional<std::size_t> good_rejected = 0;
  /// NIS inside their 95 % region: of as many disjoint windows of health records as the flight holds. Between two of
  /// them up to a second's messages are left out, and nothing is counted twice.
  std::uint64_t nis_count = 0;
  double nis_inside_95 = 0;                     ///< share of these
  double nis_independent = 0;                   ///< as many values does the flight's length make of them
  Band nis_band{.low = 0, .high = 1};           ///< where the true share may be, 95 % (honest_band)
  std::optional<double> least_nis_inside_95{};  ///< of a full window of the mismatch alarm; none: none was filled
  int mismatch_s = 0;                           ///< how long the alarm rang
  SigmaRatios sigma_ratio{};                    ///< as learnt in the end

  [[nodiscard]] std::uint64_t accepted() const { return count[static_cast<std::size_t>(Reason::Accepted)]; }
  /// The one meaning of "rejected": by ingest, by the method's gate, or as frozen. Not what was excluded.
  [[nodiscard]] std::uint64_t rejected() const;
};

/// One change of what INTEGRITY holds of the target's sources, or of whom the antennas follow.
struct IntegrityNote {
  double t_s = 0;    ///< since the phases' zero
  std::string text;  ///< "jeju disagrees with goheung by 5.0 km since T+241.0; excluded by integrity since T+243.2"
};

/// The least or the greatest of a flight, and when.
struct Extreme {
  double value = 0;
  double t_s = 0;  ///< since the phases' zero
};

/// Impact points of one chain in the whole flight.
struct ImpactScore {
  Name chain{};                   ///< empty: the selected one
  std::size_t points = 0;         ///< that came down
  std::size_t without_point = 0;  ///< records without one: no track, or an orbit
  std::size_t judged = 0;         ///< of these, those whose true state comes down; the next four are of them
  double rms_m = 0;               ///< from where the true state falls
  double p95_m = 0;
  double worst_m = 0;
  double inside_95 = 0;                   ///< share inside their 95 % ellipse
  std::optional<Extreme> longest_loss{};  ///< s without data
  std::size_t over_limit = 0;             ///< records with the data lost for longer than is allowed
  std::optional<double> first_over_limit_s{};
};

/// How near to a boundary it came, by the selected chain. None: there was no point.
struct BoundaryScore {
  Name boundary{};
  std::optional<Extreme> least_m{};          ///< of the impact point; negative: it was outside
  std::optional<Extreme> least_present_m{};  ///< of the place below the target
  std::optional<Extreme> most_outside{};     ///< probability
  std::optional<double> first_outside_s{};   ///< when the impact point was outside first
};

struct Summary {
  std::vector<Phase> phases;
  bool truth_known = false;
  std::vector<TrajectoryScore> trajectories;  ///< against the truth, as open_run says; none where it is not known
  std::vector<TrajectoryScore> against_gps;   ///< against the fixes instead, likewise
  std::vector<SystematicScore> systematic;    ///< of the first run: radars, trackers, in the range's order
  std::vector<PointingScore> pointing;        ///< of the first run, in the range's order, by source
  Name method;                                ///< whose the rest is: the range's first
  OutlierOrigin outliers = OutlierOrigin::None;
  /// Of the first run: radars, trackers, stations, in the range's order; then those that the range does not have.
  std::vector<SourceScore> sources;
  std::vector<SensorBias> biases;         ///< the last of the first run; radars, trackers, in the range's order
  std::vector<IntegrityNote> integrity;   ///< of the first run
  std::size_t bounded = 0;                ///< of its positions with truth, those sent with a bound
  std::size_t bound_holds = 0;            ///< of these, those that it covers
  std::vector<ImpactScore> impacts;       ///< of the first run, the selected chain first
  std::vector<BoundaryScore> boundaries;  ///< likewise, as configured
};

/// "radar", "angles", "gps".
[[nodiscard]] std::string_view name_of(SourceKind kind);
/// "fused", "single sensor" ...
[[nodiscard]] std::string_view name_of(SlavingSource source);
/// 1-sigma of a bias's i-th term.
[[nodiscard]] double sigma_of(const SensorBias& bias, int i);

/// Plain text tables of at most 100 columns for a range engineer. "-" where there is no number.
[[nodiscard]] std::string format_text(const Summary& summary);

/// The same numbers, SI and radians. null where there is no number.
[[nodiscard]] std::string format_json(const Summary& summary);

}  // namespace downrange::score
