#include <algorithm>
#include <archive/import/plausibility.hpp>
#include <archive/import/sentinels.hpp>
#include <archive/import/time_hints.hpp>
#include <archive/import/unit_hints.hpp>
#include <cmath>
#include <downrange/geo/site.hpp>
#include <numbers>

namespace downrange::archive {
namespace {

constexpr double deg = std::numbers::pi / 180;
constexpr double hour_s = 3600;
constexpr double day_s = 86'400;

/// No file of a flight is farther from its lift-off.
constexpr double far_from_liftoff_s = 30 * day_s;
/// Twice what leaves the Earth.
constexpr double impossible_speed_m_s = 22'000;
/// Noise over a shorter time looks like motion.
constexpr double speed_baseline_s = 1;
constexpr double earth_radius_least_m = 6'300'000;
constexpr double farthest_radius_m = 1e9;
/// Of a flight, a range or a height is larger; noise is slower.
constexpr double small_m = 1000;
constexpr double moving_m_s = 50;

struct Span {
  double least = 0;
  double most = 0;
};

template <class Value>
Span span_of(const std::vector<PlausibleRow>& rows, Value value) {
  Span span{value(rows.front()), value(rows.front())};
  for (const PlausibleRow& row : rows) {
    span.least = std::min(span.least, value(row));
    span.most = std::max(span.most, value(row));
  }
  return span;
}

double median(std::vector<double> values) {
  if (values.empty()) return 0;
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

/// distance / time between rows at least a second apart; the whole file where it is shorter.
template <class Distance>
std::vector<double> speeds_of(const std::vector<PlausibleRow>& rows, Distance distance) {
  std::vector<double> speeds;
  std::size_t from = 0;
  for (std::size_t i = 1; i < rows.size(); ++i) {
    const double time_s = std::abs((rows[i].epoch - rows[from].epoch).seconds());
    if (time_s < speed_baseline_s && (from > 0 || i + 1 < rows.size())) continue;
    const bool backwards = rows[i].epoch < rows[from].epoch;
    if (time_s > 0) speeds.push_back(distance(rows[from], rows[i]) / (backwards ? -time_s : time_s));
    from = i;
  }
  return speeds;
}

template <class Distance>
double median_speed(const std::vector<PlausibleRow>& rows, Distance distance) {
  std::vector<double> speeds = speeds_of(rows, distance);
  for (double& speed : speeds) speed = std::abs(speed);
  return median(std::move(speeds));
}

double travelled(const PlausibleRow& a, const PlausibleRow& b) { return (b.position.m - a.position.m).norm(); }

double height_of(const PlausibleRow& row) { return geodetic_from_ecef(row.position).height_m; }

std::string show_span(const Span& span, double unit, int decimals) {
  return show_fixed(span.least / unit, decimals) + " to " + show_fixed(span.most / unit, decimals);
}

std::string show_time(double seconds) {
  const std::string sign = seconds < 0 ? "T-" : "T+";
  if (std::abs(seconds) < 2 * hour_s) return sign + show_fixed(std::abs(seconds), 1) + " s";
  return sign + show_fixed(std::abs(seconds) / hour_s, 2) + " h";
}

/// "receding 300 m/s": which way most of the rates go.
std::string show_range_rate(const std::vector<double>& rates_m_s, double speed_m_s) {
  const auto receding = std::ranges::count_if(rates_m_s, [](double rate) { return rate > 0; });
  const auto closing = std::ranges::count_if(rates_m_s, [](double rate) { return rate < 0; });
  const char* way = receding > 3 * closing ? "receding" : closing > 3 * receding ? "closing" : "closing and receding";
  return (receding + closing == 0 ? "range changes by" : way) + (' ' + show_fixed(speed_m_s, 0)) + " m/s";
}

class Judge {
 public:
  Judge(const FileMapping& mapping, Time liftoff, const std::vector<PlausibleRow>& rows)
      : mapping_(mapping), kind_(mapping.kind), liftoff_(liftoff), rows_(rows) {}

  Plausibility run() {
    judge_times();
    if (kind_ == FileKind::Radar || kind_ == FileKind::Angles) {
      judge_angles(rows_with(&PlausibleRow::angles_valid));
      judge_range(rows_with(&PlausibleRow::range_valid));
    } else {
      judge_positions();
    }
    return std::move(found_);
  }

 private:
  void add(const std::string& text) { found_.line += (found_.line.empty() ? "" : ", ") + text; }
  void impossible(const std::string& text) {
    if (found_.impossible.empty()) found_.impossible = text;
  }
  void doubt(const std::string& text) { found_.doubts.push_back(text); }

  template <class Condition>
  [[nodiscard]] static bool for_most(const std::vector<PlausibleRow>& rows, Condition condition) {
    return 2 * std::count_if(rows.begin(), rows.end(), condition) > std::ssize(rows);
  }

  [[nodiscard]] std::vector<PlausibleRow> rows_with(bool PlausibleRow::*part) const {
    std::vector<PlausibleRow> rows;
    std::ranges::copy_if(rows_, std::back_inserter(rows), part);
    return rows;
  }

  void judge_times() {
    const auto since = [&](const PlausibleRow& r) { return (r.epoch - liftoff_).seconds(); };
    const Span times = span_of(rows_, since);
    add(show_time(times.least) + " to " + show_time(times.most));
    std::vector<double> steps;
    for (std::size_t i = 1; i < rows_.size(); ++i) {
      steps.push_back(std::abs((rows_[i].epoch - rows_[i - 1].epoch).seconds()));
    }
    if (const double step = median(std::move(steps)); step > 0) add(show_digits(1 / step, 4) + " rows/s");
    if (for_most(rows_, [&](const PlausibleRow& r) { return std::abs(since(r)) > far_from_liftoff_s; })) {
      impossible("its times are " + show_fixed(times.least / day_s, 1) + " days from lift-off, allowed up to " +
                 show_fixed(far_from_liftoff_s / day_s, 0) + ": " + what_of_times());
    }
    if (times.least > hour_s || times.most < -hour_s) {
      doubt("no row within an hour of lift-off: " + what_of_times());
    }
    if (kind_ == FileKind::Truth) return;
    std::vector<double> delays;
    for (const PlausibleRow& row : rows_) delays.push_back((row.received - row.epoch).seconds());
    const double delay_s = median(std::move(delays));
    if (delay_s < -0.001 || delay_s > hour_s) {
      doubt("rows are received " + show_fixed(std::abs(delay_s), 3) + " s " + (delay_s < 0 ? "before" : "after") +
            " their epoch: the same unit and time scale (time_scale)?");
    }
  }

  [[nodiscard]] std::string what_of_times() const {
    const std::string keys =
        times_are_text(rows_) ? "is liftoff right?" : "are liftoff, and unit and since of the times, right?";
    const std::string hint = time_hint(mapping_, liftoff_, rows_);
    return hint.empty() ? keys : keys + " They would be near it " + hint;
  }

  [[nodiscard]] const ColumnMapping* column(Field field) const { return mapping_.column_of(field); }

  void judge_angles(const std::vector<PlausibleRow>& rows) {
    if (rows.empty()) return;
    const auto azimuth = [](const PlausibleRow& r) { return r.polar.azimuth_rad; };
    const auto elevation = [](const PlausibleRow& r) { return r.polar.elevation_rad; };
    const Span az = span_of(rows, azimuth);
    const Span el = span_of(rows, elevation);
    add("azimuth " + show_span(az, deg, 2) + " deg");
    add("elevation " + show_span(el, deg, 2) + " deg");
    const auto fits = [&](double azimuth_ratio, double elevation_ratio) {
      return for_most(rows, [&](const PlausibleRow& r) {
        return std::abs(r.polar.elevation_rad * elevation_ratio) <= 90.001 * deg &&
               std::abs(r.polar.azimuth_rad * azimuth_ratio) <= 720 * deg;
      });
    };
    if (!fits(1, 1)) {
      impossible("its angles are azimuth " + show_span(az, deg, 1) + ", elevation " + show_span(el, deg, 1) +
                 " deg, beyond the zenith or turns round: " + what_of_angles(rows, fits));
    }
    const double turn = 2 * std::numbers::pi * deg;  // a turn of radians, taken as degrees
    const bool small = std::max(std::abs(az.least), std::abs(az.most)) <= turn &&
                       std::max(std::abs(el.least), std::abs(el.most)) <= turn / 4;
    const std::string radians = mistaken_unit(column(Field::Elevation), "deg", "rad");
    if (small && rows.size() > 1 && !radians.empty()) {
      doubt("every angle is small enough to be " + radians);
    }
  }

  template <class Fits>
  [[nodiscard]] std::string what_of_angles(const std::vector<PlausibleRow>& rows, Fits fits) const {
    const auto units = units_that_fit(column(Field::Elevation), [&](double ratio) { return fits(ratio, ratio); });
    if (for_most(rows, is_exchanged)) return "azimuth and elevation exchanged?";
    if (std::ranges::find(units, "deg") != units.end()) return mistaken_unit(column(Field::Elevation), "rad", "deg");
    if (for_most(rows, is_over_the_zenith)) {
      return "an antenna driven over the zenith (its plots are azimuth + 180, 180 - elevation), or another unit?";
    }
    return units.empty() ? "another unit, or azimuth and elevation exchanged?" : "another unit? " + show_units(units);
  }

  static bool is_exchanged(const PlausibleRow& row) {
    return std::abs(row.polar.azimuth_rad) <= 90.001 * deg && std::abs(row.polar.elevation_rad) <= 360.001 * deg;
  }

  static bool is_over_the_zenith(const PlausibleRow& row) {
    return std::abs(row.polar.azimuth_rad) <= 360.001 * deg && std::abs(row.polar.elevation_rad) <= 180.001 * deg;
  }

  void judge_range(const std::vector<PlausibleRow>& rows) {
    if (rows.empty()) return;
    const auto range = [](const PlausibleRow& r) { return r.polar.range_m; };
    const auto change = [&](const PlausibleRow& a, const PlausibleRow& b) { return range(b) - range(a); };
    const Span span = span_of(rows, range);
    add("range " + show_span(span, 1000, 3) + " km");
    const double speed = median_speed(rows, change);
    add(show_range_rate(speeds_of(rows, change), speed));
    constexpr double farthest_m = 100e6;
    if (speed > impossible_speed_m_s) {
      impossible("its range changes by " + show_speed_limit(speed) + what_is_too_fast(Field::Range, speed));
    } else if (span.least > farthest_m) {
      impossible("its ranges are " + show_span(span, 1000, 0) + " km, allowed up to " +
                 show_fixed(farthest_m / 1000, 0) +
                 " km: " + or_another_unit(smaller_unit(column(Field::Range), [&](double ratio) {
                   return span.least * ratio <= farthest_m;
                 })));
    }
    const std::string larger = larger_unit(column(Field::Range));
    if (span.most < small_m && rows.size() > 1) {
      doubt("no range above " + show_fixed(span.most, 1) + " m" + (larger.empty() ? "" : ": " + larger));
    }
  }

  static std::string show_speed_limit(double speed_m_s) {
    return show_fixed(speed_m_s / 1000, 0) + " km/s, allowed up to " + show_fixed(impossible_speed_m_s / 1000, 0) +
           " km/s: ";
  }

  static std::string or_another_unit(const std::string& advice) { return advice.empty() ? "another unit?" : advice; }

  /// Lengths too large, or times too small.
  [[nodiscard]] std::string what_is_too_fast(Field length, double speed_m_s) const {
    if (const std::string hint = time_hint_of_far_times(); !hint.empty()) {
      return "its times would be near lift-off " + hint;
    }
    const std::string of_length =
        smaller_unit(column(length), [&](double ratio) { return speed_m_s * ratio <= impossible_speed_m_s; });
    const std::string of_time = larger_unit(column(Field::Epoch));
    if (of_length.empty() && of_time.empty()) return "another unit of length or of time?";
    return of_length + (of_length.empty() || of_time.empty() ? "" : " Or ") + of_time;
  }

  [[nodiscard]] std::string time_hint_of_far_times() const {
    const Span times = span_of(rows_, [&](const PlausibleRow& r) { return (r.epoch - liftoff_).seconds(); });
    const bool far = times.least > hour_s || times.most < -hour_s;
    return far ? time_hint(mapping_, liftoff_, rows_) : std::string();
  }

  void judge_positions() {
    // A receiver without a fix gives zeros: the service's ingest judges them.
    std::vector<PlausibleRow> fixes;
    std::copy_if(rows_.begin(), rows_.end(), std::back_inserter(fixes), [](const PlausibleRow& r) {
      const Eigen::Vector3d& p = r.position.m;
      return p.norm() > 1 && !(p.y() == 0 && p.z() == 0);
    });
    if (fixes.size() < rows_.size()) add(std::to_string(rows_.size() - fixes.size()) + " positions of zeros");
    if (fixes.empty()) return;
    const double radius = median_of(fixes, [](const PlausibleRow& r) { return r.position.m.norm(); });
    if (!on_or_above_earth(radius)) {
      impossible("its positions are " + show_digits(radius / 1000, 3) + " km from the Earth's centre, allowed " +
                 show_fixed(earth_radius_least_m / 1000, 0) + " to " + show_fixed(farthest_radius_m / 1000, 0) +
                 " km: " + what_of_radius(radius));
      return;
    }
    const Span height = span_of(fixes, height_of);
    const auto degrees_of = [&](double Geodetic::*angle) {
      return span_of(fixes, [&](const PlausibleRow& r) { return geodetic_from_ecef(r.position).*angle / deg; });
    };
    const Span latitude = degrees_of(&Geodetic::latitude_rad);
    const Span longitude = degrees_of(&Geodetic::longitude_rad);
    add("latitude " + show_span(latitude, 1, 3) + ", longitude " + show_span(longitude, 1, 3) + " deg");
    add("height " + show_span(height, 1000, 3) + " km");
    const double moved = median_speed(fixes, travelled);
    add("moving " + show_fixed(moved, 0) + " m/s");
    if (moved > impossible_speed_m_s) {
      impossible("its positions move by " + show_speed_limit(moved) +
                 what_is_too_fast(mapping_.has(Field::X) ? Field::X : Field::Height, moved));
    }
    judge_places(latitude, longitude, fixes.size());
    judge_heights(fixes, height);
    judge_stated_speed(fixes, moved);
  }

  static bool on_or_above_earth(double radius_m) {
    return radius_m >= earth_radius_least_m && radius_m <= farthest_radius_m;
  }

  [[nodiscard]] std::string what_of_radius(double radius) const {
    if (mapping_.has(Field::Height)) return "another unit of height?";
    // Nearer than the geostationary satellites: where flights are.
    constexpr double near_earth_m = 50e6;
    const auto units = units_that_fit(column(Field::X), [&](double ratio) {
      return radius * ratio >= earth_radius_least_m && radius * ratio <= near_earth_m;
    });
    return units.empty() ? "another unit, or not Earth-fixed coordinates?" : "another unit? " + show_units(units);
  }

  /// As degrees, radians lie in a few degrees of the Gulf of Guinea.
  void judge_places(const Span& latitude, const Span& longitude, std::size_t count) {
    const std::string radians = mistaken_unit(column(Field::Latitude), "deg", "rad");
    constexpr double pi = std::numbers::pi;
    const bool small =
        latitude.least >= -pi / 2 && latitude.most <= pi / 2 && longitude.least >= -2 * pi && longitude.most <= 2 * pi;
    if (small && count > 1 && !radians.empty()) {
      doubt("every latitude and longitude is small enough to be " + radians);
    }
  }

  /// What flies fast and low does not stay level, but where its height is a thousandth.
  void judge_heights(const std::vector<PlausibleRow>& fixes, const Span& height) {
    const std::string larger = larger_unit(column(Field::Height));
    if (larger.empty() || height.most > small_m) return;
    std::vector<PlausibleRow> flown;
    std::ranges::copy_if(fixes, std::back_inserter(flown), [&](const PlausibleRow& r) { return r.epoch >= liftoff_; });
    const auto& judged = flown.size() > 1 ? flown : fixes;
    const double moved = median_speed(judged, travelled);
    const double climbed =
        median_speed(judged, [](const PlausibleRow& a, const PlausibleRow& b) { return height_of(b) - height_of(a); });
    constexpr double level = 0.02;
    if (moved < moving_m_s || climbed > level * moved) return;
    doubt("no height above " + show_fixed(height.most, 1) + " m while it moves by " + show_fixed(moved, 0) +
          " m/s: " + larger);
  }

  void judge_stated_speed(const std::vector<PlausibleRow>& fixes, double moved) {
    std::vector<double> stated;
    for (const PlausibleRow& row : fixes) {
      if (row.speed_m_s) stated.push_back(*row.speed_m_s);
    }
    if (stated.empty()) return;
    const double most = *std::max_element(stated.begin(), stated.end());
    const double middle = median(std::move(stated));
    add("stated up to " + show_fixed(most, 0) + " m/s");
    if (moved <= moving_m_s || (middle <= 5 * moved && middle >= moved / 5)) return;
    const auto units =
        units_that_fit(column(Field::Vx), [&](double ratio) { return std::abs(middle * ratio / moved - 1) < 0.1; });
    doubt("it moves by " + show_fixed(moved, 0) + " m/s and states " + show_fixed(middle, 0) +
          " m/s: another unit of its velocity?" + (units.empty() ? "" : " " + show_units(units)));
  }

  template <class Value>
  static double median_of(const std::vector<PlausibleRow>& rows, Value value) {
    std::vector<double> values;
    values.reserve(rows.size());
    for (const PlausibleRow& row : rows) values.push_back(value(row));
    return median(std::move(values));
  }

  const FileMapping& mapping_;
  FileKind kind_;
  Time liftoff_;
  const std::vector<PlausibleRow>& rows_;
  Plausibility found_;
};

}  // namespace

/// What can be without the rows of a sentinel is impossible, or doubtful, for its sake.
Plausibility judge_plausibility(const FileMapping& mapping, Time liftoff, const std::vector<PlausibleRow>& rows) {
  Plausibility found = Judge(mapping, liftoff, rows).run();
  const Sentinel sentinel = find_sentinel(mapping, rows);
  if (sentinel.what.empty()) return found;
  Plausibility without = Judge(mapping, liftoff, sentinel.rows).run();
  const bool cause = !found.impossible.empty() && without.impossible.empty();
  without.line = std::move(found.line);
  if (cause) without.impossible = sentinel.what;
  if (!cause) without.doubts.push_back(sentinel.what);
  return without;
}

}  // namespace downrange::archive
