#include <algorithm>
#include <cmath>

#include "config/section.hpp"
#include "config/sections.hpp"

namespace downrange::config {
namespace {

using Pair = std::array<double, 2>;

/// A list of lists of two numbers; nothing when it is not that.
std::optional<std::vector<Pair>> read_pairs(const toml::node& node) {
  const toml::array* rows = node.as_array();
  if (rows == nullptr) return std::nullopt;
  std::vector<Pair> pairs;
  for (const toml::node& row : *rows) {
    const toml::array* cells = row.as_array();
    if (cells == nullptr || cells->size() != 2) return std::nullopt;
    Pair pair{};
    for (std::size_t i = 0; i < pair.size(); ++i) {
      const auto value = read_number(*cells->get(i), {-1e9, 1e9});
      if (!value) return std::nullopt;
      pair[i] = *value;
    }
    pairs.push_back(pair);
  }
  return pairs;
}

std::string show_pairs(const std::vector<Pair>& pairs) {
  std::string text;
  for (const auto& [a, b] : pairs) text += (text.empty() ? "[" : ", [") + show_number(a) + ", " + show_number(b) + ']';
  return '[' + text + ']';
}

Key<BoundaryConfig> vertices_key() {
  return {{"vertices_deg",
           "a list of [latitude, longitude], 3 to " + std::to_string(GroundPolygon::max_vertices) +
               ", latitude from -90 to 90, longitude from -180 to 360 deg",
           required, "corners of the polygon, either way around; edges are geodesics, and do not cross"},
          [](BoundaryConfig& boundary, const toml::node& node) {
            const auto pairs = read_pairs(node);
            if (!pairs || pairs->size() < 3 || pairs->size() > GroundPolygon::max_vertices + 1) return false;
            const double rad = unit_of("_deg").to_si;
            std::vector<GroundPoint> vertices;
            for (const auto& [latitude, longitude] : *pairs) {
              if (std::abs(latitude) > 90 || longitude < -180 || longitude > 360) return false;
              vertices.push_back({latitude * rad, longitude * rad});
            }
            boundary.vertices = std::move(vertices);
            return true;
          },
          [](const BoundaryConfig& boundary) {
            const double rad = unit_of("_deg").to_si;
            std::vector<Pair> pairs;
            for (const GroundPoint& p : boundary.vertices)
              pairs.push_back({p.latitude_rad / rad, p.longitude_rad / rad});
            return show_pairs(pairs);
          }};
}

Key<ImpactConfig> data_loss_key() {
  return {{"data_loss_s", "a list of [T+ in s, limit in s], T+ increasing from -1e9 to 1e9, limits from 0.1 to 3600",
           optional,
           "how long a vehicle may go on without data, by time after lift-off; linear in between, the first and the "
           "last hold before and after; empty: no limit"},
          [](ImpactConfig& impact, const toml::node& node) {
            const auto pairs = read_pairs(node);
            if (!pairs) return false;
            std::vector<DataLossLimit> table;
            for (const auto& [t_plus, limit] : *pairs) {
              if (!(limit >= 0.1 && limit <= 3600) || (!table.empty() && !(t_plus > table.back().t_plus_s)))
                return false;
              table.push_back({.t_plus_s = t_plus, .limit_s = limit});
            }
            impact.data_loss = std::move(table);
            return true;
          },
          [](const ImpactConfig& impact) {
            std::vector<Pair> pairs;
            for (const DataLossLimit& row : impact.data_loss) pairs.push_back({row.t_plus_s, row.limit_s});
            return show_pairs(pairs);
          }};
}

}  // namespace

Section impact_section() {
  using I = ImpactConfig;
  return single<I>("impact", "Where a vehicle falls when its engines stop now (in vacuum).",
                   [](ServiceConfig& c) -> I& { return c.range.impact; },
                   {
                       flag("enabled", at(&I::enabled), optional, "tell it, ten times a second (downrange/impact)"),
                       number("height_m", at(&I::fall, &FallSettings::height_m), {-500, 1e5}, optional,
                              "of the ground that it falls to, above the WGS-84 ellipsoid"),
                       number("horizon_s", at(&I::fall, &FallSettings::horizon_s), {10, 14'400}, optional,
                              "what does not come down by then does not: an orbit"),
                       data_loss_key(),
                   });
}

Section boundary_section() {
  using B = BoundaryConfig;
  return many<B>("boundary", 0, "A closed line on the ground that impact points are held against; at most 32.",
                 [](ServiceConfig& c) -> std::vector<B>& { return c.range.boundaries; },
                 {
                     id("id", at(&B::id), required, "boundary_id on the topics"),
                     vertices_key(),
                 });
}

}  // namespace downrange::config
