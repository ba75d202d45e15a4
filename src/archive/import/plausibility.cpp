#include <algorithm>
#include <archive/import/plausibility.hpp>
#include <archive/import/times.hpp>
#include <cmath>
#include <cstdarg>
#include <cstdio>
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

[[gnu::format(printf, 1, 2)]] std::string format(const char* pattern, ...) {
  char text[400];
  va_list arguments;
  va_start(arguments, pattern);
  std::vsnprintf(text, sizeof text, pattern, arguments);
  va_end(arguments);
  return text;
}

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

/// Median of |distance| / time between rows at least a second apart; the whole file where it is shorter.
template <class Distance>
double median_speed(const std::vector<PlausibleRow>& rows, Distance distance) {
  std::vector<double> speeds;
  std::size_t from = 0;
  for (std::size_t i = 1; i < rows.size(); ++i) {
    double time_s = std::abs((rows[i].epoch - rows[from].epoch).seconds());
    if (time_s < speed_baseline_s && (from > 0 || i + 1 < rows.size())) continue;
    if (time_s > 0) speeds.push_back(std::abs(distance(rows[from], rows[i])) / time_s);
    from = i;
  }
  return median(std::move(speeds));
}

std::string show_time(double seconds) {
  if (std::abs(seconds) < 2 * hour_s) return format("T%+.1f s", seconds);
  return format("T%+.2f h", seconds / hour_s);
}

