#include "score/outliers.hpp"

#include <algorithm>
#include <cmath>

#include "score/errors.hpp"

namespace downrange::score {
namespace {

constexpr double most_sigmas = 10;
constexpr Duration bin = milliseconds(10'000);
constexpr std::size_t fewest = 5;  ///< plots whose median says something: two of them may be outliers

double median_of(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

}  // namespace

OutlierFinder::OutlierFinder(const RangeConfig& range, TruthFunction truth) : truth_(std::move(truth)) {
  for (const Source& source : SourceTable(range))
    instruments_[source.name] = {source.site,
                                 {source.sigma.range_m, source.sigma.azimuth_rad, source.sigma.elevation_rad}};
}

void OutlierFinder::add(const Name& sensor, std::uint64_t sequence, Time epoch, const Plot& measured) {
  const auto found = instruments_.find(sensor);
  const auto state = truth_(epoch);
  if (found == instruments_.end() || !state) return;
  const Instrument& instrument = found->second;
  const Eigen::Vector3d error = plot_error(measured.measured, polar_from_enu(instrument.site.enu_of(state->position)));
  Judged plot{sequence, {}};
  for (std::size_t k = 0; k < 3; ++k) {
    const bool has = (k == 0 ? measured.range_valid : measured.angles_valid) && instrument.sigma[k] > 0;
    if (has) plot.sigmas[k] = error[static_cast<Eigen::Index>(k)] / instrument.sigma[k];
    if (!std::isfinite(plot.sigmas[k])) return;
  }
  bins_[{sensor, epoch.ns / bin.ns}].push_back(plot);
}

std::set<MessageId> OutlierFinder::outliers() const {
  std::set<MessageId> outliers;
  for (const auto& [key, plots] : bins_) {
    if (plots.size() < fewest) continue;
    for (std::size_t k = 0; k < 3; ++k) {
      std::vector<double> sigmas;
      sigmas.reserve(plots.size());
      for (const Judged& plot : plots) sigmas.push_back(plot.sigmas[k]);
      const double median = median_of(std::move(sigmas));
      for (const Judged& plot : plots)
        if (std::abs(plot.sigmas[k] - median) > most_sigmas) outliers.emplace(key.first, plot.sequence);
    }
  }
  return outliers;
}

}  // namespace downrange::score
