#include "config/odd_sites.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <downrange/stage/range_config.hpp>
#include <numeric>
#include <optional>
#include <vector>

namespace downrange::config {
namespace {

/// Sites of one range lie within this of each other: the longest ranges relay by islands some 2 500 km downrange.
constexpr double range_width_m = 3e6;

/// Nearer to the middle than this, a site is not far: ranges have their first stations downrange from here on. What is
/// nearer to another site than this has a neighbour.
constexpr double far_m = 3e5;

/// Undoing a slip must bring a site nearer by this factor. Swapped coordinates and wrong signs are few; digits and
/// decimal points can be wrong in so many ways that one of them brings many a place near by chance.
constexpr double much_nearer = 10;
constexpr double very_much_nearer = 30;

/// Anything of the file that has a latitude and a longitude.
struct Place {
  std::string path;  ///< "radar[0]"
  std::string name;  ///< its id, else its path
  double latitude_deg = 0;
  double longitude_deg = 0;
  Position<Ecef> position{};
};

Position<Ecef> ground_at(double latitude_deg, double longitude_deg) {
  const double rad = unit_of("_deg").to_si;
  return ecef_from_geodetic({latitude_deg * rad, longitude_deg * rad, 0});
}

double distance_m(const Position<Ecef>& a, const Position<Ecef>& b) { return (a - b).m.norm(); }

std::optional<Place> place_of(const toml::node& node, const std::string& path) {
  const toml::table* table = node.as_table();
  if (table == nullptr) return std::nullopt;
  const auto latitude = table->at_path("latitude_deg").value<double>();
  const auto longitude = table->at_path("longitude_deg").value<double>();
  if (!latitude || !longitude) return std::nullopt;
  return Place{path, table->at_path("id").value_or(path), *latitude, *longitude, ground_at(*latitude, *longitude)};
}

/// Of every table, so that a table that is new to the schema needs no line here.
std::vector<Place> places_of(const toml::table& root) {
  std::vector<Place> places;
  const auto add = [&](const toml::node& node, const std::string& path) {
    if (const auto place = place_of(node, path)) places.push_back(*place);
  };
  for (const auto& [key, node] : root) {
    const std::string name(key.str());
    add(node, name);
    const toml::array* entries = node.as_array();
    for (std::size_t i = 0; entries != nullptr && i < entries->size(); ++i)
      add(*entries->get(i), name + '[' + std::to_string(i) + ']');
  }
  return places;
}

/// The place that is nearest to all others: one that is far off does not move it.
const Place& middle_of(const std::vector<Place>& places) {
  const auto far_from_all = [&](const Place& from) {
    return std::accumulate(places.begin(), places.end(), 0.0,
                           [&](double sum, const Place& to) { return sum + distance_m(from.position, to.position); });
  };
  return *std::ranges::min_element(places, {}, far_from_all);
}

std::string coordinates(double latitude_deg, double longitude_deg) {
  return show_number(latitude_deg) + ", " + show_number(longitude_deg);
}

std::string kilometres(double m) {
  std::array<char, 32> text{};
  std::snprintf(text.data(), text.size(), "%.0f km", m / 1000);
  return text.data();
}

/// A slip undone.
struct Slip {
  const char* question;
  double latitude_deg;
  double longitude_deg;
  double nearer;  ///< by this factor at least, to be told of a site that may be where it is
  double away_m;  ///< from the middle
};

std::vector<Slip> slips_of(const Place& place, const Place& middle) {
  std::vector<Slip> slips;
  const auto add = [&](const char* question, double latitude_deg, double longitude_deg, double nearer) {
    if (std::abs(latitude_deg) > 90 || std::abs(longitude_deg) > 360) return;
    slips.push_back({question, latitude_deg, longitude_deg, nearer,
                     distance_m(ground_at(latitude_deg, longitude_deg), middle.position)});
  };
  const double latitude = place.latitude_deg;
  const double longitude = place.longitude_deg;
  add("latitude and longitude swapped?", longitude, latitude, much_nearer);
  add("the longitude's sign?", latitude, -longitude, much_nearer);
  add("the latitude's sign?", -latitude, longitude, much_nearer);
  for (const double factor : {0.1, 10.0}) {
    add("the latitude's decimal point?", factor * latitude, longitude, very_much_nearer);
    add("the longitude's decimal point?", latitude, factor * longitude, very_much_nearer);
  }
  for (int tens = -10; tens <= 10; ++tens) {
    add("a digit of the latitude?", latitude + 10 * tens, longitude, very_much_nearer);
    add("a digit of the longitude?", latitude, longitude + 10 * tens, very_much_nearer);
  }
  return slips;
}

/// The slip that put `place` so far from `middle`: the one whose undoing brings it nearest, of those that explain it.
std::optional<Slip> likely_slip(const Place& place, const Place& middle) {
  const double away = distance_m(place.position, middle.position);
  const auto explains = [away](const Slip& slip) {
    const bool of_a_range = away > range_width_m && slip.nearer == much_nearer && slip.away_m <= range_width_m;
    return of_a_range || slip.away_m * slip.nearer < away;
  };
  std::optional<Slip> likely;
  for (const Slip& slip : slips_of(place, middle))
    if (explains(slip) && (!likely || slip.away_m < likely->away_m)) likely = slip;
  return likely;
}

/// An antenna that no other site of the range is near, while the others are near each other. A radar or a station may
/// stand alone downrange, on an island 2 500 km away: it adds what the others do not see. An antenna alone there is
/// pointed by what others see, at a vehicle that they must see above both horizons; ranges put a source beside it.
bool stands_alone(const Place& place, const std::vector<Place>& places, const Place& middle) {
  if (!place.path.starts_with("antenna") || places.size() < 4) return false;
  std::vector<double> others_away;
  for (const Place& other : places) {
    if (&other == &place) continue;
    if (distance_m(other.position, place.position) <= far_m) return false;
    others_away.push_back(distance_m(other.position, middle.position));
  }
  const auto median = others_away.begin() + static_cast<std::ptrdiff_t>(others_away.size() / 2);
  std::ranges::nth_element(others_away, median);
  return distance_m(place.position, middle.position) > much_nearer * *median;
}

/// What is odd of a site, behind what it is and how far away; empty: nothing.
std::string oddity(const Place& place, const std::vector<Place>& places, const Place& middle) {
  const double away = distance_m(place.position, middle.position);
  if (away <= far_m) return {};
  std::string text;
  if (away > range_width_m) text = ", expected: at most " + kilometres(range_width_m);
  if (const auto slip = likely_slip(place, middle))
    return text + "; " + slip->question + ' ' + coordinates(slip->latitude_deg, slip->longitude_deg) + " is " +
           kilometres(slip->away_m) + " from it";
  if (text.empty() && stands_alone(place, places, middle))
    return ", and no other site within " + kilometres(far_m) + " of it, expected: a source near an antenna downrange";
  return text;
}

}  // namespace

void warn_of_sites(const toml::table& root, const Checker& warn) {
  const std::vector<Place> places = places_of(root);
  if (places.empty()) return;
  const Place& middle = middle_of(places);
  for (const Place& place : places) {
    const std::string odd = oddity(place, places, middle);
    warn.require(odd.empty(), place.path + ".latitude_deg",
                 "\"" + place.name + "\" at " + coordinates(place.latitude_deg, place.longitude_deg) + " is " +
                     kilometres(distance_m(place.position, middle.position)) + " from \"" + middle.name +
                     "\" in the middle of the range" + odd);
  }
}

}  // namespace downrange::config
