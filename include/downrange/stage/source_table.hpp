#pragma once
/// Every configured source, whatever its kind, under one dense number. Queue, ingest, monitor, methods, health and
/// report count with it; nothing else loops over the kinds.

#include <cstdint>
#include <downrange/geo/name.hpp>
#include <downrange/geo/site.hpp>
#include <downrange/geo/time.hpp>
#include <downrange/stage/event.hpp>
#include <downrange/stage/range_config.hpp>
#include <downrange/stage/result.hpp>
#include <string>
#include <vector>

namespace downrange {

/// Index in the table: radars first, then angles-only trackers, then telemetry stations, each as configured.
using SourceId = int;
inline constexpr SourceId no_source = -1;

enum class SourceKind : std::uint8_t { Radar, AngleSensor, Telemetry };

/// "radar", "angle_sensor", "telemetry": the name of its table in the configuration.
[[nodiscard]] std::string_view to_string(SourceKind kind);

/// The kind of source that such a measurement comes from.
[[nodiscard]] SourceKind kind_of(const Measured& measured);

/// "range 1.02, azimuth 2.95": what of its noise is learnt, as 1-sigma over the configured (SourceHealth::sigma_ratio);
/// empty: nothing.
[[nodiscard]] std::string learnt_noise(SourceKind kind, const SigmaRatios& ratios);

struct Source {
  Name name;
  SourceKind kind = SourceKind::Radar;
  Site site;
  Duration silent_after;    ///< nothing heard for longer: the source is silent
  double rate_hz = 0;       ///< nominal; 0: it relays what the vehicle sends and has none of its own
  PolarSigma sigma{};       ///< of the instrument, 1-sigma; 0: it does not measure this
  double refractivity = 0;  ///< of the air that its plots are bent by, N-units at the site; 0: none
};

/// A plot of it tells a position by itself.
[[nodiscard]] inline bool measures_position(const Source& source) { return measures_position(source.sigma); }

class SourceTable {
 public:
  explicit SourceTable(const RangeConfig& config);

  [[nodiscard]] std::size_t size() const { return sources_.size(); }
  [[nodiscard]] auto begin() const { return sources_.begin(); }
  [[nodiscard]] auto end() const { return sources_.end(); }
  [[nodiscard]] const Source& operator[](SourceId id) const { return sources_[static_cast<std::size_t>(id)]; }

  /// `no_source` where none of that kind has this name: a station may call itself as a radar does.
  [[nodiscard]] SourceId find(SourceKind kind, const Name& name) const;
  /// Of any kind: the configuration gives each name once.
  [[nodiscard]] SourceId find(const Name& name) const;

 private:
  std::vector<Source> sources_;
};

}  // namespace downrange
