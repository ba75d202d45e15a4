#include <algorithm>
#include <array>
#include <cassert>
#include <downrange/est/model/bias_terms.hpp>
#include <numbers>

namespace downrange {

std::string_view to_string(BiasTerm term) {
  static constexpr std::array<std::string_view, bias_term_count> names{
      "offset_south",  "offset_east",     "offset_zenith",  "scale_south",      "scale_east",
      "scale_zenith",  "offset_range",    "offset_azimuth", "offset_elevation", "scale_range",
      "scale_azimuth", "scale_elevation", "time_tag"};
  return names.at(static_cast<std::size_t>(term));
}

std::string_view to_string(BiasState state) {
  static constexpr std::array<std::string_view, 4> names{"estimating", "converged", "not observable", "frozen"};
  return names.at(static_cast<std::size_t>(state));
}

BiasModel bias_model(std::span<const BiasBlock> blocks) {
  constexpr double deg = std::numbers::pi / 180;
  BiasModel model;
  const auto add = [&model](std::initializer_list<BiasTerm> terms, double sigma) {
    for (const BiasTerm term : terms) {
      const auto i = static_cast<Eigen::Index>(term);
      if (std::ranges::find(model.terms, term) == model.terms.end()) model.terms.push_back(term);
      model.prior_cov(i, i) = sigma * sigma;
    }
  };
  using enum BiasTerm;
  for (const BiasBlock block : blocks) {
    switch (block) {
      case BiasBlock::Polar:
        add({OffsetRange}, 100);
        add({OffsetAzimuth, OffsetElevation}, 0.2 * deg);
        add({ScaleRange}, 1e-4);
        add({ScaleAzimuth, ScaleElevation}, 1e-3);
        break;
      case BiasBlock::SezOffset:
        add({OffsetSouth, OffsetEast, OffsetZenith}, 100);
        break;
      case BiasBlock::SezScale:
        add({ScaleSouth, ScaleEast, ScaleZenith}, 3e-4);
        break;
      case BiasBlock::Time:
        add({TimeTag}, 0.02);
        break;
    }
  }
  std::ranges::sort(model.terms);
  return model;
}

BiasModel bias_model(std::initializer_list<BiasBlock> blocks) {
  return bias_model(std::span<const BiasBlock>(blocks.begin(), blocks.size()));
}

Polar compensate(const Polar& measured, std::span<const BiasTerm> term, std::span<const double> value) {
  assert(term.size() == value.size());
  std::array<double, bias_term_count> b{};
  for (std::size_t i = 0; i < term.size(); ++i) b[static_cast<std::size_t>(term[i])] = value[i];
  const auto of = [&](BiasTerm t) { return b[static_cast<std::size_t>(t)]; };

  const Rotation<Sez, Enu> R_sez_enu = sez_from_enu();
  Displacement<Sez> d = R_sez_enu * enu_from_polar(measured);
  const Eigen::Vector3d offset(of(BiasTerm::OffsetSouth), of(BiasTerm::OffsetEast), of(BiasTerm::OffsetZenith));
  const Eigen::Vector3d scale(of(BiasTerm::ScaleSouth), of(BiasTerm::ScaleEast), of(BiasTerm::ScaleZenith));
  d.m -= offset + scale.cwiseProduct(d.m);

  Polar q = polar_from_enu(R_sez_enu.inverse() * d);
  q.range_m -= of(BiasTerm::OffsetRange) + of(BiasTerm::ScaleRange) * q.range_m;
  q.azimuth_rad = wrap_two_pi(q.azimuth_rad - of(BiasTerm::OffsetAzimuth) -
                              of(BiasTerm::ScaleAzimuth) * wrap_pi(q.azimuth_rad - std::numbers::pi));
  q.elevation_rad -= of(BiasTerm::OffsetElevation) + of(BiasTerm::ScaleElevation) * q.elevation_rad;
  return q;
}

}  // namespace downrange