class Judge {
 public:
  Judge(FileKind kind, Time liftoff, const std::vector<PlausibleRow>& rows)
      : kind_(kind), liftoff_(liftoff), rows_(rows) {}

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
    if (const double step = median(std::move(steps)); step > 0) add(format("%.4g rows/s", 1 / step));
    if (for_most(rows_, [&](const PlausibleRow& r) { return std::abs(since(r)) > far_from_liftoff_s; })) {
      impossible(format("its times are %.1f days from lift-off: is liftoff right? Are the times of another unit "
                        "(unit = ...) or counted from another moment (since = ...)?",
                        times.least / day_s) +
                 other_reference(times));
    }
    if (times.least > hour_s || times.most < -hour_s) {
      doubt("no row within an hour of lift-off: liftoff, unit and since of the times are right?" +
            other_reference(times));
    }
    if (kind_ == FileKind::Truth) return;
    std::vector<double> delays;
    for (const PlausibleRow& row : rows_) delays.push_back((row.received - row.epoch).seconds());
    const double delay_s = median(std::move(delays));
    if (delay_s < -0.001 || delay_s > hour_s) {
      doubt(format("rows are received %.3f s %s their epoch: the same unit and time scale (time_scale)?",
                   std::abs(delay_s), delay_s < 0 ? "before" : "after"));
    }
  }

  /// Where the same numbers, from another moment, would lie within an hour of lift-off.
  [[nodiscard]] std::string other_reference(const Span& times) const {
    const double liftoff_s = static_cast<double>(liftoff_.ns) * 1e-9;
    constexpr double gps_epoch_s = 315'964'800;
    const std::pair<const char*, double> references[] = {
        {"unix", liftoff_s}, {"gps", liftoff_s - gps_epoch_s}, {"midnight", std::fmod(liftoff_s, day_s)}};
    for (const auto& [since, at_s] : references) {
      if (times.least < at_s + hour_s && times.most > at_s - hour_s) {
        return std::string(" They would be near it with since = \"") + since + '"';
      }
    }
    if (const std::string packed = packed_times(times); !packed.empty()) return packed;
    // GPS weeks begin where GPS time does, on a Sunday.
    const double week_s = liftoff_s - std::fmod(liftoff_s - gps_epoch_s, 7 * day_s);
    if (times.least < liftoff_s - week_s + hour_s && times.most > liftoff_s - week_s - hour_s) {
      return " They would be near it as seconds of the GPS week: since = " +
             show_utc(Time{std::llround(week_s) * 1'000'000'000}).substr(0, 10) + "T00:00:00Z, time_scale = \"GPS\"";
    }
    if (times.least > 0 && times.most < 1000 * hour_s && times.least > hour_s)
      return " In ms they would be near it (unit = \"ms\")";
    return {};
  }

  /// The first time's number, from lift-off or from midnight, read as hhmmss.
  [[nodiscard]] std::string packed_times(const Span& times) const {
    const double of_day_s = std::fmod(static_cast<double>(liftoff_.ns) * 1e-9, day_s);
    for (const double number : {times.least, times.least + of_day_s}) {
      const auto clock = number >= 0 && number < 240'000 ? unpacked_clock(format("%.3f", number)) : std::nullopt;
      const auto read = clock ? parse_clock(*clock) : std::nullopt;
      if (read && std::abs(static_cast<double>(read->ns) * 1e-9 - of_day_s) < hour_s) {
        return " They would be near it as hhmmss: unit = \"hhmmss\", since = \"midnight\"";
      }
    }
    return {};
  }

  void judge_angles(const std::vector<PlausibleRow>& rows) {
    if (rows.empty()) return;
    const auto azimuth = [](const PlausibleRow& r) { return r.polar.azimuth_rad; };
    const auto elevation = [](const PlausibleRow& r) { return r.polar.elevation_rad; };
    const Span az = span_of(rows, azimuth);
    const Span el = span_of(rows, elevation);
    add(format("azimuth %.2f to %.2f deg", az.least / deg, az.most / deg));
    add(format("elevation %.2f to %.2f deg", el.least / deg, el.most / deg));
    const bool beyond = for_most(rows, [](const PlausibleRow& r) {
      return std::abs(r.polar.elevation_rad) > 90.001 * deg || std::abs(r.polar.azimuth_rad) > 720 * deg;
    });
    if (beyond) {
      impossible(format(
          "its angles are azimuth %.1f to %.1f, elevation %.1f to %.1f deg, beyond the zenith or turns "
          "round: degrees taken as radians (write unit = \"deg\"), another unit, or azimuth and elevation exchanged?",
          az.least / deg, az.most / deg, el.least / deg, el.most / deg));
    }
    const double turn = 2 * std::numbers::pi * deg;  // a turn of radians, taken as degrees
    const bool small = std::max(std::abs(az.least), std::abs(az.most)) <= turn &&
                       std::max(std::abs(el.least), std::abs(el.most)) <= turn / 4;
    if (small && rows.size() > 1) {
      doubt("every angle is small enough to be radians taken as degrees: unit = \"rad\"?");
    }
  }

  void judge_range(const std::vector<PlausibleRow>& rows) {
    if (rows.empty()) return;
    const auto range = [](const PlausibleRow& r) { return r.polar.range_m; };
    const Span span = span_of(rows, range);
    add(format("range %.3f to %.3f km", span.least / 1000, span.most / 1000));
    const double speed =
        median_speed(rows, [&](const PlausibleRow& a, const PlausibleRow& b) { return range(b) - range(a); });
    add(format("closing %.0f m/s", speed));
    if (speed > impossible_speed_m_s) {
      impossible(
          format("its range changes by %.0f km/s: metres taken as kilometres, or milliseconds as seconds? "
                 "Write the unit that the column has",
                 speed / 1000));
    } else if (span.least > 100e6) {
      impossible(
          format("its ranges are %.0f to %.0f km: metres taken as kilometres?", span.least / 1000, span.most / 1000));
    }
    if (span.most < 1000 && rows.size() > 1) {
      doubt(format("no range above %.1f m: kilometres taken as metres (unit = \"km\")?", span.most));
    }
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
    if (radius < earth_radius_least_m || radius > 1e9) {
      impossible(
          format("its positions are %.3g km from the Earth's centre: another unit (unit = \"km\"), or not "
                 "Earth-fixed coordinates?",
                 radius / 1000));
      return;
    }
    const Span height = span_of(fixes, [](const PlausibleRow& r) { return geodetic_from_ecef(r.position).height_m; });
    const auto degrees_of = [&](double Geodetic::*angle) {
      return span_of(fixes, [&](const PlausibleRow& r) { return geodetic_from_ecef(r.position).*angle / deg; });
    };
    const Span latitude = degrees_of(&Geodetic::latitude_rad);
    const Span longitude = degrees_of(&Geodetic::longitude_rad);
    add(format("latitude %.3f to %.3f, longitude %.3f to %.3f deg", latitude.least, latitude.most, longitude.least,
               longitude.most));
    add(format("height %.3f to %.3f km", height.least / 1000, height.most / 1000));
    const double moved = median_speed(
        fixes, [](const PlausibleRow& a, const PlausibleRow& b) { return (b.position.m - a.position.m).norm(); });
    add(format("moving %.0f m/s", moved));
    if (moved > impossible_speed_m_s) {
      impossible(format("its positions move by %.0f km/s: another unit of length or of time?", moved / 1000));
    }
    judge_stated_speed(fixes, moved);
  }

  void judge_stated_speed(const std::vector<PlausibleRow>& fixes, double moved) {
    std::vector<double> stated;
    for (const PlausibleRow& row : fixes) {
      if (row.speed_m_s) stated.push_back(*row.speed_m_s);
    }
    if (stated.empty()) return;
    const double most = *std::max_element(stated.begin(), stated.end());
    const double middle = median(std::move(stated));
    add(format("stated up to %.0f m/s", most));
    constexpr double moving = 50;
    if (moved > moving && (middle > 5 * moved || middle < moved / 5)) {
      doubt(format("it moves by %.0f m/s and states %.0f m/s: another unit of its velocity?", moved, middle));
    }
  }

  template <class Value>
  static double median_of(const std::vector<PlausibleRow>& rows, Value value) {
    std::vector<double> values;
    values.reserve(rows.size());
    for (const PlausibleRow& row : rows) values.push_back(value(row));
    return median(std::move(values));
  }

  FileKind kind_;
  Time liftoff_;
  const std::vector<PlausibleRow>& rows_;
  Plausibility found_;
};

}  // namespace

Plausibility judge_plausibility(FileKind kind, Time liftoff, const std::vector<PlausibleRow>& rows) {
  return Judge(kind, liftoff, rows).run();
}

}  // namespace downrange::archive
