#include "sample_series.hpp"

#include <algorithm>

namespace downrange::integrity {
namespace {

/// No more comes after this.
constexpr Duration patience = milliseconds(4000);
/// A series that begins, or goes on after a gap of the clock, does not begin earlier than this.
constexpr Duration horizon = milliseconds(6000);
constexpr Duration same_epoch = milliseconds(1);
/// One fix a second, at whatever phase, is in one window and no more: receivers of other phases can be compared.
constexpr Duration fix_step = milliseconds(1000);
constexpr Duration fix_half = milliseconds(500);
constexpr std::size_t raw_capacity = 512;
constexpr std::size_t sample_capacity = 150;  // 75 s: what was before a lie that is told late

std::size_t fewest(double rate_hz) { return rate_hz >= 8 ? 3 : 1; }

}  // namespace

double Sample::median_factor() const {
  // Exact up to five Gaussian values, then pi/2n; neighbours are not independent for ever.
  static constexpr std::array<double, 6> exact{1, 1, 0.5, 0.449, 0.298, 0.287};
  const auto n = static_cast<std::size_t>(std::max(measurements, 1));
  return n < exact.size() ? exact[n] : std::max(1.571 / static_cast<double>(n), 0.15);
}

SampleSeries::SampleSeries(double rate_hz, bool fixes)
    : period_(seconds(1 / rate_hz)),
      half_(fixes ? fix_half : std::max(milliseconds(250), Duration{period_.ns / 2})),
      step_{fixes ? fix_step : Duration{grid_step.ns * ((period_.ns + grid_step.ns - 1) / grid_step.ns)}},
      least_(fixes ? 1 : fewest(rate_hz)),
      fixes_(fixes),
      raw_(raw_capacity),
      samples_(sample_capacity) {}

void SampleSeries::note(const RawMeasurement& measurement) {
  newest_ = raw_.empty() ? measurement.epoch : std::max(newest_, measurement.epoch);
  raw_.push(measurement);
  if (!next_) next_ = ceil_to_grid(measurement.epoch, step_);
}

bool SampleSeries::knows(Time epoch) const {
  for (std::size_t i = 0; i < std::min<std::size_t>(raw_.size(), 16); ++i) {
    const Duration apart = epoch - raw_.newest(i).epoch;
    if (apart <= same_epoch && -apart <= same_epoch) return true;
  }
  return false;
}

std::optional<Time> SampleSeries::heard() const {
  if (raw_.empty()) return std::nullopt;
  return newest_;
}

std::optional<Time> SampleSeries::due(Time now) {
  if (!next_) return std::nullopt;
  if (now - *next_ > horizon) next_ = ceil_to_grid(now - horizon, step_);
  const Time at = *next_;
  if (at + half_ > now) return std::nullopt;
  // A radar's window is full when the next plot lies beyond it; a receiver's when there is a fix in it.
  bool full = newest_ + period_ > at + half_;
  for (std::size_t i = 0; fixes_ && i < raw_.size() && !full; ++i)
    full = raw_.newest(i).epoch > at - half_ && raw_.newest(i).epoch <= at + half_;
  return full || now - at > patience ? next_ : std::nullopt;
}

Sample SampleSeries::sample_of(Time at, const Vec<9>& motion, Picked& picked, const Vec<3>& predicted) {
  const std::size_t n = picked.count;
  Vec<3> median;
  for (int k = 0; k < 3; ++k) {
    std::array<double, max_picked> values;
    for (std::size_t i = 0; i < n; ++i) values[i] = picked.residual[i][k];
    std::sort(values.begin(), values.begin() + static_cast<std::ptrdiff_t>(n));
    median[k] = (values[(n - 1) / 2] + values[n / 2]) / 2;
  }
  const RawMeasurement& raw = *picked.last;
  Sample sample;
  sample.epoch = at;
  sample.z = predicted + median;
  sample.motion = motion;
  sample.measurements = static_cast<int>(n);
  sample.sigma_horizontal_m = raw.sigma_horizontal_m;
  sample.sigma_vertical_m = raw.sigma_vertical_m;
  sample.sigma_velocity_m_s = raw.sigma_velocity_m_s;
  sample.velocity_valid = raw.velocity_valid;
  if (raw.velocity_valid)
    sample.motion.segment<3>(3) = raw.velocity_m_s + (at - raw.epoch).seconds() * motion.tail<3>();
  return sample;
}

const Sample* SampleSeries::at(Time epoch) const {
  for (std::size_t i = 0; i < samples_.size(); ++i) {
    if (samples_.newest(i).epoch == epoch) return &samples_.newest(i);
    if (samples_.newest(i).epoch < epoch) return nullptr;
  }
  return nullptr;
}

}  // namespace downrange::integrity
